"""What is said after ``/task``: for whom, what, step by step, and under which conditions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.fleet.task import PRIORITIES, STEPS_AT_MOST
from rosic.core.language import clean
from rosic.core.language.time_parser import When, read_when
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.features.access.invite import length_said
from rosic.features.fleet import messages as words

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.fleet.task import Task
    from rosic.organiser.timezones import Zone

LONGEST_LINE = 2_000
THEN = " then "
THENS: Final = frozenset({"then", "dann"})
FULL = 100.0
PRIORITY: Final = 1
ANYBODY: Final = "any"


class TaskWish(msgspec.Struct):
    """What somebody said.

    Attributes:
        words: Whom and what, before the conditions.
        conditions: As they were typed, all of them.
        until_ns: Wall clock; 0 never passes.
    """

    words: list[str]
    conditions: tuple[str, ...] = ()
    priority: int = PRIORITY
    until_ns: int = 0
    expected_s: float = 0.0
    battery: float = 0.0
    localised: bool = False
    once: bool = False

    def lines(self, after: int) -> tuple[str, ...]:
        """Return the steps that follow so many words.

        Raises:
            NotUnderstood, OutOfBounds: There are none, or too many.
        """
        said: list[list[str]] = [[]]
        for word in self.words[after:]:
            bare = word.rstrip(";")
            if bare and bare.casefold() not in THENS:
                said[-1].append(bare)
            if bare != word or word.casefold() in THENS:
                said.append([])
        lines = tuple(" ".join(step) for step in said if step)
        if not lines:
            raise NotUnderstood(words.NO_STEPS)
        if len(lines) > STEPS_AT_MOST:
            raise OutOfBounds(words.too_many_steps(STEPS_AT_MOST))
        return lines

    def typed(self, after: int, lines: Sequence[str]) -> str:
        """Return the whole line for other steps, under the same conditions.

        Args:
            after: How many words say for whom.
            lines: The steps.
        """
        return " ".join(["/task", *self.words[:after], THEN.join(lines), *self.conditions])


def given_again(task: Task, lines: Sequence[str]) -> str:
    """Return the line that gives a task anew, as somebody types it; without when it was to be."""
    conditions = [
        f"priority {task.priority}" if task.priority != PRIORITY else "",
        f"battery {task.need.battery:g}" if task.need.battery else "",
        "localised" if task.need.localised else "",
        "once" if task.once else "",
        f"within {task.expected_ns / 1e9:g} s" if task.expected_ns else "",
    ]
    said = ["/task", task.wanted or ANYBODY, THEN.join(lines), *conditions]
    return " ".join(filter(None, said))


def read_wish(text: str, now_ns: int, zone: Zone) -> TaskWish:
    """Read the conditions off the end of a line, as many as there are.

    Args:
        text: As typed after the verb.
        now_ns: Wall clock.
        zone: In which a time of day is meant.

    Raises:
        OutOfBounds: A number or a time that makes no sense.
    """
    line = clean(text).replace("\n", " ")
    if len(line) > LONGEST_LINE:  # what is cut off may be what makes it safe
        raise OutOfBounds(words.too_long(LONGEST_LINE))
    wish = TaskWish(line.split())
    while (at := _last(wish.words)) is not None:
        key, said = wish.words[at].casefold(), [word.casefold() for word in wish.words[at + 1 :]]
        if not _READ[key](wish, said, now_ns, zone):
            break
        wish.conditions = (*wish.words[at:], *wish.conditions)
        del wish.words[at:]
    return wish


def _last(said: list[str]) -> int | None:
    """Return where the last condition begins; the first words say whom and what."""
    return next((at for at in range(len(said) - 1, 1, -1) if said[at].casefold() in _READ), None)


def _priority(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    if len(said) != 1 or not said[0].isdecimal():
        return False
    least, most = PRIORITIES
    if not least <= int(said[0]) <= most:
        raise OutOfBounds(words.no_priority(least, most))
    wish.priority = int(said[0])
    return True


def _battery(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    number = "".join(said).removesuffix("%")
    if not number.isdecimal():
        return False
    if not 0 < int(number) <= FULL:
        raise OutOfBounds(words.no_battery())
    wish.battery = float(number)
    return True


def _localised(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    wish.localised = not said
    return not said


def _once(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    wish.once = not said
    return not said


def _within(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    seconds, used = length_said(said)
    if not used or used != len(said):
        return False
    if seconds <= 0:
        raise OutOfBounds(words.no_time())
    wish.expected_s = seconds
    return True


def _by(wish: TaskWish, said: list[str], now_ns: int, zone: Zone) -> bool:
    seconds, used = length_said(said[1:]) if said[:1] == ["in"] else (0.0, 0)
    if seconds > 0 and used == len(said) - 1:  # to the second: a minute may be all there is
        wish.until_ns = now_ns + int(seconds * 1e9)
        return True
    when = read_when(f"{' '.join(said)} 1 min", now_ns, zone.local) if said else None
    if not isinstance(when, When) or when.rrule:
        return False
    at_ns = when.start_ns
    if at_ns is None:
        at_ns = zone.instant(when.start).start_ns
    if at_ns <= now_ns:
        raise OutOfBounds(words.TOO_LATE)
    wish.until_ns = at_ns
    return True


_READ: dict[str, Callable[[TaskWish, list[str], int, Zone], bool]] = {
    "priority": _priority,
    "battery": _battery,
    "localised": _localised,
    "localized": _localised,
    "once": _once,
    "within": _within,
    "by": _by,
    # In German.
    "priorität": _priority,
    "akku": _battery,
    "verortet": _localised,
    "einmal": _once,
    "binnen": _within,
    "bis": _by,
}
