"""What people read about their accounts: linked by a code, taken away, and why not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import lasting, listed
from rosic.core.i18n import said
from rosic.core.language.sanitise import clean_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import Address

# ---- why not ----

NO_ACCOUNT: Final = said("Write /link in your own chat with me on a messenger. Nothing was done.")
NO_CODE: Final = said(
    "That code is not good any more. Ask for a new one with /link. Nothing was done."
)
OWN: Final = said(
    "You are the same person here already. Say the code in the chat of your other account; it is "
    "still good."
)
TAKEN: Final = said(
    "This account is known here already, so it cannot become one more of somebody else's. Nothing "
    "was done, and the code is not good any more. An admin can help."
)
NOT_THEIRS: Final = said("There is no such account. Nothing was done.")
LAST: Final = said(
    "That is the only account, so it cannot be taken away: it is the access that would have to "
    "end, with /revoke. Nothing was done."
)
IN_GROUP: Final = said("Write /link to me alone: whoever reads the code acts as you.")
SAY_IT_THERE: Final = said(
    "Say the code in the chat of your other account, the one that I do not know yet. Here, /link "
    "alone gives a code."
)


def too_many(most: int) -> str:
    """Return that somebody has as many accounts as anybody may have."""
    return said(
        "You have {most} accounts, and nobody has more. Take one away first: /unlink. Nothing was "
        "done.",
        most=most,
    )


# ---- accounts ----


def account_shown(address: Address) -> str:
    """Return an account as people read it: ``Memory 1001``; for private chats only."""
    return f"{address.platform.capitalize()} {clean_name(address.account)}"


def accounts_shown(addresses: Iterable[Address], here: Address | None = None) -> str:
    """Return accounts in a row; the one in which it is read is marked."""
    return listed(
        [
            said("{account} (here)", account=account_shown(one))
            if one == here
            else account_shown(one)
            for one in addresses
        ]
    )


# ---- linking ----


def code(shown: str, lasts_s: float) -> str:
    """Return what whoever asks reads, the code included, once."""
    return said(
        "Your code: {code}\nSay it to me in a private chat of your other account, within "
        "{lasting}: link {code}\nFrom then on both accounts are you. Whoever says it acts as you, "
        "so show it to nobody; nobody here ever asks for it.",
        code=shown,
        lasting=lasting(lasts_s),
    )


def link_to_open(messenger: str, link: str) -> str:
    """Return a link that opens the other chat and hands the code in."""
    return said("On {messenger}: {link}", messenger=messenger.capitalize(), link=link)


def linked_here(name: str, accounts: str) -> str:
    """Return what is read in the account that was linked."""
    return said(
        "This account belongs to {name} now, with {accounts}. You are one person here, with the "
        "same rights, times and limits in each. If that is not you, take this account away.",
        name=name,
        accounts=accounts,
    )


def linked_there(account: str) -> str:
    """Return what the person reads in their other chats."""
    return said(
        "{account} is now one of your accounts: whoever writes there acts as you. If that was not "
        "you, take it away at once.",
        account=account,
    )


def linked_of(name: str, account: str) -> str:
    """Return what the admins read."""
    return said("{name} has one more account now: {account}.", name=name, account=account)


def code_used(account: str) -> str:
    """Return what somebody reads whose code came from an account that is somebody's."""
    return said(
        "Your code for another account came from {account}, which is known here already. Nothing "
        "was linked, and the code is not good any more. If that was not you, somebody has read it.",
        account=account,
    )


CODE_SHOWN: Final = said(
    "Your code for another account was shown in a group. It is not good any more. Ask for a new "
    "one with /link, and say it in a private chat."
)

# ---- taking away ----

THE_OPERATOR: Final = said("The operator")

TAKE_AWAY: Final = said("Take it away")


def your_accounts(accounts: str) -> str:
    """Return a line of /me."""
    return said("Your accounts: {accounts}.", accounts=accounts)


def which_account(accounts: str) -> str:
    """Return the question which account is to go."""
    return said("Which account shall be taken away? Yours are {accounts}.", accounts=accounts)


def which_account_of(name: str, accounts: str) -> str:
    """Return the question which account of somebody else is to go."""
    return said(
        "Which account of {name} shall be taken away? There are {accounts}.",
        name=name,
        accounts=accounts,
    )


def only_one(account: str) -> str:
    """Return that there is nothing to take away, and how there would be."""
    return said(
        "You have one account here: {account}. /link gives a code for another one.",
        account=account,
    )


def sure_of_own(account: str) -> str:
    """Return the question before somebody takes an account of their own away."""
    return said(
        "Take {account} away from you? Whoever writes there is a stranger from then on, and every "
        "browser of yours is signed out. What robots do goes on; a stop ends it.",
        account=account,
    )


def sure_of(name: str, account: str) -> str:
    """Return the question before an account of somebody else is taken away."""
    return said(
        "Take {account} away from {name}? They stay who they are in their other accounts. What "
        "robots do goes on; a stop ends it.",
        account=account,
        name=name,
    )


def unlinked(account: str) -> str:
    """Return what whoever took an account away reads."""
    return said("{account} is taken away. Whoever writes there is a stranger now.", account=account)


def unlinked_here(name: str) -> str:
    """Return what is read in the account that was taken away."""
    return said("This account does not belong to {name} any more.", name=name)


def unlinked_there(account: str) -> str:
    """Return what the person reads in their other chats."""
    return said("{account} is not one of your accounts any more.", account=account)


def unlinked_by(account: str, by: str) -> str:
    """Return what the person reads in their other chats when somebody else did it."""
    return said(
        "{by} has taken {account} away: it is not one of your accounts any more.",
        account=account,
        by=by,
    )


def unlinked_of(by: str, name: str, account: str) -> str:
    """Return what the admins read."""
    return said(
        "{by} has taken the account {account} of {name} away.", by=by, account=account, name=name
    )
