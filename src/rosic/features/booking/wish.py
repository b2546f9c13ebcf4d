"""``/wish kuka1 1h tomorrow 9:00 to 17:00``, ``any of air 1h mon 9-17 priority 3``, ``off 1``."""

from __future__ import annotations

import re
from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.compiled import fold
from rosic.core.language.option_words import option_typed
from rosic.core.language.time_parser import read_when
from rosic.core.message import Button
from rosic.core.robot.profile import Slots
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.features.booking import messages, plan_messages
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.planning.problem import PRIORITIES
from rosic.organiser.planning.wish_file import length_of
from rosic.organiser.planning.wishes import place_of
from rosic.organiser.recurrence import occasion

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.language.time_parser import RequestedTime
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext

OFF = "off"
_MOST_WORDS_OF_LENGTH = 4
_ENDS = ".,;:!?"
_PRIORITY = re.compile(r"(?<![\s,])[\s,]+prio(?:rity|rität)?:? ?(\d{1,9})\Z", re.IGNORECASE)


class WishCommand:
    """The handler who puts wishes down."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def wish(self, asked: CommandContext) -> Reply:
        """Put a wish down, list the person's own, or take one back.

        Raises:
            Refusal: Why not; nothing has changed.
        """
        text = asked.rest.strip().rstrip(_ENDS)
        if not text:
            return self._list(asked.caller.principal)
        first, _, rest = text.partition(" ")
        if option_typed(fold(first)) == OFF:
            return await self._off(asked.caller.principal, rest.strip())
        return await self._put(asked, text)

    async def _put(self, asked: CommandContext, text: str) -> Reply:
        times, principal = self._times, asked.caller.principal
        text, priority = _priority(text)
        robots, rest = self._naming.robots(asked, "wish", text)
        length_s, when = self._read(principal, robots[0], rest)
        found = occasion(robots[0], when, times.sides.zone_of(principal))
        window = found.start_ns, found.start_ns + found.length_s * SECOND_NS
        async with times.changes.turn() as turn:
            robots = self._useful(principal, robots)
            facts = times.wishes.put(principal, robots, length_s, window, priority)
            start_ns = max(found.start_ns, times.clock.wall_ns())
            with suppress(SlotTaken):  # nothing is booked: only whether it could be, some time
                times.calendar.book(principal, robots[0], start_ns, length_s, principal)
            await turn.write(facts)
        mine = times.wishes.of(principal)
        place = len(mine)
        line = plan_messages.one(times, mine[-1], principal)
        button = Button(said("Take it back"), f"/wish {OFF} {place}")
        return Reply(plan_messages.noted(line), ((button,),))

    def _read(self, principal: PrincipalId, robot: RobotId, text: str) -> tuple[int, RequestedTime]:
        """Return how long, and the window; the length is said before the window or after it."""
        zone, now_ns = self._times.sides.zone_of(principal), self._times.clock.wall_ns()
        raw = text.split()
        splits = [(raw[:n], raw[n:]) for n in range(min(len(raw), _MOST_WORDS_OF_LENGTH), 0, -1)]
        splits += [(raw[n:], raw[:n]) for n in range(len(raw) - 1, 0, -1)[:_MOST_WORDS_OF_LENGTH]]
        for length, window in splits:
            length_s = length_of(" ".join(length).lower())
            if length_s is None or not window:
                continue
            when = read_when(" ".join(window), now_ns, zone.local)
            if not isinstance(when, Misunderstood):
                if when.rrule:
                    raise OutOfBounds(plan_messages.once_only())
                return length_s, when
        offers = (f"wish {robot} 1h tomorrow 9:00 to 17:00", f"wish {robot} 30 min today 14-18")
        raise NotUnderstood(plan_messages.how_to_wish(), offers=offers)

    def _useful(self, principal: PrincipalId, robots: tuple[RobotId, ...]) -> tuple[RobotId, ...]:
        """Return those that can be booked by this person; refuse if there is none."""
        sides, profiles = self._times.sides, self._times.vocabulary.profiles
        refusal: Refusal | None = None
        useful: list[RobotId] = []
        for robot in robots:
            why = sides.may_book(principal, robot)
            if why is None and profiles[robot].slots is Slots.NONE:
                shown = self._times.shown(robot)
                why = OutOfBounds(messages.not_booked(shown), offers=(f"wait {robot}",))
            if why is None:
                useful.append(robot)
            refusal = refusal or why
        if not useful and refusal is not None:
            raise refusal
        return tuple(useful)

    def _list(self, principal: PrincipalId) -> Reply:
        mine = self._times.wishes.of(principal)
        if not mine:
            return Reply(plan_messages.no_wishes())
        lines = (
            joined("", (f"{place}. ", plan_messages.one(self._times, wished, principal)))
            for place, wished in enumerate(mine, 1)
        )
        return Reply(joined("\n", (plan_messages.your_wishes(), *lines)))

    async def _off(self, principal: PrincipalId, text: str) -> Reply:
        times = self._times
        async with times.changes.turn() as turn:
            wished, facts = times.wishes.off(principal, place_of(text))
            line = plan_messages.one(times, wished, principal)
            await turn.write(facts)
        return Reply(plan_messages.taken_back(line))


def _priority(text: str) -> tuple[str, int]:
    """Split off how much somebody would like it, if they say so at the end."""
    found = _PRIORITY.search(text)
    return (text, PRIORITIES[0]) if found is None else (text[: found.start()], int(found[1]))
