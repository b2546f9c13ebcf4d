"""Orders as they happen, step by step, for whoever shows them: the newest, in memory."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.order import OrderStage
from rosic.core.robot.profile import RobotId
from rosic.core.signal import Signal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.contracts.clock import Clock
    from rosic.core.identity import CommandId
    from rosic.core.order import Order, Outcome, StageReport

KEPT: Final = 2_000
STAGES_AT_MOST: Final = 16


class StageTime(msgspec.Struct, frozen=True):
    """When an order came to a stage; wall clock of the gateway."""

    stage: str
    at_ns: int


class OrderEntry(msgspec.Struct):
    """One order, as far as it has come.

    Attributes:
        id: For ever; in hexadecimal digits.
        n: The robot's order number.
        words: What was sent to the robot, as people read it: ``move, 0.50 m left``.
        arguments: The same in SI.
        stages: Each once, in order. ``received`` and later are said by the robot's side only.
        fraction: How far its robot's side says it is, in [0, 1]; None: it does not say.
        ending: How it ended; empty while it goes on.
        note: The robot's words, or why it ended so; inert.
        code: Of a refusal, or of an end in doubt.
        ended_ns: Wall clock; 0 while it goes on.
    """

    id: str
    robot: RobotId
    skill: str
    n: int
    principal: PrincipalId
    words: str
    arguments: dict[str, float | int | str]
    stages: tuple[StageTime, ...]
    fraction: float | None = None
    ending: str = ""
    note: str = ""
    code: str = ""
    ended_ns: int = 0

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return bool(self.ending)

    def at_ns(self, stage: OrderStage) -> int | None:
        """Return when it came to a stage; None: not yet, or never."""
        return next((each.at_ns for each in self.stages if each.stage == stage.value), None)


class OrderFeed:
    """Keeps the newest orders, and says when one has changed.

    Attributes:
        changed: An order is new, has come further, or has ended.
    """

    def __init__(self, clock: Clock) -> None:
        self.changed: Signal[[OrderEntry]] = Signal()
        self._clock = clock
        self._entries: OrderedDict[str, OrderEntry] = OrderedDict()
        self._under_way: dict[str, OrderEntry] = {}  # as many as wait or run, however old

    def __getitem__(self, order: str) -> OrderEntry | None:
        """Return an order by its id; None: there is none, or none any more."""
        return self._entries.get(order) or self._under_way.get(order)

    def newest(self) -> Iterator[OrderEntry]:
        """Return all of them, the newest first."""
        return reversed(self._entries.values())

    # ---- gateway.order_watchers.OrderObserver ----

    def accepted(self, order: Order) -> None:
        """Take in that an order is on disk, and waits for its robot."""
        entry = OrderEntry(
            id=order_id(order.cid),
            robot=order.robot,
            skill=order.skill.id,
            n=order.n,
            principal=order.permit.principal,
            words=order.words,
            arguments=order.arguments,
            stages=(StageTime(OrderStage.ACCEPTED.value, self._clock.wall_ns()),),
        )
        self._entries[entry.id] = self._under_way[entry.id] = entry
        if len(self._entries) > KEPT:
            self._entries.popitem(last=False)
        self.changed.emit(entry)

    def reported(self, order: Order, report: StageReport) -> None:
        """Take in a step."""
        entry = self._under_way.get(order_id(order.cid))
        if entry is None:
            return
        stage = report.stage.value
        if entry.at_ns(report.stage) is None and len(entry.stages) < STAGES_AT_MOST:
            entry.stages += (StageTime(stage, self._clock.wall_ns()),)
        if report.fraction is not None:
            entry.fraction = max(report.fraction, entry.fraction or 0.0)
        entry.note = report.note or entry.note
        self.changed.emit(entry)

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Take in how it ended."""
        entry = self._under_way.get(order_id(order.cid))
        if entry is None:
            return
        self._under_way.pop(entry.id, None)
        entry.ending, entry.note, entry.code = outcome.ending.value, outcome.note, outcome.code
        entry.ended_ns = self._clock.wall_ns()
        self.changed.emit(entry)


def order_id(cid: CommandId) -> str:
    """Return how an order is named to programs."""
    return cid.hex()
