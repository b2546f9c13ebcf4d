"""Every sentence about people that a chat is told here; the rooms' own are in the rooms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.words_entry import DAY_S, given, listed
from rosic.core.language.cleaning import quote
from rosic.core.message import Button
from rosic.core.saying import said

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.roles import Grant

LEAVE_IT: Final = "Leave it"
MOST_NAMED: Final = 6

# ---- coming in ----

JOIN: Final = "Join"
NOT_ME: Final = "Not me"
BACK: Final = "back"
REOPEN: Final = "reopen"
TAKE_BACK_S: Final = DAY_S
REOPEN_ROW: Final = (Button("Open joining again", f"/invite {REOPEN}"),)
ANSWERED: Final = "This was answered before. Nothing was done."
OPEN_AGAIN: Final = "This button is too old. Nothing was done. Tap the link or send the code again."
NOT_ME_SAID: Final = "Nothing was done. Whoever invited has been told that it was not for you."
NOT_WRITTEN: Final = (
    "I cannot write this down now, so you are not in yet. Your code is still good: send it again "
    "in a while. The operator has to look."
)
NOBODY_TO_ASK: Final = "I can reach no admin now, so ask one yourself."

_READ_ALONG: Final = {
    "local": "",
    "e2ee-verified": "who writes when, but not what (the messages are end-to-end encrypted)",
    "provider-readable": "everything here ({platform} is not end-to-end encrypted)",
}


def invited(what: str, platform: str, assurance: str) -> str:
    """Return what a newcomer reads before they join."""
    # What is not known is taken for the worst.
    reads = _READ_ALONG.get(assurance, _READ_ALONG["provider-readable"])
    lines = [f"Hello. You are invited as {what}."]
    if reads:
        said = reads.format(platform=platform.capitalize())
        lines.append(f"What the chat operator can read: {said}.")
    return "\n".join(lines)


def is_in(name: str, what: str) -> str:
    """Return what whoever invited reads."""
    return f"{name} is in, as {what}."


def not_for_them(what: str) -> str:
    """Return what whoever invited reads after a tap on Not me."""
    return (
        f"Your invitation as {what} reached somebody who says that it is not for them. "
        "Its code is still good. Take it back if you sent it to the wrong person."
    )


def take_back_button(invitation: str) -> Button:
    """Return the button that ends an invitation."""
    return Button("Take it back", f"/invite {BACK} {invitation}")


# ---- letting in ----


def let_in_label(name: str) -> str:
    """Return the label of the one button."""
    return f"Let {name or 'them'} in"


def decline_label(name: str) -> str:
    """Return the label of the other button."""
    return f"Not {name}" if name else "No"


def let_in(name: str, what: str) -> str:
    """Return what the admin reads who let somebody in."""
    return f"{name} is in, as {what}."


def was_let_in(by: str, name: str, what: str) -> str:
    """Return what the other admins read."""
    return f"{by} let {name} in, as {what}."


def not_let_in(name: str) -> str:
    """Return what the admin reads who did not let somebody in."""
    return f"{name} is not in, and has been told."


def was_not_let_in(by: str, name: str) -> str:
    """Return what the other admins read."""
    return f"{by} did not let {name} in."


def who_waits(names: Sequence[str]) -> str:
    """Return what is said to an answer that names nobody."""
    if not names:
        return "Nobody waits to come in. Nothing was done."
    return f"Whom? {listed(names[:MOST_NAMED])} {_waits(names)} to come in. Nothing was done."


def _waits(names: Sequence[str]) -> str:
    return "waits" if len(names) == 1 else "wait"


# ---- rights about people ----

_ACTS: Final = {
    "invite": "Inviting people and letting them in",
    "lock": "Locking and unlocking people",
    "people": "Looking after people",
}


def not_yours(verb: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not do something with people, and who can."""
    return f"{_ACTS[verb]} is for admins. {_can(helpers)} Nothing was done."


def too_much(what: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not give that much."""
    return (
        f"You cannot give {what}: it is more than you may give. {_can(helpers)} Nothing was done."
    )


def _can(helpers: Sequence[str]) -> str:
    return f"{' or '.join(helpers)} can." if helpers else "The operator of this place can."


# ---- inviting ----

LINE_TOO_LONG: Final = "That line is longer than any invitation. Nothing was done."
TAKEN_BACK: Final = "Taken back: that code lets nobody in any more."
REOPENED: Final = "Joining is open again."
UNWRITTEN: Final = (
    "I could not write this down: it holds until ROSIC is restarted. The operator has to look."
)


def noted(sentence: str, *, written: bool) -> str:
    """Return what was done, and whether it will last."""
    return sentence if written else f"{sentence} {UNWRITTEN}"


def how_to_invite(roles: Sequence[str], robots: Mapping[str, object]) -> str:
    """Return how to invite, with an example of this place."""
    role = "operator" if "operator" in roles else next(iter(roles), "viewer")
    robot = f" {next(iter(robots))}" if robots else ""
    return (
        f"Say as what, where, and for how long: /invite {role}{robot} for 2h\n"
        "Without a robot it is good everywhere, without a time until it is taken back. "
        "Also: with speed <= 0.2 m/s (a limit), code 30 min (how long the code is good), as NAME "
        "(how they are shown), confirm (an admin has to let them in).\n"
        f"Roles here: {listed(roles)}."
    )


def how_to_join(link: str, text: str) -> str:
    """Return how the code is handed in."""
    if link:
        return f"{link}\nOr let them send me, in a private chat: {text}"
    return f"Let them send me, in a private chat: {text}"


def no_role(roles: Sequence[str]) -> str:
    """Return what is missing in an invitation."""
    return f"As what? The roles here are {listed(roles)}. Nothing was done."


def no_role_no_robot(word: str, close: Sequence[str]) -> str:
    """Return which word means nothing."""
    meant = f" Did you mean {' or '.join(close)}?" if close else ""
    return f"I know no role and no robot called {quote(word)}.{meant} Nothing was done."


def no_length(which: str, word: str) -> str:
    """Return which length cannot be read."""
    said = f"I cannot read {quote(word)} as a length of time" if word else "How long"
    mark = "." if word else "?"
    return f"{said}{mark} Write {which} 2h, {which} 30 min or {which} 3 days. Nothing was done."


def twice_how_long(which: str) -> str:
    """Return what is said about two lengths."""
    return f'That says "{which}" twice. Nothing was done.'


# ---- naming people ----


def nobody_called(said: str) -> str:
    """Return that nobody has this name."""
    return f"I know nobody called {quote(said)}. Nothing was done."


def several(count: int, said: str) -> str:
    """Return the question which of several."""
    return f"{count} people are called {quote(said)}. Which one?"


def several_in_group(count: int, said: str) -> str:
    """Return the same where others read along."""
    return (
        f"{count} people are called {quote(said)}. Ask me in a private chat, where I can show you "
        "which. Nothing was done."
    )


def told_apart(name: str, roles: Sequence[str]) -> str:
    """Return the label of one of several."""
    return f"{name}, {listed(roles) if roles else 'without a role of their own'}"


# ---- ending access ----

REVOKE: Final = "Revoke"
LOCK_ME: Final = "Lock me"
HOW_TO_REVOKE: Final = "Whose access shall end for good? Write for example: /revoke NAME"
HOW_TO_LOCK: Final = (
    "Who shall be locked out at once? Write: /lock NAME, or /lock me. What they move stops."
)
LOCK_LAST: Final = (
    "You are the only admin here. Once you are locked, only the operator of this place can unlock "
    "you. Lock yourself?"
)
LOCKED_YOURSELF: Final = (
    "You are locked: nothing you send is carried out until another admin unlocks you."
)


def revoke_question(name: str, what: str) -> str:
    """Return the question before somebody's access ends."""
    return (
        f"End the access of {name}{f' ({what})' if what else ''} for good? What they move stops, "
        "and their codes let nobody in any more."
    )


def no_access(name: str) -> str:
    """Return that there is nothing to take."""
    return f"{name} has no access any more. Nothing was done."


def last_admin(name: str) -> str:
    """Return why somebody cannot go."""
    return f"{name} is the last admin here. Make somebody else an admin first. Nothing was done."


def was_revoked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return f"{by} ended the access of {name}."


def was_locked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return f"{by} locked {name}." if by != name else f"{by} locked their own access."


def was_unlocked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return f"{by} unlocked {name}."


def you_are_unlocked(by: str) -> str:
    """Return what somebody reads who was locked."""
    return f"{by} unlocked you. You may do again what you could before."


def how_to_unlock(names: Sequence[str]) -> str:
    """Return how to unlock, and who is locked."""
    who = f" Locked now: {listed(names[:MOST_NAMED])}." if names else ""
    return f"Who shall have their access back? Write: /unlock NAME.{who}"


# ---- a phone ----

HOW_TO_RESET: Final = "Whose phone shall be forgotten? Write: /authenticator reset NAME"
NO_PHONE: Final = "Authenticator: not set up. /authenticator begins."
PHONE_SET_UP: Final = "Authenticator: set up. I ask for a code before dangerous things."
PHONE_PROVEN: Final = "Authenticator: set up, and your code was given in this chat lately."


SCAN = said("Or let the app on another device scan the picture.")


def set_up(uri: str, key: str) -> str:
    """Return what somebody reads who sets a phone up; it holds the secret."""
    return (
        "On the phone with your authenticator app, tap this link:\n"
        f"{uri}\n"
        f"Or type this key there: {key}\n"
        "Then send me the six digits that it shows, so: /code 123456. Delete this message "
        "afterwards: whoever reads it can make your codes."
    )


def phone_reset(name: str) -> str:
    """Return what the admin reads after resetting a phone."""
    return f"The phone of {name} is forgotten. They can set up another with /authenticator."


def your_phone_was_reset(by: str) -> str:
    """Return what the person reads."""
    return f"{by} reset your authenticator. /authenticator sets up another phone."


# ---- who is who ----


def you_are(name: str) -> str:
    """Return the first line of /me."""
    return f"You are {name}."


def grant(held: Grant, limits: Sequence[str], until: str) -> str:
    """Return one right: ``operator on kuka1, with speed <= 0.2 m/s, until 18:00``."""
    skills = [scope.rpartition(":")[::2] for scope in held.scopes]
    what = given((held.role,) if held.role else (), held.robots, skills, limits, None)
    return f"{what}, until {until}" if until else what


def held(grants: Iterable[Grant], now_ns: int) -> str:
    """Return what somebody holds now, in one line without times."""
    live = [g for g in grants if g.expires_ns is None or g.expires_ns > now_ns]
    return "; ".join(grant(g, g.limits, "") for g in live)


def rights_lines(grants: Sequence[str]) -> list[str]:
    """Return what somebody may, for themselves."""
    if not grants:
        return ["You have no rights now. An admin can give you some."]
    return [f"Your rights: {grants[0]}", *(f"  also {more}" for more in grants[1:])]


def may_do(skills: Sequence[str], count: int, *, moves: bool) -> str:
    """Return what somebody may let a robot do."""
    if not moves:
        return "you may look, and stop it"
    return "everything" if len(skills) == count else listed(skills)


def robots_line(robots: Sequence[str], said: str) -> str:
    """Return robots and what somebody may let them do."""
    return f"{listed(robots)}: {said}"


def access_until(until: str) -> str:
    """Return when somebody's key ends."""
    return f"Your access ends: {until}"


def next_times(slots: Sequence[str]) -> list[str]:
    """Return somebody's next slots."""
    if not slots:
        return ["Your next times: none."]
    return ["Your next times:", *(f"  {slot}" for slot in slots)]


def person(name: str, what: str, *, locked_by: str, access: bool, you: bool) -> str:
    """Return one line of /people."""
    parts = [f"{name} (you)" if you else name]
    if not access:
        parts.append("has no access any more")
    else:
        parts.append(what or "has no rights now")
    if locked_by:
        parts.append(f"locked by {locked_by}")
    return " · ".join(parts)


def waits(name: str, what: str, shared: str) -> str:
    """Return one line of /people about whoever waits."""
    return f"{name} · waits to come in as {what} · words: {shared}"


def no_such_people(said: str) -> str:
    """Return that a list is empty."""
    return f"I know nobody whose name holds {quote(said)}." if said else "I know nobody yet."


def and_more(count: int) -> str:
    """Return that a list is longer."""
    return f"And {count} more: /people and a part of the name."


def lines_left(count: int) -> str:
    """Return that a message would be too long."""
    return f"And {count} more {'line' if count == 1 else 'lines'}."
