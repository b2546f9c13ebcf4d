"""What people read when somebody comes in: invitations, codes, the admin's tap."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

MINUTE_S = 60
HOUR_S = 3600
DAY_S = 86_400

# One sentence for every code that is not good, so that nobody learns which codes exist.
NOT_GOOD = "This code is not good here. Ask whoever invited you for a new one. Nothing was done."
IN_GROUP = (
    "A code is only good in a private chat with me, and one that was shown here is not good any "
    "more. Ask whoever invited you for a new one."
)
CONFIRM_OWN = "Another admin has to let you in. Nothing was done."
NO_RIGHT = "Only an admin lets people in. Nothing was done."
OWN = "This is your own invitation. Send it to the person you invite; it is still good."
SETTLED = "This question was settled before, or it waited too long. Nothing was done."
NO_SUCH = "There is no such invitation any more. Nothing was done."
AGAIN = "You are in already, by this very code."
NO_ROLE = "An invitation needs a role, for example operator. Nothing was done."
BAD_SPAN = "A right and a code last at least some seconds, a code at most a week. Nothing was done."
TOO_MANY_OPEN = "Too many invitations are open. Take some back, or wait until they end."


def lasting(seconds: float) -> str:
    """Return a duration as people say it, rounded up so that nobody comes too early."""
    for unit_s, name in ((DAY_S, "day"), (HOUR_S, "hour"), (MINUTE_S, "minute"), (1, "second")):
        if seconds >= 2 * unit_s or unit_s == 1:
            count = max(1, -int(-seconds // unit_s))
            return f"{count} {name}" if count == 1 else f"{count} {name}s"
    raise AssertionError  # pragma: no cover


def listed(names: Sequence[str]) -> str:
    """Return names in a row: ``a, b and c``."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


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
    where = f" on {listed(robots)}" if robots else ""
    things = [f"{listed(roles)}{where}"] if roles else []
    things += [f"{'everything' if skill == '*' else skill} on {robot}" for robot, skill in skills]
    within = f", with {listed(limits)}," if limits else ""
    until = "" if lasts_s is None else f" for {lasting(lasts_s)}"
    return f"{listed(things)}{within}{until}".rstrip(",")


def invitation(what: str, code: str, code_lasts_s: float) -> str:
    """Return what the inviting admin reads, the code included, once."""
    return (
        f"Invitation as {what}. Code {code}, good once, for {lasting(code_lasts_s)}, in a private "
        "chat with me. Send it to one person, and to no group."
    )


def first_admin(code: str) -> str:
    """Return what the owner of the machine reads at the first start."""
    return (
        f"Nobody is admin here yet. Send this to me in a private chat: join {code}\n"
        "It is good once, until the next start. Whoever sends it first is the admin."
    )


def invited(what: str) -> str:
    """Return what a newcomer reads before they join."""
    return f"Hello. You are invited as {what}."


def welcome(what: str) -> str:
    """Return what somebody reads who is in."""
    return f"You are in, as {what}. Say stop at any time: whatever you may see, you may stop."


def extended(what: str) -> str:
    """Return what somebody reads who was in before."""
    return f"You can do more now: {what}. What you could do before stays as it was."


def waiting(words: str, lasts_s: float) -> str:
    """Return what somebody reads until an admin has tapped."""
    return (
        f"An admin has to let you in and sees the words: {words}. If asked, say these words. "
        f"I wait for {lasting(lasts_s)}."
    )


def wants_in(name: str, what: str, words: str, *, returning: bool) -> str:
    """Return the question to the admins."""
    again = f"The access of {name} was ended before. " if returning else ""
    return (
        f"{again}{name} wants to come in as {what}. Let them in only if they see these words: "
        f"{words}."
    )


def locked(name: str) -> str:
    """Return what the confirming admin reads about somebody who is locked."""
    return f"{name} is locked. Unlock them first. Nothing was done."


def declined() -> str:
    """Return what somebody reads whom an admin did not let in."""
    return "An admin did not let you in. Ask whoever invited you."


def lapsed() -> str:
    """Return what somebody reads for whom no admin tapped in time."""
    return "No admin answered in time, so you are not in. Ask whoever invited you for a new code."


def pause_for_you(seconds: float) -> str:
    """Return what somebody reads after too many wrong codes."""
    return f"Too many wrong codes. Try again in {lasting(seconds)}, or ask whoever invited you."


def pause_for_all(seconds: float) -> str:
    """Return what everybody with a code reads while the breaker is open."""
    return (
        f"Nobody can join for {lasting(seconds)}, because too many wrong codes came in. "
        "Your code was not used. Ask the admin."
    )


def guessing(wrong: int, within_s: float, seconds: float) -> str:
    """Return what the admins read, once, when the breaker opens."""
    return (
        f"{wrong} wrong codes came in within {lasting(within_s)}. Nobody can join for "
        f"{lasting(seconds)}, unless an admin opens joining again."
    )


def shown_in_group(what: str) -> str:
    """Return what the admins read when a code was shown where many can read it."""
    return (
        f"A code for {what} was shown in a group. It is not good any more. "
        "Invite again, and send the code to one person."
    )
