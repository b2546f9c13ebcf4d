"""What people read about orders that wait for their time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import capital, joined, said, said_n
from rosic.core.language.sanitise import echo
from rosic.core.local_time import WEEKDAYS
from rosic.core.message import Button
from rosic.organiser.calendar_messages import comes_twice, day

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.core.local_time import LocalTime
    from rosic.features.scheduled_orders.schedule import ScheduledTime
    from rosic.organiser.timezones import Zone

__all__ = ["comes_twice"]

GO_ON_S: Final = 86_400.0
"""So long it can be said by a button that what comes again goes on after a stop."""
LONGEST_SHOWN: Final = 120
NO_SIGN: Final = frozenset({"the", "at", "on", "it", "order", "den", "die", "das", "um", "am"})
"""Words that say nothing about which of several is meant."""

HOW_TO: Final = said(
    "Say when, and what: /at 15:00 omni move 1 m; /in 10 min omni wave; "
    "/every monday 8:00 omni move 1 m; omni wave. /planned lists what is planned."
)
NO_TIME: Final = said(
    "I read no time in that. Say when, and what: /at tomorrow 8:00 omni move 1 m. Nothing was "
    "planned."
)
NO_STEPS: Final = said("Say what is to be done then. Nothing was planned.")
OVER: Final = said("That time is over. Nothing was planned.")
TOO_FAR: Final = said("That is further away than a year. Nothing was planned.")
TOO_LATE: Final = said("It was too late to begin.")
FAULT: Final = said("Something went wrong here. Please look.")
NONE: Final = said("You have planned nothing.")
SETTLED: Final = said("That question is settled already. Nothing was planned.")
CHANGED: Final = said(
    "What was shown would be something else by now. Nothing was planned. Say it again."
)
ONLY_BY_TAP: Final = said("That is planned by the button beneath the plan. Nothing was planned.")
AS_YOU: Final = said("As you, if you may then.")
WHICH: Final = said("Say which: its number, or words of it.")

# ---- the plan ----


def plan(when: str, zone: str, steps: Iterable[str], note: str) -> str:
    """Return a plan before it stands."""
    head = said("{when} ({zone}):", when=capital(when), zone=zone)
    lines = [joined("", (f"{number}. ", step)) for number, step in enumerate(steps, 1)]
    return joined("\n", filter(None, (head, *lines, AS_YOU, note)))


def again(when: ScheduledTime, moment: str) -> str:
    """Return when something is done that comes again, and the next time."""
    return said("{often}, next {moment}", often=_often(when), moment=moment)


_DAYS: Final = dict(zip(("MO", "TU", "WE", "TH", "FR", "SA", "SU"), WEEKDAYS, strict=True))


def _often(when: ScheduledTime) -> str:
    clock = when.first.time_text() if when.first is not None else ""
    rule = dict(part.split("=", 1) for part in when.rrule.split(";") if "=" in part)
    ends = rule.pop("UNTIL", ""), rule.pop("COUNT", "")
    days = [_DAYS.get(code, "") for code in rule.get("BYDAY", "").split(",")]
    if rule == {"FREQ": "DAILY"}:
        often: str = said("every day {clock}", clock=clock)
    elif rule.keys() == {"FREQ", "BYDAY"} and rule["FREQ"] == "WEEKLY" and all(days):
        often = said("every {days} {clock}", days=joined(", ", days), clock=clock)
    else:
        return said("by the rule {rule}, {clock}", rule=when.rrule, clock=clock)
    if ends[0]:
        until = f"{ends[0][:4]}-{ends[0][4:6]}-{ends[0][6:8]}"
        return said("{often} until {until}", often=often, until=until)
    if ends[1]:
        return said_n("{often}, once", "{often}, {n} times", int(ends[1]), often=often)
    return often


def plan_buttons(key: str, leave: str) -> tuple[tuple[Button, ...], ...]:
    """Return what lets a plan stand, or not."""
    return (
        (
            Button(said("Plan it"), f"/planned keep {key}"),
            Button(said("Leave it"), leave),
        ),
    )


def planned(key: str, when: str) -> str:
    """Return that it stands."""
    return said("Planned as {number}: {when}.", number=key, when=when)


def cancel_button(key: str, *, numbered: bool = False) -> tuple[Button, ...]:
    """Return what takes one back."""
    label = said("Cancel {number}", number=key) if numbered else said("Cancel it")
    return (Button(label, f"/unplan {key}"),)


def go_on_button(key: str) -> tuple[tuple[Button, ...], ...]:
    """Return what lets one go on after a stop."""
    return ((Button(said("Go on the next time"), f"/planned go {key}"), *cancel_button(key)),)


def one(key: str, when: str, steps: Sequence[str], *, rests: bool) -> str:
    """Return one of a list."""
    line = said("{number}: {when}: {what}", number=key, when=when, what=shown(steps))
    return joined(" · ", (line, said("rests since a stop"))) if rests else line


def shown(steps: Sequence[str]) -> str:
    """Return steps as they were said."""
    text = "; ".join(steps)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]} ..."


# ---- what is not planned ----


def too_many_steps(most: int) -> str:
    """Return that a plan has too many steps."""
    return said("That has more than {most} steps. Nothing was planned.", most=most)


def no_order(step: str) -> str:
    """Return that a step is no order to a robot."""
    return said(
        "Only orders to robots can be planned, and this is none: {step}. Nothing was planned.",
        step=echo(step),
    )


def not_permitted(robot: str, skill: str) -> str:
    """Return that somebody lacks the right."""
    return said("You may not let {robot} do this: {skill}.", robot=robot, skill=skill)


def wants_a_person(robot: str, skill: str) -> str:
    """Return that somebody has to confirm it each time."""
    return said(
        "{robot} does this only when somebody confirms it: {skill}. It cannot be planned.",
        robot=robot,
        skill=skill,
    )


def skipped(local: LocalTime, zone: Zone, possible: LocalTime) -> str:
    """Return that the clocks never show this."""
    return said(
        "On {day} the clocks in {name} go forward, and there is no {clock}. The next possible "
        "time is {next}. Nothing was planned.",
        day=day(local, local),
        name=zone.name,
        clock=local.time_text(),
        next=possible.time_text(),
    )


def too_many(most: int) -> str:
    """Return that somebody has planned as much as one may."""
    return said(
        "You have planned {most} times already. Cancel some first. Nothing was planned.", most=most
    )


def full(most: int) -> str:
    """Return that nothing more is taken in here."""
    return said("{most} times are planned here already. Nothing was planned.", most=most)


# ---- what is planned ----


def no_such(number: str) -> str:
    """Return that nothing is called so."""
    return said("You have planned nothing like that: {number}.", number=echo(number))


def not_yours(name: str) -> str:
    """Return that somebody else has planned it."""
    return said(
        "{name} has planned that, and can take it back, or whoever may assign tasks here.",
        name=name,
    )


def several(number: str) -> str:
    """Return that words mean more than one."""
    return said("That may be several of them: {number}. Which one?", number=echo(number))


def cancelled(key: str, steps: Sequence[str]) -> str:
    """Return that one is taken back."""
    return said("Planned order {number} is taken back: {what}.", number=key, what=shown(steps))


def cancelled_by(name: str, key: str, steps: Sequence[str]) -> str:
    """Return that somebody else has taken one back."""
    return said(
        "{name} has taken your planned order {number} back: {what}.",
        name=name,
        number=key,
        what=shown(steps),
    )


def goes_on(key: str, moment: str) -> str:
    """Return that one goes on after a stop."""
    return said("Planned order {number} goes on, next {moment}.", number=key, moment=moment)


def rests_not(key: str) -> str:
    """Return that one does not rest."""
    return said("Planned order {number} does not rest.", number=key)


def taken_back(count: int) -> str:
    """Return that somebody's access was locked or ended, and what became of their plans."""
    return said_n(
        "Your access was locked or has ended, so the order that you had planned is taken back.",
        "Your access was locked or has ended, so the {n} orders that you had planned are taken "
        "back.",
        count,
    )


# ---- at its time ----


def titled(key: str, text: str) -> str:
    """Return the first line of an order before its values are known."""
    return str(said("{order} · planned {number}", order=text, number=key))


def order_title(text: str, key: str, step: int, steps: int) -> str:
    """Return the first line of an order that was planned."""
    if steps == 1:
        return said("{order} · planned {number}", order=text, number=key)
    return said(
        "{order} · planned {number}, step {step} of {steps}",
        order=text,
        number=key,
        step=step,
        steps=steps,
    )


def not_done(key: str, steps: Sequence[str], why: str) -> str:
    """Return that nothing of a plan was done."""
    return said(
        "Planned order {number} ({what}) was not done: {why}",
        number=key,
        what=shown(steps),
        why=why,
    )


def ended_at(key: str, step: int, steps: int, why: str) -> str:
    """Return that a plan ended on its way."""
    return said(
        "Planned order {number} ended before step {step} of {steps}, and the rest was not done: "
        "{why}",
        number=key,
        step=step,
        steps=steps,
        why=why,
    )


def rest_not_done(key: str, step: int, steps: int) -> str:
    """Return that a step was not carried out."""
    return said(
        "Planned order {number} ended with step {step} of {steps}: that was not carried out, so "
        "the rest was not done.",
        number=key,
        step=step,
        steps=steps,
    )


def all_done(key: str, steps: Sequence[str]) -> str:
    """Return that all of it was carried out."""
    return said("Planned order {number} ({what}): done.", number=key, what=shown(steps))


def missed(key: str, steps: Sequence[str], moment: str) -> str:
    """Return that it could not begin in time."""
    return said(
        "Planned order {number} ({what}) was for {moment}, and I could not begin it in time. It "
        "was not done.",
        number=key,
        what=shown(steps),
        moment=moment,
    )


def interrupted(key: str, steps: Sequence[str]) -> str:
    """Return that ROSIC ended while it was under way."""
    return said(
        "Planned order {number} ({what}) was under way when I was shut down. What had not begun "
        "is not done.",
        number=key,
        what=shown(steps),
    )


def under_way_still(key: str, steps: Sequence[str]) -> str:
    """Return that its next time came before it was over."""
    return said(
        "Planned order {number} ({what}) was not done this time: it is under way still.",
        number=key,
        what=shown(steps),
    )


def would_be(act: str) -> str:
    """Return that it would be something else now."""
    return said("It is not what was shown any more, now it would be: {act}. Plan it anew.", act=act)


def means_something_else(text: str) -> str:
    """Return that it is no order any more."""
    return said("It is no order any more: {text}. Plan it anew.", text=echo(text))


def stopped_since(shown: str) -> str:
    """Return that a robot was stopped after it was planned."""
    return said("{robot} was stopped after you planned it.", robot=shown)


def no_chat(name: str) -> str:
    """Return that its author cannot be told."""
    return said("{name} cannot be reached here.", name=name)
