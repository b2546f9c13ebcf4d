"""What people are told about their times without having asked."""

from __future__ import annotations

from rosic.core.i18n import joined, said
from rosic.organiser.calendar_messages import length

# ---- told by the keeper ----


def begins(shown: str, until: str) -> str:
    """A slot starts."""
    return said("It is your time: {shown} is yours until {until}.", shown=shown, until=until)


def begins_taken(shown: str, name: str) -> str:
    """A slot starts, and a senior has the robot and may keep it."""
    return said(
        "It is your time with {shown}, but {name} has it now, and goes before. Ask {name}.",
        shown=shown,
        name=name,
    )


def ends_soon(shown: str, left_s: int, at: str) -> str:
    """Some minutes before the end."""
    return said(
        "Your time with {shown} ends in {length}, at {at}.",
        shown=shown,
        length=length(left_s),
        at=at,
    )


def ended(shown: str, *, at_rest: bool) -> str:
    """A slot is over, and its owner still had the robot."""
    return joined(
        " ", (said("Your time with {shown} is over.", shown=shown), rest(at_rest=at_rest))
    )


def taken_over(shown: str, name: str, *, at_rest: bool) -> str:
    """Somebody else's slot has begun while one had the robot without a slot."""
    return joined(
        " ",
        (
            said("{shown} is booked by {name} from now on.", shown=shown, name=name),
            rest(at_rest=at_rest),
        ),
    )


def rest(*, at_rest: bool) -> str:
    """What was measured."""
    if at_rest:
        return said("It is at rest.")
    return said(
        "It has not confirmed that it is at rest, so it stays stopped. If it moves, use "
        "its own stop button."
    )


def no_answer(shown: str) -> str:
    """It could not even be asked to come to rest."""
    return said(
        "Your time with {shown} is over, but it does not answer. Look at it. If it "
        "moves, use its own stop button.",
        shown=shown,
    )


def wait_for_rest(shown: str) -> str:
    """The next one cannot begin."""
    return said(
        "It is your time with {shown}, but it has not confirmed that it is at rest, so "
        "it stays stopped. Look at it; somebody who may resume it can do so then. If it "
        "moves, use its own stop button.",
        shown=shown,
    )


def cannot_begin(shown: str, why: str) -> str:
    """The next one cannot begin, and resuming does not help."""
    return said("It is your time with {shown}, but you cannot use it. {why}", shown=shown, why=why)


def unused(shown: str, idle_s: float, left_s: float) -> str:
    """Before an unused slot is released."""
    return said(
        "Somebody waits for {shown}, and you have not used it for {length}. Use it, or "
        "tap, within {left_s:.0f} s to keep it.",
        shown=shown,
        length=length(int(idle_s)),
        left_s=left_s,
    )


def taken_back(shown: str) -> str:
    """A slot whose owner has no right to the robot any more."""
    return said(
        "You may not move {shown} any more, so your time with it was given back.", shown=shown
    )


def released(shown: str, until: str) -> str:
    """An unused slot was released."""
    return said(
        "{shown} was not used and somebody waits for it, so it was given back. It was "
        "yours until {until}.",
        shown=shown,
        until=until,
    )
