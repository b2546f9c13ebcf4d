"""What people read when somebody comes in: invitations, codes, the admin's tap."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n
from rosic.core.policy.limits import limit_in_words
from rosic.core.role_names import role_shown
from rosic.core.time_units import DAY_S, HOUR_S, MINUTE_S

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.authoriser.guessing import GuessLimits

AND = said(" and ")

# One sentence for every code that is not good, so that nobody learns which codes exist.
NOT_GOOD = said(
    "This code is not good here. Ask whoever invited you for a new one. Nothing was done."
)
NOT_GOOD_FOR_THE_FIRST = said(
    "This code is not good here. Nobody is admin here yet: the code for that was shown where ROSIC "
    "was started, and each start makes a new one. Nothing was done."
)
FIRST_WANTED = said(
    "Hello. Nobody is admin here yet. Whoever runs ROSIC here finds a code where it was started, "
    "or gets one with: rosic invite --role admin\nSend it to me here, and you are the admin."
)
IN_GROUP = said(
    "A code is only good in a private chat with me, and one that was shown here is "
    "not good any more. Ask whoever invited you for a new one."
)
CONFIRM_OWN = said("Another admin has to let you in. Nothing was done.")
NO_RIGHT = said("Only an admin lets people in. Nothing was done.")
OWN = said("This is your own invitation. Send it to the person you invite; it is still good.")
SETTLED = said("This question was settled before, or it waited too long. Nothing was done.")
NO_SUCH = said("There is no such invitation any more. Nothing was done.")
AGAIN = said("You are in already, by this very code.")
NO_ROLE = said("An invitation needs a role, for example operator. Nothing was done.")
BAD_SPAN = said(
    "A right and a code last at least some seconds, a code at most a week. Nothing was done."
)
TOO_MANY_OPEN = said("Too many invitations are open. Take some back, or wait until they end.")
ONLY_HERE = said(
    "There is only this terminal to talk by, so nobody could use an invitation. Others can "
    "join once there is a messenger: rosic init. Nothing was done."
)


def lasting(seconds: float) -> str:
    """Return a duration as people say it, rounded up so that nobody comes too early."""
    for unit_s in (DAY_S, HOUR_S, MINUTE_S):
        if seconds >= 2 * unit_s:
            return _counted(unit_s, max(1, -int(-seconds // unit_s)))
    return _counted(1, max(1, -int(-seconds // 1)))


def _counted(unit_s: int, n: int) -> str:
    if unit_s == DAY_S:
        return said_n("{n} day", "{n} days", n)
    if unit_s == HOUR_S:
        return said_n("{n} hour", "{n} hours", n)
    if unit_s == MINUTE_S:
        return said_n("{n} minute", "{n} minutes", n)
    return said_n("{n} second", "{n} seconds", n)


def listed(names: Sequence[str]) -> str:
    """Return names in a row: ``a, b and c``."""
    return joined(AND, [joined(", ", names[:-1]), names[-1]] if len(names) > 1 else names)


def given(
    roles: Sequence[str],
    robots: Sequence[str],
    skills: Sequence[tuple[str, str]],
    limits: Sequence[str],
    lasts_s: float | None,
) -> str:
    """Return what somebody is given: ``operator on kuka1 for 2 hours``.

    Args:
        roles: Names of roles.
        robots: Where only; empty for everywhere.
        skills: Robot and skill, each with wildcards, besides the roles.
        limits: As they are said.
        lasts_s: None for no end.
    """
    where = said(" on {listed}", listed=listed(robots)) if robots else ""
    named = tuple(map(role_shown, roles))
    things = [joined("", (listed(named), where))] if named else []
    things += [
        said("{skill} on {robot}", skill=said("everything") if skill == "*" else skill, robot=robot)
        for robot, skill in skills
    ]
    bounds = tuple(map(limit_in_words, limits))
    within = said(", with {listed}", listed=listed(bounds)) if bounds else ""
    until = "" if lasts_s is None else said(" for {lasting}", lasting=lasting(lasts_s))
    comma = "," if within and until else ""
    return joined("", (listed(things), within, comma, until))


def invitation(what: str, code: str, code_lasts_s: float) -> str:
    """Return what the inviting admin reads, the code included, once."""
    return said(
        "Invitation as {what}. Code {code}, good once, for {lasting}, in a private chat "
        "with me. Send it to one person, and to no group.",
        what=what,
        code=code,
        lasting=lasting(code_lasts_s),
    )


def first_admin(code: str) -> str:
    """Return what the owner of the machine reads at the first start."""
    return said(
        "Nobody is admin here yet. Send this to me in a private chat: join {code}\nIt is "
        "good once, until the next start. Whoever sends it first is the admin.",
        code=code,
    )


def invited(what: str) -> str:
    """Return what a newcomer reads before they join."""
    return said("Hello. You are invited as {what}.", what=what)


def welcome(what: str) -> str:
    """Return what somebody reads who is in."""
    return said(
        "You are in, as {what}. Say stop at any time: whatever you may see, you may stop.",
        what=what,
    )


def extended(what: str) -> str:
    """Return what somebody reads who was in before."""
    return said("You can do more now: {what}. What you could do before stays as it was.", what=what)


def waiting(words: str, lasts_s: float) -> str:
    """Return what somebody reads until an admin has tapped."""
    return said(
        "An admin has to let you in and sees the words: {words}. If asked, say these "
        "words. I wait for {lasting}.",
        words=words,
        lasting=lasting(lasts_s),
    )


def wants_in(name: str, what: str, words: str, *, returning: bool) -> str:
    """Return the question to the admins."""
    question = said(
        "{name} wants to come in as {what}. Let them in only if they see these words: {words}.",
        name=name,
        what=what,
        words=words,
    )
    if not returning:
        return question
    return joined(" ", (said("The access of {name} was ended before.", name=name), question))


def locked(name: str) -> str:
    """Return what the confirming admin reads about somebody who is locked."""
    return said("{name} is locked. Unlock them first. Nothing was done.", name=name)


def declined() -> str:
    """Return what somebody reads whom an admin did not let in."""
    return said("An admin did not let you in. Ask whoever invited you.")


def lapsed() -> str:
    """Return what somebody reads for whom no admin tapped in time."""
    return said(
        "No admin answered in time, so you are not in. Ask whoever invited you for a new code."
    )


def pause_for_you(seconds: float) -> str:
    """Return what somebody reads after too many wrong codes."""
    return said(
        "Too many wrong codes. Try again in {lasting}, or ask whoever invited you.",
        lasting=lasting(seconds),
    )


def guessing(limits: GuessLimits) -> str:
    """Return what the admins read, once, when the breaker opens."""
    return said(
        "{wrong} wrong codes came in within {lasting}: somebody may be guessing. Whoever has a "
        "good code can still join. For {lasting2} each account has {tries} tries, then it waits "
        "as long; an admin can end that.",
        wrong=limits.breaker_tries,
        lasting=lasting(limits.breaker_within_s),
        lasting2=lasting(limits.breaker_pause_s),
        tries=min(limits.tries, limits.breaker_each),
    )


def shown_in_group(what: str) -> str:
    """Return what the admins read when a code was shown where many can read it."""
    return said(
        "A code for {what} was shown in a group. It is not good any more. Invite again, "
        "and send the code to one person.",
        what=what,
    )
