"""``/history``: who asked for what, when, with which values, and what came of it.

Everybody reads their own. A robot's is read by whoever looks after people here, or gives rights on
that robot: what its users asked of it is shown to nobody else (I11).
"""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, Final, TypeVar

import msgspec

from rosic.container import records
from rosic.core.history import REFUSED, RESUMED, STOPPED, HistoryEntry, HistoryQuery
from rosic.core.i18n import joined, said, said_n
from rosic.core.identity import PrincipalId
from rosic.core.language import clean, live_words, show
from rosic.core.language.sanitise import quote
from rosic.core.message import Button
from rosic.core.order_status import BETWEEN, ended_as
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotPermitted, NotUnderstood, RecordUnavailable, StoreFault
from rosic.features.personal_data import messages as words
from rosic.gateway.commands import Reply, check_private
from rosic.gateway.observed_state import HistoryLine
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rosic.core.language import Vocabulary
    from rosic.core.language.compiled import CompiledSkill
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext

L = TypeVar("L")

SHOWN: Final = 10
NAMED_AT_MOST: Final = 5
AT_ONCE_NS: Final = SECOND_NS
TASK: Final = "task "
_STEP: Final = re.compile(r"(.+), step (\d+) of (\d+)")
"""What stands behind an order that belongs to a task, in the record's own English."""
MORE: Final = 50
FEW: Final = 100
STEP: Final = 20
"""So many lines are put into words before others have their turn."""
LONGEST: Final = 300
"""Letters of what somebody wrote or a robot said that one line repeats."""
NOTHING_YET: Final = said("Nothing was asked for yet, as far as the record goes back.")
HOW: Final = said(
    "Say history for what you asked for, or history and a robot's name; more shows more of it."
)
_MORE: Final = "more"


class ReadEntry(msgspec.Struct, frozen=True, kw_only=True):
    """One command in words.

    Attributes:
        asked: ``omni: move forward 0.5 m``; the skill alone where its words were erased.
        came: What came of it, as it was told.
    """

    who: PrincipalId
    at_ns: int
    robot: str
    skill: str
    outcome: str
    ended_ns: int | None
    asked: str
    came: str


class OrderHistory:
    """The handler of what was asked for."""

    def __init__(self, data_context: ContainerContext) -> None:
        self._data_context = data_context
        self._many = asyncio.Lock()

    async def history(self, asked: CommandContext) -> Reply:
        """Show one's own, or a robot's.

        Raises:
            NotPermitted: Others read along, or that robot's is not theirs to read.
            NotUnderstood: It names no robot that they see.
            RecordUnavailable: It cannot be read now.
        """
        check_private(asked)
        who, said_words = asked.caller.principal, asked.rest.casefold().split()
        limit = MORE if _MORE in said_words else SHOWN
        named = [word for word in said_words if word != _MORE]
        robot = self._robot(who, named)
        query = HistoryQuery(principal="" if robot else who, robot=robot, limit=limit + 1)
        try:
            found = await self._data_context.container_store.history(query)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault
        if not found:
            return Reply(NOTHING_YET)
        vocabulary = self._data_context.vocabulary
        lines = [
            self._line(entry, robots, vocabulary, who)
            for entry, robots in at_once(found[:limit][::-1])
        ]
        further = Button(said("More"), " ".join(("/history", *named, _MORE)))
        return Reply(joined("\n", lines), ((further,),) if limit < len(found) <= MORE else ())

    async def read(self, query: HistoryQuery) -> tuple[HistoryLine, ...]:
        """Return what was asked, in words; see `HistoryReader`."""
        if query.limit <= FEW:
            return await self._read(query)
        async with self._many:  # one long table after the other: a stop has its turn beside one
            return await self._read(query)

    async def _read(self, query: HistoryQuery) -> tuple[HistoryLine, ...]:
        try:
            found = await self._data_context.container_store.history(query)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault
        vocabulary, lines = self._data_context.vocabulary, list[HistoryLine]()
        for number, entry in enumerate(found, start=1):
            lines.append(HistoryLine(entry, _asked(entry, vocabulary), _came(entry)))
            if number % STEP == 0:  # thousands hold up nobody's stop
                await asyncio.sleep(0)
        return tuple(lines)

    def _robot(self, who: PrincipalId, named: list[str]) -> RobotId:
        if not named:
            return ""
        [robot, *rest] = named
        if rest or robot not in self._data_context.visible(who):
            raise NotUnderstood(HOW, offers=("/history",))
        if not self._data_context.may_oversee(who, robot):
            shown = self._data_context.shown(robot)
            raise NotPermitted(
                said(
                    "What was asked of {robot} is read by admins and by whoever gives rights on "
                    "it. Your own is in history.",
                    robot=shown,
                )
            )
        return robot

    def _line(
        self,
        entry: HistoryEntry,
        robots: tuple[RobotId, ...],
        vocabulary: Vocabulary,
        who: PrincipalId,
    ) -> str:
        read = read_entry(entry, vocabulary)
        asked = stopped(robots, vocabulary) if entry.kind == STOPPED else read.asked
        if entry.kind == REFUSED and asked:
            asked = quote(asked)  # as they wrote it
        zone, now_ns = self._data_context.zone_of(who), self._data_context.clock.wall_ns()
        when = moment(read.at_ns, now_ns, zone)
        name = "" if read.who == who else self._data_context.name(read.who)
        parts = [when, *filter(None, (name, asked)), read.came]
        return joined(BETWEEN, parts)


def read_entry(entry: HistoryEntry, vocabulary: Vocabulary) -> ReadEntry:
    """Return an entry in words; what was erased, or cannot be read any more, is left out."""
    other = entry.kind if entry.kind in {RESUMED, STOPPED} else ""
    return ReadEntry(
        who=entry.principal,
        at_ns=entry.at_ns,
        robot=entry.robot,
        skill=entry.skill or other,
        outcome=entry.outcome or other,
        ended_ns=entry.ended_ns,
        asked=_asked(entry, vocabulary),
        came=_came(entry),
    )


def at_once(entries: Sequence[HistoryEntry]) -> Iterator[tuple[HistoryEntry, tuple[RobotId, ...]]]:
    """Yield entries as lines show them: who stopped several robots at once did one thing.

    Yields:
        The first of them, and the robots of all of them.
    """
    first: HistoryEntry | None = None
    robots: list[RobotId] = []
    for entry in entries:
        if first is not None and not _same_stop(first, entry):
            yield first, tuple(robots)
            first = None
        if first is None:
            first, robots = entry, []
        robots.append(entry.robot)
    if first is not None:
        yield first, tuple(robots)


def _same_stop(first: HistoryEntry, entry: HistoryEntry) -> bool:
    both = first.kind == entry.kind == STOPPED and first.principal == entry.principal
    return both and abs(entry.at_ns - first.at_ns) < AT_ONCE_NS


def stopped(robots: Sequence[RobotId], vocabulary: Vocabulary) -> str:
    """Return what somebody did who stopped robots; each is named once."""
    names = [_shown(robot, vocabulary) for robot in dict.fromkeys(robots)]
    few = names[:NAMED_AT_MOST]
    if len(names) > len(few):
        few.append(said_n("and one more", "and {n} more", len(names) - len(few)))
    return said("stop {robots}", robots=joined(", ", few))


def _asked(entry: HistoryEntry, vocabulary: Vocabulary) -> str:
    if entry.kind == STOPPED:
        return stopped((entry.robot,), vocabulary)
    if entry.kind == RESUMED:
        return said("resume {robots}", robots=_shown(entry.robot, vocabulary))
    if entry.kind == REFUSED:
        answer = _read(records.read_answer, entry.letter)
        return "" if answer is None else _one_line(answer.asked)
    shown, origin = _shown(entry.robot, vocabulary), _read(records.read_reply_to, entry.letter)
    if origin is None:
        return f"{shown}: {entry.skill}"
    compiled = vocabulary.compiled_skill(entry.robot, entry.skill)
    if origin.values is None or compiled is None:
        return named_once(_one_line(origin.title))
    words = (
        live_words(compiled.skill)
        if origin.live
        else show(vocabulary, entry.robot, compiled.skill, _known(compiled, origin.values))
    )
    parts = [joined(": ", (shown, words)), _task_of(origin.title)]
    return joined(BETWEEN, filter(None, parts))


def _task_of(title: str) -> str:
    """Return of which task, and which step of it, an order was; empty: of none."""
    _, between, origin_of = title.rpartition(BETWEEN)
    if not between or not origin_of.startswith(TASK):
        return ""
    task = origin_of.removeprefix(TASK)
    found = _STEP.fullmatch(task)
    if found is None:
        return said("task {task}", task=task)
    number, step, steps = found.groups()
    return said("task {task}, step {step} of {steps}", task=number, step=step, steps=steps)


def _known(compiled: CompiledSkill, values: Mapping[str, Argument]) -> dict[str, Argument]:
    """Return the values that fit the profile of now: it may have changed since."""
    return {
        p.name: values[p.name]
        for p in compiled.parameters
        if p.name in values and isinstance(values[p.name], str) is not p.is_number
    }


def _shown(robot: RobotId, vocabulary: Vocabulary) -> str:
    profile = vocabulary.profiles.get(robot)
    return robot if profile is None else profile.shown


def named_once(title: str) -> str:
    """Return the first line of a card without the name that was typed behind the robot's own."""
    name, colon, rest = title.partition(": ")
    first, _, asked = rest.partition(" ")
    return f"{name}{colon}{asked}" if asked and first.casefold() == name.casefold() else title


def _read(decode: Callable[[bytes], L], letter: bytes | None) -> L | None:
    if letter is None:
        return None
    try:
        return decode(letter)
    except msgspec.MsgspecError:
        return None


def _came(entry: HistoryEntry) -> str:
    if entry.kind == RESUMED:
        return said("stayed stopped") if entry.outcome else said("ready again")
    if entry.kind == STOPPED:
        return said("told to stop")  # whether it came to rest is not on the record
    if entry.kind == REFUSED:
        return _refusal(entry)
    if entry.words:
        return _one_line(entry.words.decode("utf-8", "replace"))
    if not entry.outcome:
        return said("no end is known yet")
    return ended_as(entry.outcome)


def _refusal(entry: HistoryEntry) -> str:
    answer = _read(records.read_answer, entry.letter)
    if answer is None:
        return said("refused ({code})", code=entry.outcome)
    return _one_line(answer.text)


def _one_line(text: str) -> str:
    return " ".join(clean(text[:LONGEST]).split())
