"""Every sentence about people that a chat is told here; the rooms' own are in the rooms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import given, listed
from rosic.core.i18n import filled, joined, said, said_n
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import OR
from rosic.core.message import Button
from rosic.core.policy.limits import limit_in_words
from rosic.core.policy.roles import Assurance
from rosic.core.role_names import role_shown
from rosic.core.time_units import DAY_S
from rosic.gateway.person_argument import roles_listed

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.policy.roles import Grant

LEAVE_IT: Final = said("Leave it")
MOST_NAMED: Final = 6

# ---- coming in ----

JOIN: Final = said("Join")
NOT_ME: Final = said("Not me")
BACK: Final = "back"
REOPEN: Final = "reopen"
TAKE_BACK_S: Final = DAY_S
REOPEN_ROW: Final = (Button(said("All tries again"), f"/invite {REOPEN}"),)
ANSWERED: Final = said("This was answered before. Nothing was done.")
INVITATION_OVER: Final = said(
    "The time of this invitation is over. Nothing was done. Ask whoever invited you for a new one."
)
OVER_FOR_THE_FIRST: Final = said(
    "The time of this code is over. Nothing was done. Whoever runs ROSIC here gets a new one by "
    "starting it again, or with: rosic invite --role admin"
)
NOT_ME_SAID: Final = said(
    "Nothing was done. Whoever invited has been told that it was not for you."
)
NOT_WRITTEN: Final = said(
    "I cannot write this down now, so you are not in yet. Your code is still good: "
    "send it again in a while. The operator has to look."
)
NOBODY_TO_ASK: Final = said("I can reach no admin now, so ask one yourself.")

_READ_ALONG: Final = {
    "local": None,
    "e2ee-verified": said("who writes when, but not what (the messages are end-to-end encrypted)"),
    "e2ee-unverified": said(
        "who writes when, and what as well if it has put a device of its own here (the messages "
        "are end-to-end encrypted, but nobody has compared keys)"
    ),
    "provider-readable": said("everything here ({platform} is not end-to-end encrypted)"),
}


def invited(what: str, platform: str, assurance: str) -> str:
    """Return what a newcomer reads before they join."""
    # What is not known is taken for the worst.
    reads = _READ_ALONG.get(assurance, _READ_ALONG["provider-readable"])
    lines = [said("Hello. You are invited as {what}.", what=what)]
    if reads:
        what_they_read = filled(reads, platform=platform.capitalize())
        lines.append(said("What the chat operator can read: {what}.", what=what_they_read))
    return joined("\n", lines)


CHAT_IS: Final = {
    Assurance.PROVIDER_READABLE: said(
        "This chat: readable by its provider, who could also write in your name."
    ),
    Assurance.E2EE_UNVERIFIED: said(
        "This chat: encrypted, unverified. Nobody has compared the keys of your device: /verify"
    ),
    Assurance.E2EE_VERIFIED: said("This chat: encrypted, verified."),
}


def is_in(name: str, what: str) -> str:
    """Return what whoever invited reads."""
    return said("{name} is in, as {what}.", name=name, what=what)


def not_for_them(what: str) -> str:
    """Return what whoever invited reads after a tap on Not me."""
    return said(
        "Your invitation as {what} reached somebody who says that it is not for them. "
        "Its code is still good. Take it back if you sent it to the wrong person.",
        what=what,
    )


def take_back_button(invitation: str, good_for_s: float) -> Button:
    """Return the button that ends an invitation, for as long as there is something to end."""
    command = f"/invite {BACK} {invitation}"
    return Button(said("Take it back"), command, good_for_ns=int(good_for_s * 1e9))


# ---- letting in ----


def let_in_label(name: str) -> str:
    """Return the label of the one button."""
    return said("Let {name} in", name=name) if name else said("Let them in")


def decline_label(name: str) -> str:
    """Return the label of the other button."""
    return said("Not {name}", name=name) if name else said("No")


def let_in(name: str, what: str) -> str:
    """Return what the admin reads who let somebody in."""
    return said("{name} is in, as {what}.", name=name, what=what)


def was_let_in(by: str, name: str, what: str) -> str:
    """Return what the other admins read."""
    return said("{by} let {name} in, as {what}.", by=by, name=name, what=what)


def not_let_in(name: str) -> str:
    """Return what the admin reads who did not let somebody in."""
    return said("{name} is not in, and has been told.", name=name)


def was_not_let_in(by: str, name: str) -> str:
    """Return what the other admins read."""
    return said("{by} did not let {name} in.", by=by, name=name)


def who_waits(names: Sequence[str]) -> str:
    """Return what is said to an answer that names nobody."""
    if not names:
        return said("Nobody waits to come in. Nothing was done.")
    return said_n(
        "Whom? {names} waits to come in. Nothing was done.",
        "Whom? {names} wait to come in. Nothing was done.",
        len(names),
        names=listed(names[:MOST_NAMED]),
    )


# ---- rights about people ----

_ACTS: Final = {
    "invite": said("Inviting people and letting them in"),
    "lock": said("Locking and unlocking people"),
    "people": said("Looking after people"),
}


def not_yours(verb: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not do something with people, and who can."""
    return said(
        "{acts} is for admins. {can} Nothing was done.", acts=_ACTS[verb], can=can_do(helpers)
    )


def too_much(what: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not give that much."""
    return said(
        "You cannot give {what}: it is more than you may give. {can} Nothing was done.",
        what=what,
        can=can_do(helpers),
    )


def too_long(what: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not give it for that long."""
    return said(
        "You cannot give {what}: your own right to give it ends sooner. Say a shorter time. {can} "
        "Nothing was done.",
        what=what,
        can=can_do(helpers),
    )


def can_do(helpers: Sequence[str]) -> str:
    """Return who can do what somebody may not."""
    return (
        said("{names} can.", names=joined(OR, helpers))
        if helpers
        else said("The operator of this place can.")
    )


# ---- inviting ----

TAKEN_BACK: Final = said("Taken back: that code lets nobody in any more.")
REOPENED: Final = said("Everybody has all their tries again.")
UNWRITTEN: Final = said(
    "I could not write this down: it holds until ROSIC is restarted. The operator has to look."
)


def noted(sentence: str, *, written: bool) -> str:
    """Return what was done, and whether it will last."""
    return sentence if written else joined(" ", (sentence, UNWRITTEN))


def how_to_invite(roles: Sequence[str], robots: Mapping[str, object]) -> str:
    """Return how to invite, with an example of this place."""
    role = "operator" if "operator" in roles else next(iter(roles), "viewer")
    robot = f" {next(iter(robots))}" if robots else ""
    return said(
        "Say as what, where, and for how long: /invite {role}{robot} for 2h\nWithout a "
        "robot it is good everywhere, without a time until it is taken back. Also: with "
        "speed <= 0.2 m/s (a limit), code 30 min (how long the code is good), as NAME "
        "(how they are shown), confirm (an admin has to let them in).\nRoles here: "
        "{listed}.",
        role=role_shown(role),
        robot=robot,
        listed=roles_listed(roles),
    )


def how_to_join(link: str, text: str) -> str:
    """Return how the code is handed in."""
    if link:
        return said("{link}\nOr let them send me, in a private chat: {text}", link=link, text=text)
    return said("Let them send me, in a private chat: {text}", text=text)


def no_role(roles: Sequence[str]) -> str:
    """Return what is missing in an invitation."""
    return said(
        "As what? The roles here are {listed}. Nothing was done.", listed=roles_listed(roles)
    )


def no_role_no_robot(word: str, close: Sequence[str], roles: Sequence[str]) -> str:
    """Return which word means nothing, and what may have been meant."""
    meant = (
        said(" Did you mean {close}?", close=joined(OR, close))
        if close
        else said(" The roles here are {listed}.", listed=roles_listed(roles))
    )
    return said(
        "I know no role and no robot called {quote}.{meant} Nothing was done.",
        quote=quote(word),
        meant=meant,
    )


def invite_as(name: str, roles: Sequence[str]) -> str:
    """Return how somebody is invited whose name was said where a role belongs."""
    role = "viewer" if "viewer" in roles else next(iter(roles), "viewer")
    return said(
        "If that is whom you invite, say first as what: /invite {role} as {name}",
        role=role_shown(role),
        name=name,
    )


def no_length(which: str, word: str) -> str:
    """Return which length cannot be read."""
    wrong = (
        said("I cannot read {quote} as a length of time.", quote=quote(word))
        if word
        else said("How long?")
    )
    return said(
        "{wrong} Write {which} 2h, {which} 30 min or {which} 3 days. Nothing was done.",
        wrong=wrong,
        which=which,
    )


def twice_how_long(which: str) -> str:
    """Return what is said about two lengths."""
    return said('That says "{which}" twice. Nothing was done.', which=which)


# ---- naming people ----


def nobody_called(given: str) -> str:
    """Return that nobody has this name."""
    return said("I know nobody called {quote}. Nothing was done.", quote=quote(given))


# ---- who is who ----


def you_are(name: str) -> str:
    """Return the first line of /me."""
    return said("You are {name}.", name=name)


def grant(held: Grant, limits: Sequence[str], until: str) -> str:
    """Return one right: ``operator on kuka1, with speed <= 0.2 m/s, until 18:00``."""
    skills = [scope.rpartition(":")[::2] for scope in held.scopes]
    what = given((held.role,) if held.role else (), held.robots, skills, limits, None)
    return said("{what}, until {until}", what=what, until=until) if until else what


def held(grants: Iterable[Grant], now_ns: int) -> str:
    """Return what somebody holds now, in one line without times."""
    live = [g for g in grants if g.expires_ns is None or g.expires_ns > now_ns]
    return joined("; ", (grant(g, g.limits, "") for g in live))


def rights_lines(grants: Sequence[str]) -> list[str]:
    """Return what somebody may, for themselves."""
    if not grants:
        return [said("You have no rights now. An admin can give you some.")]
    return [
        said("Your rights: {grants}", grants=grants[0]),
        *(said("  also {more}", more=more) for more in grants[1:]),
    ]


MAY_LOOK: Final = said("you may look, and stop it")
EVERYTHING: Final = said("everything")


def within(skill: str, limits: Sequence[Sequence[str]]) -> str:
    """Return a skill with its limits: ``grasp (force <= 20 N)``; any of several is enough."""
    if not limits:
        return skill
    shown = joined(OR, [listed(tuple(map(limit_in_words, each))) for each in limits])
    return said("{skill} ({limits})", skill=skill, limits=shown)


def may_do(skills: Sequence[str], lacks: Sequence[str], *, resume: bool) -> str:
    """Return what somebody may let a robot do, and what of it not.

    Args:
        skills: What they may.
        lacks: The other skills.
        resume: Whether they may resume it.
    """
    not_theirs = [*lacks, *(() if resume else (said("resume"),))]
    if not not_theirs:
        return listed(skills)
    return said("{skills}; not {lacks}", skills=listed(skills), lacks=joined(OR, not_theirs))


def robots_line(robots: Sequence[str], what: str) -> str:
    """Return robots and what somebody may let them do."""
    return joined(": ", (listed(robots), what))


def access_until(until: str) -> str:
    """Return when somebody's key ends."""
    return said("Your access ends: {until}", until=until)


def next_times(slots: Sequence[str]) -> list[str]:
    """Return somebody's next slots."""
    if not slots:
        return [said("Your next times: none.")]
    return [said("Your next times:"), *(joined("", ("  ", slot)) for slot in slots)]


def person(name: str, what: str, *, locked_by: str, access: bool, you: bool, accounts: str) -> str:
    """Return one line of /people."""
    parts: list[str] = [said("{name} (you)", name=name) if you else name]
    if not access:
        parts.append(said("has no access any more"))
    else:
        parts.append(what or said("has no rights now"))
    if locked_by:
        parts.append(said("locked by {locked_by}", locked_by=locked_by))
    if accounts:
        parts.append(said("accounts: {accounts}", accounts=accounts))
    return joined(" · ", parts)


def waits(name: str, what: str, shared: str) -> str:
    """Return one line of /people about whoever waits."""
    return said(
        "{name} · waits to come in as {what} · words: {shared}", name=name, what=what, shared=shared
    )


def no_such_people(given: str) -> str:
    """Return that a list is empty."""
    return (
        said("I know nobody whose name holds {quote}.", quote=quote(given))
        if given
        else said("I know nobody yet.")
    )


def and_more(count: int) -> str:
    """Return that a list is longer."""
    return said("And {count} more: /people and a part of the name.", count=count)


def lines_left(count: int) -> str:
    """Return that a message would be too long."""
    return said_n("And {n} more line.", "And {n} more lines.", count)
