"""``/plan``: what everybody wishes for, weighed together, and booked by one tap."""

from __future__ import annotations

import asyncio
import re
from collections import Counter
from contextlib import suppress
from hashlib import blake2b
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.core.i18n import joined, said
from rosic.core.identity import RECORD_ID_BYTES
from rosic.core.language.ast import Misunderstood
from rosic.core.language.compiled import fold
from rosic.core.language.keywords import option_typed
from rosic.core.language.time_parser import read_when
from rosic.core.message import Button
from rosic.core.robot.profile import Slots
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, Refusal, TooManyRequests
from rosic.features.booking import messages, plan_messages
from rosic.features.booking import plan_messages as words
from rosic.features.booking.context import decided
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.planning.figures import figures_of
from rosic.organiser.planning.greedy import first_come_first_served
from rosic.organiser.planning.problem import PRIORITIES, PlanCaveat, PlanningProblem, StandingSlot
from rosic.organiser.planning.solver import propose
from rosic.organiser.planning.wish_file import length_of
from rosic.organiser.planning.wishes import place_of
from rosic.organiser.recurrence import occasion

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.language.time_parser import RequestedTime
    from rosic.core.records import Fact, Record
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.planning.problem import Allocation, Proposal
    from rosic.organiser.planning.wishes import RecordedWish


# ---- wish ----

# ``/wish kuka1 1h tomorrow 9:00 to 17:00``, ``any of air 1h mon 9-17 priority 3``, ``off 1``.

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


# ---- plan ----

LIMIT_S = 5.0
MOST_LINES = 40
# Said by buttons, the first with the proposal's id after it.
BOOK, LEAVE = "book", "leave"


class WeighedProposal(NamedTuple):
    """A proposal, and how much robots are used by it and by the order of arrival."""

    proposal: Proposal
    use: float
    by_arrival: float


class PlanCommand:
    """The handler who makes plans. What is proposed lives in memory: after a restart, anew."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._proposed: dict[PrincipalId, tuple[str, tuple[Allocation, ...]]] = {}
        self._busy = False

    async def plan(self, asked: CommandContext) -> Reply:
        """Propose, book what was proposed, or leave it.

        Raises:
            Refusal: Why not; nothing was booked.
        """
        by = asked.caller.principal
        self._robots(by)
        verb, _, rest = asked.rest.strip().partition(" ")
        if verb == LEAVE:
            self._proposed.pop(by, None)
            return Reply(words.left_as_it_is())
        if verb == BOOK:
            return await self._book(by, rest.strip())
        return await self._propose(by)

    def _robots(self, by: PrincipalId) -> frozenset[RobotId]:
        """Return the robots whose times somebody decides on, whoever has them."""
        sides, profiles = self._times.sides, self._times.vocabulary.profiles
        found = frozenset(robot for robot in profiles if sides.may_cancel_any(by, robot))
        if not found:
            raise NotPermitted(words.not_you())
        return found & sides.visible(by)

    # ---- proposing ----

    async def _propose(self, by: PrincipalId) -> Reply:
        wishes, full = self._shared(self._times.wishes.everybodys())
        if not wishes and not full:
            return Reply(words.nobody())
        problem = self._problem(by, wishes)
        if self._busy:
            raise TooManyRequests(words.busy(), retry_after_s=LIMIT_S)
        self._busy = True
        try:
            weighed = await asyncio.to_thread(_weigh, problem)
        finally:
            self._busy = False
        given = weighed.proposal.allocations
        text = self._text(by, weighed, full)
        if not given:
            return Reply(text)
        key = _id(given)
        self._proposed[by] = key, given
        yes = Button(said("Book all of it"), f"/plan {BOOK} {key}")
        return asks_first(text, ((yes, Button(said("Leave it"), f"/plan {LEAVE}")),))

    def _shared(
        self, wishes: tuple[RecordedWish, ...]
    ) -> tuple[list[RecordedWish], list[RecordedWish]]:
        """Split off what is beyond the times that one person may have to come."""
        most = self._times.calendar.limits.most_upcoming
        count: Counter[PrincipalId] = Counter()
        kept: list[RecordedWish] = []
        full: list[RecordedWish] = []
        for wished in wishes:
            who = wished.principal
            if who not in count:
                count[who] = len(self._times.upcoming(who))
            (kept if count[who] < most else full).append(wished)
            count[who] += 1
        return kept, full

    def _problem(self, by: PrincipalId, wishes: list[RecordedWish]) -> PlanningProblem:
        times, robots = self._times, self._robots(by)
        now_ns, may_book = times.clock.wall_ns(), times.sides.may_book
        last_ns = max((wished.latest_ns for wished in wishes), default=now_ns)
        used = sorted(robots & {robot for wished in wishes for robot in wished.robots})
        booked = (s for robot in used for s in times.calendar.on(robot, now_ns, last_ns))
        return PlanningProblem(
            wishes=tuple(
                wished.wish(
                    tuple(
                        robot
                        for robot in wished.robots
                        if robot in robots and may_book(wished.principal, robot) is None
                    ),
                    now_ns,
                )
                for wished in wishes
            ),
            robots=tuple(used),
            booked=tuple(StandingSlot(slot.robot, slot.start_ns, slot.end_ns) for slot in booked),
        )

    def _text(self, by: PrincipalId, weighed: WeighedProposal, full: list[RecordedWish]) -> str:
        times, proposal = self._times, weighed.proposal
        count = len(proposal.allocations) + len(proposal.left) + len(full)
        lines = [words.slot(times, place, by) for place in proposal.allocations]
        for left in proposal.left:
            wished = times.wishes.get(left.wish.id)
            if wished is not None:
                lines.append(words.left(times, wished, left.why, by))
        lines += [words.left(times, wished, None, by) for wished in full]
        if len(lines) > MOST_LINES:
            lines = [*lines[:MOST_LINES], words.more(len(lines) - MOST_LINES)]
        last = words.use(weighed.use, weighed.by_arrival)
        if proposal.note is PlanCaveat.NO_SOLVER:
            last = words.no_solver()
        return joined("\n", (words.head(len(proposal.allocations), count), *lines, last))

    # ---- booking ----

    async def _book(self, by: PrincipalId, key: str) -> Reply:
        known, given = self._proposed.pop(by, ("", ()))
        if not given or known != key:
            return await self._anew(by)
        times = self._times
        async with times.changes.turn() as turn:
            records = self._records(by, given)
            if records:
                await turn.write(records)
        if not records:
            return await self._anew(by)
        for place in given:
            times.reach.tell((place.wish.principal,), words.yours(times, place))
        return Reply(words.booked(len(given)))

    async def _anew(self, by: PrincipalId) -> Reply:
        reply = await self._propose(by)
        return msgspec.structs.replace(reply, text=joined("\n", (words.changed(), reply.text)))

    def _records(self, by: PrincipalId, given: tuple[Allocation, ...]) -> tuple[Record, ...]:
        """Return what books all of it; nothing if any part is not possible any more."""
        times, robots = self._times, self._robots(by)
        slots: list[Fact] = []
        wishes: list[Fact] = []
        for place in given:
            who, wished = place.wish.principal, times.wishes.get(place.wish.id)
            gone = wished is None or place.robot not in robots
            if wished is None or gone or times.sides.may_book(who, place.robot) is not None:
                return ()
            try:
                slots += times.calendar.book(
                    who, place.robot, place.start_ns, place.wish.length_s, by
                )
            except Refusal:
                return ()
            wishes.append(wished.no_more())
        if self._too_many(given):
            return ()
        return decided("book", by, times.clock.wall_ns(), (*slots, *wishes))

    def _too_many(self, given: tuple[Allocation, ...]) -> bool:
        most = self._times.calendar.limits.most_upcoming
        shares = Counter(place.wish.principal for place in given)
        return any(len(self._times.upcoming(who)) + more > most for who, more in shares.items())


def _weigh(problem: PlanningProblem) -> WeighedProposal:
    """Work a proposal out: seconds of computing, in a thread of its own."""
    proposal = propose(problem, limit_s=LIMIT_S)
    by_arrival = first_come_first_served(problem, grid_s=proposal.grid_s)
    uses = (figures_of(problem, plan).use for plan in (proposal, by_arrival))
    return WeighedProposal(proposal, *uses)


def _id(given: tuple[Allocation, ...]) -> str:
    digest = blake2b(digest_size=RECORD_ID_BYTES)
    for place in given:
        digest.update(ascii((place.wish.id, place.robot, place.start_ns)).encode())
    return digest.hexdigest()
