"""What is said after ``/at``, ``/in`` and ``/every``: a time, and orders one after another."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import ImperialCatalogue
from rosic.core.language import Do, LanguageReader, Misunderstood, clean
from rosic.core.language.arguments import unit_needed
from rosic.core.language.syntax_errors import LONGEST_OFFER
from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.language.time_tokens import length_said
from rosic.core.time_units import DAY_NS, SECOND_NS
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, Refusal
from rosic.features.scheduled_orders import messages as words
from rosic.features.scheduled_orders.schedule import ScheduledTime
from rosic.gateway.commands import check_length
from rosic.gateway.requests import is_said_to_us

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.gateway.agreement import Agreements, ResolvedAct
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.organiser.timezones import Zone

LONGEST_LINE: Final = 1_000
STEPS_AT_MOST: Final = 20
THENS: Final = frozenset({"then", "dann", "danach"})
LONGEST_TIME: Final = 12  # words
LONGEST_DELAY_NS: Final = 366 * DAY_NS
BEFORE_TIMES: Final = {"in": ["in"], "every": ["every"]}
"""What the verb itself says of the time."""


class ReadTime(NamedTuple):
    """A time at the beginning of a line.

    Attributes:
        used: How many words say it, with those that the verb stands for.
        note: What there is to know about it; mostly empty.
    """

    when: ScheduledTime
    used: int
    note: str


class OrderPlan(NamedTuple):
    """What somebody wants to be done later, as it would be now.

    Attributes:
        lines: Each step as it is read.
        acts: What each comes to for them.
    """

    when: ScheduledTime
    lines: tuple[Do, ...]
    acts: tuple[ResolvedAct, ...]
    note: str


class OrderPlanReader:
    """Reads plans; nothing is done by it."""

    def __init__(self, rooms: Components, agreements: Agreements, languages: ChatLanguages) -> None:
        self._rooms = rooms
        self._agreements = agreements
        self._languages = languages
        self._reader = LanguageReader(rooms.vocabularies)

    def meant(self, verb: str, asked: CommandContext) -> bool:
        """Whether words that say no plan were meant for ROSIC, and not for others in a group.

        People talk about robots there: only a time with a robot's name right behind it is meant.
        """
        if is_said_to_us(asked.inbound):
            return True
        typed = _typed(verb, asked.rest)
        callees, organiser = self._rooms.vocabulary.callees, self._rooms.organiser
        zone = organiser.calendar.zone(asked.caller.principal)
        try:
            times = list(_times(typed, organiser.wall_ns(), zone))
        except OutOfBounds:
            return False
        return any(word.casefold() in callees for t in times for word in typed[t.used : t.used + 1])

    async def read(self, verb: str, asked: CommandContext) -> OrderPlan:
        """Return what somebody plans.

        Raises:
            NotUnderstood: No time, or no order.
            OutOfBounds: A time that is over or never comes, too many steps, a value.
            NotPermitted: They may not do that at all, or it wants a person each time.
        """
        check_length(asked.rest, LONGEST_LINE)
        typed = _typed(verb, asked.rest)
        organiser, who = self._rooms.organiser, asked.caller.principal
        now_ns, zone = organiser.wall_ns(), organiser.calendar.zone(who)
        selected = self._rooms.container.selected(who, asked.inbound.chat)
        first: ReadTime | None = None
        for read in _times(typed, now_ns, zone):
            first = first or read
            steps = steps_of(typed[read.used :])
            if steps and isinstance(self._one(who, steps[0], selected), Do):
                return await self._planned(asked, read, typed, steps, selected)
        if first is None:
            raise NotUnderstood(words.NO_TIME, offers=())
        steps = steps_of(typed[first.used :])
        return await self._planned(asked, first, typed, steps, selected)

    def _one(self, who: PrincipalId, step: str, selected: str) -> object:
        return self._reader.lines(step, selected, self._rooms.organiser.visible(who))[0]

    async def _planned(
        self,
        asked: CommandContext,
        read: ReadTime,
        typed: list[str],
        steps: list[str],
        selected: str,
    ) -> OrderPlan:
        """Return a plan whose time is read.

        Raises:
            Refusal: One of its steps is none; what could be said instead is offered as a whole.
        """
        if not steps:
            raise NotUnderstood(words.NO_STEPS)
        if len(steps) > STEPS_AT_MOST:
            raise OutOfBounds(words.too_many_steps(STEPS_AT_MOST))
        lines: list[Do] = []
        acts: list[ResolvedAct] = []
        for number, step in enumerate(steps):
            await asyncio.sleep(0)  # each may be for many robots: a stop does not wait for twenty
            try:
                line = self._step(asked, step, selected)
                act = self._agreements.of(line, asked.caller)
            except Refusal as why:
                before = ["/at", *typed[: read.used]]
                whole = [[*steps[:number], offer, *steps[number + 1 :]] for offer in why.offers]
                offers = [" ".join((*before, "; ".join(each))) for each in whole]
                why.offering(tuple(offer for offer in offers if len(offer) <= LONGEST_OFFER))
                raise
            lines.append(line)
            acts.append(act)
            selected = line.name
        return OrderPlan(read.when, tuple(lines), tuple(acts), read.note)

    def _step(self, asked: CommandContext, step: str, selected: str) -> Do:
        """Return one step, if its author may do it at all."""
        rooms, who = self._rooms, asked.caller.principal
        line = self._one(who, step, selected)
        if isinstance(line, Misunderstood):
            raise NotUnderstood(line.sentence, offers=line.offers)
        if not isinstance(line, Do):
            raise NotUnderstood(words.no_order(step))
        for robot, skill in zip(line.robots, line.skills, strict=True):
            shown = rooms.profiles[robot].shown
            if not rooms.organiser.allows(who, robot, skill.id):
                rooms.organiser.check_word(asked.caller, robot, skill.id)
                raise NotPermitted(words.not_permitted(shown, skill.shown))
            if rooms.organiser.rights.caution(robot, skill.id).needs:
                raise NotPermitted(words.wants_a_person(shown, skill.shown))
        if asked.inbound.nonce is None and isinstance(self._languages.of(who), ImperialCatalogue):
            doubt = unit_needed(rooms.vocabulary, line)
            if doubt is not None:
                raise NotUnderstood(doubt.sentence, offers=doubt.offers)
        return line


def _typed(verb: str, rest: str) -> list[str]:
    """Return the words of a plan, with those that its verb stands for."""
    return [*BEFORE_TIMES.get(verb, ()), *clean(rest).replace("\n", " ").split()]


def steps_of(typed: Sequence[str]) -> list[str]:
    """Return the orders that words say, one after another: ``a; b then c``."""
    said: list[list[str]] = [[]]
    for word in typed:
        bare = word.rstrip(";")
        then = word.casefold() in THENS
        if bare and not then:
            said[-1].append(bare)
        if then or bare != word:
            said.append([])
    return [" ".join(step) for step in said if step]


def _times(typed: list[str], now_ns: int, zone: Zone) -> Iterator[ReadTime]:
    """Yield the times with which a line may begin, the longest first."""
    for used in range(min(len(typed), LONGEST_TIME), 0, -1):
        if typed[0].casefold() == "in":
            seconds, said = length_said([word.casefold() for word in typed[1:used]])
            delay_ns = int(seconds * SECOND_NS)
            if used == 1 or said != used - 1:
                continue
            if not 0 < delay_ns <= LONGEST_DELAY_NS:
                raise OutOfBounds(words.TOO_FAR if delay_ns > 0 else words.OVER)
            yield ReadTime(ScheduledTime(zone.name, at_ns=now_ns + delay_ns), used, "")
            continue
        when = read_when(f"{' '.join(typed[:used])} 1 min", now_ns, zone.local)
        if isinstance(when, RequestedTime):
            yield _time_of(when, used, now_ns, zone)


def _time_of(when: RequestedTime, used: int, now_ns: int, zone: Zone) -> ReadTime:
    """Return when that is.

    Raises:
        OutOfBounds: It is over, or the clocks skip it.
    """
    if when.rrule:
        again = ScheduledTime(zone.name, first=when.start, rrule=when.rrule)
        if again.after(now_ns) is None:
            raise OutOfBounds(words.OVER)
        return ReadTime(again, used, "")
    at_ns, note = when.start_ns, ""
    if at_ns is None:
        instant = zone.instant(when.start)
        if instant.kind == "never":
            raise OutOfBounds(words.skipped(when.start, zone, instant.possible))
        at_ns = instant.start_ns
        note = words.comes_twice(when.start, zone) if instant.kind == "twice" else ""
    if at_ns <= now_ns:
        raise OutOfBounds(words.OVER)
    return ReadTime(ScheduledTime(zone.name, at_ns=at_ns), used, note)
