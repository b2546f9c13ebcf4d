"""``/cancel booking``: my times as buttons; of a time that comes again, this one or all of them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language.compiled import fold
from rosic.core.language.sanitise import echo
from rosic.core.message import Button
from rosic.errors import NotUnderstood
from rosic.features.booking import messages as words
from rosic.features.booking.context import decided
from rosic.features.booking.messages import CANCEL
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_messages import no_such_time

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext

MOST_LISTED = 8

# Said by buttons, with an id after them.
ONLY, ALL, FROM = "only", "all", "from"
BOOKINGS = frozenset(
    {"booking", "bookings", "time", "times", "slot", "slots"}
    | {"buchung", "buchungen", "termin", "termine", "zeit", "zeiten"}
)
_ID = re.compile(r"[0-9a-f]{8,}\Z")


class CancelBookingCommand:
    """The handler who takes times back."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def cancel(self, asked: CommandContext) -> Reply:
        """List what can be cancelled, ask, or cancel.

        Raises:
            Refusal: Why not; nothing has changed.
        """
        first, _, rest = asked.rest.strip().partition(" ")
        if fold(first) in BOOKINGS:
            asked = replace(asked, rest=rest)
        said = fold(asked.rest).split()
        if not said or said[0] == FROM or said in ([ALL], [ONLY]):
            return self._list(asked, _page(said))
        typed = asked.rest.strip()
        if said[0] in {ALL, ONLY}:
            if _ID.match(said[1]):
                return await (self._all if said[0] == ALL else self._one)(asked, said[1])
            typed = typed.partition(" ")[2].strip()
        if self._times.calendar.slot(said[0]) is None:  # a name, typed: which of those times?
            robots, name, rest = self._naming.at_head(asked, typed)
            if robots:
                return self._list(asked, _page(fold(rest).split()), robots, name)
            if not _ID.match(said[0]):
                raise NotUnderstood(
                    words.nothing_so_called(echo(typed)), offers=("cancel booking",)
                )
        return await self._ask_or_cancel(asked, said[0])

    def _list(
        self, asked: CommandContext, begin: int, robots: tuple[RobotId, ...] = (), name: str = ""
    ) -> Reply:
        times, principal = self._times, asked.caller.principal
        zone, now_ns = times.sides.zone_of(principal), times.clock.wall_ns()
        entries: dict[str, list[BookedSlot]] = {}
        for slot in times.upcoming(principal):
            if not robots or slot.robot in robots:
                entries.setdefault(slot.series or slot.id, []).append(slot)
        if not entries:
            return Reply(self._none_of(robots))
        page = list(entries.values())[begin : begin + MOST_LISTED]
        lines, buttons = [words.which_to_cancel(zone)], []
        for slots in page:
            line = words.mine(times.shown(slots[0].robot), slots[0], now_ns, zone)
            lines.append(
                joined("", (line, words.again(len(slots) - 1))) if len(slots) > 1 else line
            )
            buttons.append((Button(line, f"{CANCEL} {slots[0].id}"),))
        left = len(entries) - begin - len(page)
        if left > 0:
            lines.append(words.and_more(left))
            more = " ".join((CANCEL, *name.split(), FROM, str(begin + len(page))))
            buttons.append((Button(said("More"), more),))
        return Reply(joined("\n", lines), tuple(buttons))

    def _none_of(self, robots: tuple[RobotId, ...]) -> str:
        if not robots:
            return words.NO_TIMES
        return words.no_times_with(tuple(map(self._times.shown, robots)))

    async def _ask_or_cancel(self, asked: CommandContext, slot_id: str) -> Reply:
        times, principal = self._times, asked.caller.principal
        slot = self._seen(principal, times.calendar.slot(slot_id))
        if not slot.series:
            return await self._one(asked, slot_id)
        left = self._left_of(slot)
        if len(left) == 1 and left[0] is slot:
            return await self._all(asked, slot.series)
        zone, now_ns = times.sides.zone_of(principal), times.clock.wall_ns()
        shown = times.shown(slot.robot)
        row = (
            Button(said("This one"), f"{CANCEL} {ONLY} {slot.id}"),
            Button(said("All of them"), f"{CANCEL} {ALL} {slot.series}"),
        )
        when = words.soon(slot, now_ns, zone)
        return Reply(words.this_or_all(shown, when, len(left)), (row,))

    async def _one(self, asked: CommandContext, slot_id: str) -> Reply:
        times, by = self._times, asked.caller.principal
        async with times.changes.turn() as turn:
            slot = self._seen(by, times.calendar.slot(slot_id))
            anybodys = times.sides.may_cancel_any(by, slot.robot)
            facts = times.calendar.cancel(slot_id, by, anybodys=anybodys)
            now_ns = times.clock.wall_ns()
            await turn.write(decided("cancel", by, now_ns, facts))
        self._tell_owner(by, (slot,))
        shown, zone = times.shown(slot.robot), times.sides.zone_of(by)
        if slot.start_ns < now_ns:
            return Reply(words.given_back(shown, slot, now_ns, zone))
        return Reply(words.cancelled(shown, slot, zone))

    async def _all(self, asked: CommandContext, series_id: str) -> Reply:
        times, by = self._times, asked.caller.principal
        async with times.changes.turn() as turn:
            series = times.calendar.series(series_id)
            if series is None or not self._may_know(by, series.principal, series.robot):
                raise NotUnderstood(no_such_time(), offers=("cancel booking",))
            anybodys = times.sides.may_cancel_any(by, series.robot)
            facts = times.calendar.cancel_series(series_id, by, anybodys=anybodys)
            slots = self._slots(facts)
            if not slots:
                raise NotUnderstood(no_such_time(), offers=("cancel booking",))
            await turn.write(decided("cancel", by, times.clock.wall_ns(), facts))
        self._tell_owner(by, slots)
        zone = times.sides.zone_of(by)
        return Reply(words.cancelled_series(times.shown(series.robot), slots, zone))

    # ---- whose ----

    def _may_know(self, by: PrincipalId, owner: PrincipalId, robot: str) -> bool:
        return owner == by or robot in self._times.sides.visible(by)

    def _seen(self, by: PrincipalId, slot: BookedSlot | None) -> BookedSlot:
        """Return a slot that this person may know of; of others they hear nothing."""
        if slot is None or not self._may_know(by, slot.principal, slot.robot):
            raise NotUnderstood(no_such_time(), offers=("cancel booking",))
        return slot

    def _left_of(self, slot: BookedSlot) -> list[BookedSlot]:
        return [s for s in self._times.upcoming(slot.principal) if s.series == slot.series]

    def _slots(self, facts: Sequence[Fact]) -> tuple[BookedSlot, ...]:
        found = (self._times.calendar.slot(fact.key) for fact in facts)
        return tuple(slot for slot in found if slot is not None)

    def _tell_owner(self, by: PrincipalId, slots: tuple[BookedSlot, ...]) -> None:
        owner, times = slots[0].principal, self._times
        if owner != by:
            name, zone = times.calendar.name_of(by), times.sides.zone_of(owner)
            shown = times.shown(slots[0].robot)
            times.reach.tell((owner,), words.cancelled_by(shown, name, slots, zone))


def _page(said: list[str]) -> int:
    """Return where a page of the list begins, as the button for more of it says."""
    at = said[1] if len(said) > 1 and said[0] == FROM else "0"
    return int(at[:6]) if at.isdecimal() else 0
