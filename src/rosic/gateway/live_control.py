"""Live orders: begun like any other, then steered by samples from outside.

Whoever serves a page or a protocol has a line of it carried out with ``Inbound.live``, takes the
order's controls by `LiveControl.open`, and puts samples into them. The order went through the four
rooms; what a sample may do was worked out then, from the skill's bounds and its author's limits,
and is worked out anew when the policy has moved. Nothing here reaches a robot by another way.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.live_control import LiveControls
from rosic.core.i18n import capital, said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.policy.query import Deny
from rosic.core.robot.skill import DURATION
from rosic.core.sample_gate import (
    LIVE_MOST_S,
    OVER,
    LiveRange,
    LiveSample,
    SampleGate,
    is_finite_number,
)
from rosic.errors import Expired, NotUnderstood, OrderVoid, OutOfBounds, Refusal, RobotBusy
from rosic.linker.linker import PolicyMoved
from rosic.linker.robot_queue import not_live

if TYPE_CHECKING:
    from collections.abc import Coroutine, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.language import Do
    from rosic.core.language.compiled import CompiledSkill
    from rosic.core.language.numbers import Unit
    from rosic.core.order import Order, Permit
    from rosic.core.policy.limits import Limit
    from rosic.core.robot.profile import RobotId
    from rosic.core.sample_gate import LiveEnd, SampleResult, SampleVerdict
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import Requester
    from rosic.gateway.order_execution import Dispatch, OrderExecutor

NOT_BEGUN = Outcome(
    OrderEnding.REFUSED, said("This was not begun. Nothing was done."), code="order-void"
)
ONE_AT_A_TIME = said("One robot is driven live at a time. Nothing was done.")
NO_SUCH = said("There is no live order of yours like that, or not any more.")
STEERED_ALREADY = said("That is being steered from elsewhere already.")


class LiveOrder:
    """One live order from its claim to its end.

    Attributes:
        order: As it was claimed, with the permit under which it goes on now.
        requester: Who is behind it.
        controls: What steers it.
        units: In which its parameters are given, by name.
        taken: Somebody has its controls.
        relayed: Its robot's turn has come.
        lost: Its author may not go on; it is being ended.
        ended: Its end, once there is one.
    """

    __slots__ = (
        "controls",
        "ended",
        "lost",
        "order",
        "relayed",
        "requester",
        "taken",
        "units",
    )

    def __init__(
        self, order: Order, requester: Requester, controls: LiveControls, units: dict[str, Unit]
    ) -> None:
        self.order = order
        self.requester = requester
        self.controls = controls
        self.units = units
        self.taken = self.relayed = self.lost = False
        self.ended: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()

    def take(self) -> None:
        """Somebody takes its controls.

        Raises:
            RobotBusy: Somebody has them.
        """
        if self.taken:
            raise RobotBusy(STEERED_ALREADY)
        self.taken = True

    def give_back(self) -> None:
        """Whoever had its controls is gone."""
        self.taken = False

    def relay(self, order: Order) -> None:
        """Its robot's turn has come, under the permit of now."""
        self.order, self.relayed = order, True

    def readmitted(self, permit: Permit) -> None:
        """It goes on under another permit."""
        self.order = replace(self.order, permit=permit)

    def lose(self) -> None:
        """Its author may not go on: no sample counts any more."""
        self.lost = True


class LiveInput:
    """The controls of one live order, in the hand of whoever steers it: one at a time.

    Attributes:
        order: Which it steers.
    """

    def __init__(self, live: LiveOrder, control: LiveControl) -> None:
        self.order = live.order
        self._live = live
        self._control = control
        self._closed = False

    @property
    def ranges(self) -> tuple[LiveRange, ...]:
        """How far each parameter may be steered now, SI."""
        return self._live.controls.gate.ranges

    @property
    def counts(self) -> Mapping[SampleVerdict, int]:
        """How many samples became what."""
        return self._live.controls.gate.counts

    @property
    def end(self) -> LiveEnd | None:
        """Why nothing is steered any more; None: it still is."""
        return self._live.controls.gate.end

    @property
    def outcome(self) -> Outcome | None:
        """How the order ended; None: it has not."""
        ended = self._live.ended
        return ended.result() if ended.done() else None

    def measure(self, theirs_ns: int, asked_ns: int) -> None:
        """Take in what the sender's clock showed when it was asked; see `SampleGate.measure`.

        Only before the first sample; without it, that one tells.

        Args:
            theirs_ns: Wall clock of the sender, as it answered.
            asked_ns: When it was asked, on this machine's monotonic clock (``Clock``).
        """
        self._live.controls.gate.measure(theirs_ns, asked_ns)

    def put(
        self,
        values: Mapping[str, float],
        sent_ns: int,
        sequence: int,
        order: CommandId | None = None,
    ) -> SampleResult:
        """Steer. It never waits, writes nothing, and keeps nothing but the newest.

        Args:
            values: By parameter, in the units of the profile; what is left out is zero.
            sent_ns: When it was sent, by its sender's wall clock.
            sequence: Of its sender: each higher than the one before.
            order: Which order it was sent for, where the sender says so.
        """
        units = self._live.units
        si = {
            name: units[name].to_si(value) if name in units and is_finite_number(value) else value
            for name, value in values.items()
        }
        return self.put_si(si, sent_ns, sequence, order)

    def put_si(
        self,
        values: Mapping[str, float],
        sent_ns: int,
        sequence: int,
        order: CommandId | None = None,
    ) -> SampleResult:
        """Steer likewise, with values in SI: what a robot's message holds."""
        if self._closed:
            return OVER
        sample = LiveSample(self.order.cid if order is None else order, values, sent_ns, sequence)
        return self._control.put(self._live, sample)

    def release(self) -> None:
        """Let go: the robot comes to rest, and the order is done."""
        if not self._closed:
            self._live.controls.release()

    def close(self) -> None:
        """Whoever steered is gone without letting go: without samples, the order ends by itself.

        Until then the controls may be opened once more.
        """
        if not self._closed:
            self._closed = True
            self._live.give_back()

    async def ended(self) -> Outcome:
        """Return how the order ended, once it has; cancelling this ends nothing."""
        return await asyncio.shield(self._live.ended)


class LiveControl:
    """Every live order that has not ended.

    Args:
        rooms: The four of them.
        executor: Relays orders, and says when they end.
        clock: The machine's, by which samples are late.
    """

    def __init__(self, rooms: Components, executor: OrderExecutor, clock: Clock) -> None:
        self._rooms = rooms
        self._executor = executor
        self._clock = clock
        self._orders: dict[CommandId, LiveOrder] = {}
        self._ending: BackgroundTasks[None] = BackgroundTasks()

    # ---- whoever serves people and programs that steer ----

    def line(self, robot: RobotId, skill: str) -> str:
        """Return what is said for a live order of a skill: every parameter given, at rest.

        Raises:
            NotUnderstood: There is no such skill, or nobody can steer it.
        """
        compiled = self._compiled(robot, skill)
        live_ranges(compiled, self._shown(robot), ())
        words = [robot, compiled.spoken]
        for parameter in compiled.parameters:
            if parameter.is_number:
                least = parameter.low if parameter.name == DURATION else 0.0
                number = f"{parameter.unit.from_si(least):.8g}"
                words.append(f"{parameter.name}={number} {parameter.unit.symbol}".rstrip())
            elif parameter.words and parameter.default is None:
                words.append(f"{parameter.name}={next(iter(parameter.words))}")
        return " ".join(words)

    def open(self, cid: CommandId, principal: PrincipalId) -> LiveInput:
        """Take the controls of a live order, from when its message was taken to its end.

        Raises:
            Expired: There is none of theirs with this id; the same whoever else has one.
            RobotBusy: Somebody has them: the same person, at another place.
        """
        live = self._orders.get(cid)
        if live is None or live.order.permit.principal != principal:
            raise Expired(NO_SUCH)
        live.take()
        return LiveInput(live, self)

    def put(self, live: LiveOrder, sample: LiveSample) -> SampleResult:
        """Take a sample, unless its author may not steer any more (I8)."""
        if live.lost or not (self._is_current(live) or self._is_admitted_anew(live)):
            return OVER
        return live.controls.put(sample)

    # ---- the pipeline ----

    def check(self, line: Do) -> None:
        """See that what is to be steered can be.

        Raises:
            NotUnderstood: It cannot; says why.
        """
        if len(line.robots) != 1:
            raise NotUnderstood(ONE_AT_A_TIME)
        robot, skill = line.robots[0], line.skills[0]
        shown = self._shown(robot)
        if not skill.streams:
            raise NotUnderstood(
                said(
                    "{skill} of {shown} cannot be driven live: it does not send velocities. "
                    "Nothing was done.",
                    skill=capital(skill.doing),
                    shown=shown,
                )
            )
        if not self._rooms.linker.drives_live(robot):
            raise NotUnderstood(not_live(shown))
        live_ranges(self._compiled(robot, skill.id), shown, ())

    def begin(self, order: Order, requester: Requester) -> Dispatch:
        """Know an order that was claimed; it may be opened from now on. Return what relays it."""
        ranges: tuple[LiveRange, ...] = ()
        units: dict[str, Unit] = {}
        with suppress(Refusal):  # said when it is relayed: here, its claim would have no end
            compiled = self._compiled(order.robot, order.skill.id)
            ranges = live_ranges(compiled, self._shown(order.robot), ())
            units = {parameter.name: parameter.unit for parameter in compiled.numbers}
        controls = LiveControls(SampleGate(order.cid, ranges, order.arguments), self._clock)
        if not self._orders:
            self._executor.watching.watch_orders(self)
            self._executor.watching.hear_ends(self._look, wanted=True)
        self._orders[order.cid] = LiveOrder(order, requester, controls, units)
        return self.relay

    def relay(self, order: Order, tell: Tell) -> Coroutine[Any, Any, Outcome]:
        """Relay it, with its controls; see `Linker.dispatch`.

        Raises:
            PolicyMoved: At once. It is admitted once more.
            OrderVoid: At once or awaited. The robot has not moved.
        """
        live = self._orders.get(order.cid)
        if live is None:
            raise OrderVoid(NOT_BEGUN.note)
        live.relay(order)
        self._confine(live)
        return self._rooms.linker.dispatch(order, tell, live.controls)

    def _confine(self, live: LiveOrder) -> None:
        """Let its author's limits of now count.

        Raises:
            PolicyMoved: They may not do it any more, as admitting it once more will say.
            OutOfBounds: They leave no rest.
        """
        order, requester = live.order, live.requester
        decision = self._rooms.organiser.decision(
            requester.caller, order.robot, order.skill.id, order.arguments, requester.auth_context()
        )
        if isinstance(decision, Deny):
            raise PolicyMoved(said("The rights have changed meanwhile."))
        limits = decision.way.limits if decision.way is not None else ()
        compiled = self._compiled(order.robot, order.skill.id)
        most_s = min((one.max for one in limits if one.parameter == DURATION), default=LIVE_MOST_S)
        live.controls.gate.confine(live_ranges(compiled, self._shown(order.robot), limits), most_s)

    def _is_current(self, live: LiveOrder) -> bool:
        permit, rooms = live.order.permit, self._rooms
        return rooms.organiser.wall_ns() < permit.until_ns and permit.epoch == rooms.linker.epoch

    def _is_admitted_anew(self, live: LiveOrder) -> bool:
        """Admit it once more under the present policy, or have it ended."""
        order, requester = live.order, live.requester
        try:
            permit = self._rooms.organiser.readmit(
                requester.caller, order, requester.auth_context()
            )
            live.readmitted(permit)
            self._confine(live)
        except (Refusal, PolicyMoved) as why:
            live.lose()
            reason = said("it may not go on: {why}", why=why.sentence)
            self._ending.begin(self._executor.cut_order(order.robot, order.cid, reason))
            return False
        return True

    # ---- what the executor tells ----

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot."""

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear that one is over: whoever steers it learns how."""
        if order.cid in self._orders:
            self._end(self._orders[order.cid], outcome)

    def _look(self, robot: RobotId) -> None:
        """An order of a robot has ended; one that had not begun is told of to nobody else."""
        asyncio.get_running_loop().call_soon(self._sweep, robot)

    def _sweep(self, robot: RobotId) -> None:
        there = {entry.order.cid for entry in self._rooms.linker.entries(robot)}
        gone = [
            live
            for live in self._orders.values()
            if live.order.robot == robot and not live.relayed and live.order.cid not in there
        ]
        for live in gone:
            self._end(live, NOT_BEGUN)

    def _end(self, live: LiveOrder, outcome: Outcome) -> None:
        del self._orders[live.order.cid]
        live.controls.leave()
        if not live.ended.done():
            live.ended.set_result(outcome)
        if not self._orders:
            self._executor.watching.watch_orders(self, wanted=False)
            self._executor.watching.hear_ends(self._look, wanted=False)

    # ---- what a profile says ----

    def _shown(self, robot: RobotId) -> str:
        return self._rooms.profiles[robot].shown

    def _compiled(self, robot: RobotId, skill: str) -> CompiledSkill:
        compiled = self._rooms.vocabulary.compiled_skill(robot, skill)
        if compiled is None:
            raise NotUnderstood(said("{robot} has no such skill. Nothing was done.", robot=robot))
        return compiled


def live_ranges(
    compiled: CompiledSkill, shown: str, limits: Iterable[Limit]
) -> tuple[LiveRange, ...]:
    """Return how far each number of a skill may be steered, SI: its duration is none of them.

    Args:
        compiled: The skill.
        shown: How people call its robot.
        limits: Of whoever steers.

    Raises:
        OutOfBounds: One can never be zero, so that nothing but the end would be rest.
    """
    narrower = {limit.parameter: limit for limit in limits}
    ranges: list[LiveRange] = []
    for parameter in compiled.numbers:
        if parameter.name == DURATION:
            continue
        low, high, limit = parameter.low, parameter.high, narrower.get(parameter.name)
        if limit is not None:
            low, high = max(low, limit.min), min(high, limit.max)
        if not low <= 0.0 <= high:
            raise OutOfBounds(
                said(
                    "{shown} cannot be driven live here: its {name} can never be zero. "
                    "Nothing was done.",
                    shown=shown,
                    name=parameter.shown,
                )
            )
        ranges.append(LiveRange(parameter.name, low, high, parameter.integer))
    return tuple(ranges)
