"""What a live card says."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said, said_n
from rosic.core.language.sanitise import echo
from rosic.core.messages import NO_NUMBER, STALE_S
from rosic.core.units import measured

if TYPE_CHECKING:
    from rosic.core.robot.profile import Presence, Profile, Telemetry

HEARD_S: Final = (5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600)
"""How long a robot was not heard is said in such steps: not anew every second."""
NOTE_AT_MOST: Final = 120

NO_SUCH_CARD: Final = said("There is no card in this chat. /card begins one.")
SUPERSEDED: Final = said("This card has ended: a newer one is below.")
ENDED: Final = said("This card has ended. /card begins a new one.")
SEES_NOTHING: Final = said("This card has ended: whoever asked for it may see no robot any more.")
OFF: Final = said("The card has ended.")
NO_PICTURE: Final = said("There is no camera that this card could show.")
LOOK_AGAIN: Final = said("Look again")
TOO_MANY: Final = said("There are too many cards already. End one with /card off.")


def too_many_of_yours(count: int) -> str:
    """Say that somebody has as many cards as one person may."""
    return said_n(
        "You have {n} card in another chat already. End one there with /card off.",
        "You have {n} cards in other chats already. End one there with /card off.",
        count,
    )


def no_such_robot(name: str) -> str:
    """Nothing is called so, as far as this person may know."""
    return said("There is no robot and no group called {name} here.", name=echo(name))


def as_they_see(name: str) -> str:
    """The first line in a group: others here may see more, or less."""
    return said("What {name} may see:", name=name)


def for_reading() -> str:
    """The first line in a channel."""
    return said("For reading: nothing that is written here commands a robot.")


def taken() -> str:
    """Somebody has it, and nobody is named."""
    return said("taken")


def head(profile: Profile, states: list[str]) -> str:
    """The first line about a robot."""
    return joined("", (f"{profile.shown}: ", joined(" · ", states)))


def stopped(name: str, time_of_day: str) -> str:
    """It is latched."""
    if name and time_of_day:
        return said("stopped by {name} {time}", name=name, time=time_of_day)
    return said("stopped by {name}", name=name) if name else said("stopped")


def free(until: str) -> str:
    """Nobody has it; somebody's time begins then."""
    return said("free until {time}", time=until) if until else said("free")


def theirs(name: str, until: str) -> str:
    """Somebody has it, perhaps for a time that was booked."""
    return said("{name} until {time}", name=name, time=until) if until else name


def waiting(count: int) -> str:
    """So many orders wait their turn."""
    return said("{count} waiting", count=count)


def battery(profile: Profile, presence: Presence) -> str:
    """How full it is; empty when that is not known."""
    value, described = presence.values.get("battery"), profile.telemetry.get("battery")
    if described is not None and "battery" in presence.no_number:
        return said("battery {value}", value=NO_NUMBER)
    if value is None or described is None:
        return ""
    # As seldom as whether it is heard: every other age would be another edit of the message.
    age_s = max((s for s in HEARD_S if s <= presence.ages_s.get("battery", 0.0)), default=0)
    reading = _battery(value, described)
    if age_s < STALE_S:
        return reading
    return said("{reading}, not heard for over {s} s", reading=reading, s=age_s)


def _battery(value: float | str, described: Telemetry) -> str:
    if isinstance(value, str):
        return said("battery {value}", value=value)
    shown = f"{value:.0f}" if described.unit == "%" else f"{value:.1f}"
    shown = measured(f"{shown} {described.unit}".rstrip(), value, described.unit)
    if described.alert_below is not None and value < described.alert_below:
        return said("battery {value}, low", value=shown)
    return said("battery {value}", value=shown)


def link(presence: Presence) -> str:
    """Whether the robot is there, and how long it was not heard."""
    step = max((s for s in HEARD_S if s <= (presence.age_s or 0.0)), default=0)
    if presence.online is None:
        return said("link not known")
    if presence.online:
        return said("not heard for over {s} s", s=step) if step else said("link good")
    return said("not there, not heard for over {s} s", s=step) if step else said("not there")


def step(taken: str, what: str) -> str:
    """A step of the last order: ``sent 14:02:07: grasp, 15 N``."""
    return joined("", ("  ", taken, ": ", what))


def now(what: str) -> str:
    """What it does now, or how the last order ended."""
    return joined("", ("  ", said("now: {what}", what=short(what))))


def benchmark(what: str) -> str:
    """How it does against what is expected of it."""
    return joined("", ("  ", what))


def doing(skill: str) -> str:
    """It is at work, and nobody's order here says with what."""
    return said("doing {skill}", skill=skill)


def at_rest() -> str:
    """It was measured not to move."""
    return said("at rest")


def picture_button(name: str) -> str:
    """The label of what asks for a picture; a card of several robots says of which."""
    return said("Picture of {robot}", robot=name) if name else said("Picture")


def pictured(shown: str, time_of_day: str, until: str) -> str:
    """Of which robot the picture is, and of when; perhaps until when newer ones come."""
    if until:
        return said(
            "picture of {robot}: {time}, renewed until {until}",
            robot=shown,
            time=time_of_day,
            until=until,
        )
    return said("picture of {robot}: {time}", robot=shown, time=time_of_day)


def and_more(count: int) -> str:
    """More robots than one message shows."""
    return said("and {count} more: /card and their names shows them", count=count)


def as_of(now_shown: str) -> str:
    """When it was so, where it is not renewed."""
    return said("as of {time}", time=now_shown)


def updated(now_shown: str, next_shown: str, lag_s: int) -> str:
    """How old this is, and when it is dead if it has not changed by then.

    Args:
        now_shown: When it was so.
        next_shown: By when it says something new, if ROSIC runs and reaches the chat.
        lag_s: How long the last change took to arrive; 0: no time worth telling.
    """
    line = said("updated {now}, next by {next}", now=now_shown, next=next_shown)
    late = said("changes reach this chat {s} s late", s=lag_s)
    return joined("\n", (line, late)) if lag_s else line


def short(text: str) -> str:
    """Return a text that leaves room for others; what is short keeps its languages."""
    return text if len(text) <= NOTE_AT_MOST else f"{text[: NOTE_AT_MOST - 1]}…"
