"""What is measured of a gateway: orders, stops, refusals, rates, queues, links, the event loop.

No label names a person, and what a label may say is bounded: robots and messengers of the
configuration, stages and endings of orders, codes of refusals.
"""

from __future__ import annotations

import asyncio
import os
import resource
from collections import Counter, OrderedDict
from typing import TYPE_CHECKING, Final

from rosic import __version__
from rosic.api.metrics.exposition import COUNTER, GAUGE, HISTOGRAM, Histogram, Metric, Sample, page
from rosic.api.rate_feed import messenger_counts, robot_counts
from rosic.contracts.traffic import is_connected
from rosic.core.i18n import said
from rosic.core.order import OrderStage
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.identity import CommandId
    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.traffic import TrafficCount
    from rosic.gateway.feature import Kernel

HOPS: Final = ("accepted-sent", "sent-received", "received-ended", "accepted-ended")
HOP_BOUNDS: Final = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
LAG_BOUNDS: Final = (0.001, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5)
LAG_EVERY_S: Final = 0.25
_PASSED: Final = {
    ("messenger", "messages"): said("Messages that passed a messenger's link."),
    ("messenger", "bytes"): said("Bytes that passed a messenger's link."),
    ("robot", "messages"): said("Messages that passed a robot's link."),
    ("robot", "bytes"): said("Bytes that passed a robot's link."),
}
FOLLOWED_AT_MOST: Final = 5_000
"""Orders under way whose hops are timed; of more than these the oldest are not."""


class OrderMetrics:
    """Counts orders by how they end, and times their hops; see `OrderObserver`.

    Times are of the gateway's own clock: ``received`` is when its word came here.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._clock = kernel.machine_clock
        self._began: OrderedDict[CommandId, dict[str, int]] = OrderedDict()
        self._ended: Counter[tuple[str, str]] = Counter()
        self._hops = {hop: Histogram(HOP_BOUNDS) for hop in HOPS}

    def accepted(self, order: Order) -> None:
        """Begin to time an order."""
        self._began[order.cid] = {OrderStage.ACCEPTED.value: self._clock.monotonic_ns()}
        if len(self._began) > FOLLOWED_AT_MOST:
            self._began.popitem(last=False)

    def reported(self, order: Order, report: StageReport) -> None:
        """Note when a stage was reached."""
        began = self._began.get(order.cid)
        if began is not None:
            began.setdefault(report.stage.value, self._clock.monotonic_ns())

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Count how it ended."""
        self._ended[order.robot, outcome.ending.value] += 1
        stages = self._began.pop(order.cid, {}) | {"ended": self._clock.monotonic_ns()}
        for hop, histogram in self._hops.items():
            first, then = hop.split("-")
            if first in stages and then in stages:
                histogram.observe((stages[then] - stages[first]) / SECOND_NS)

    def metrics(self) -> Iterator[Metric]:
        """Yield what was counted."""
        yield Metric(
            "rosic_orders_total",
            COUNTER,
            said("Orders that are over, by robot and by how they ended."),
            tuple(Sample({"robot": r, "outcome": o}, n) for (r, o), n in self._ended.items()),
        )
        yield Metric(
            "rosic_order_hop_seconds",
            HISTOGRAM,
            said("How long orders took from one stage to another."),
            tuple(Sample({"hop": hop}, found) for hop, found in self._hops.items()),
        )
        about = said("Orders accepted and not over.")
        yield _value("rosic_orders_under_way", about, len(self._began))


class LoopMonitor:
    """Measures how late the event loop comes to what is due."""

    def __init__(self) -> None:
        self._lag = Histogram(LAG_BOUNDS)

    async def run(self) -> None:
        """Measure until cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            due_s = loop.time() + LAG_EVERY_S
            await asyncio.sleep(LAG_EVERY_S)
            self._lag.observe(max(0.0, loop.time() - due_s))

    def metrics(self) -> Iterator[Metric]:
        """Yield what was measured."""
        about = said("How late the event loop came to what was due, four times a second.")
        yield Metric("rosic_loop_lag_seconds", HISTOGRAM, about, (Sample({}, self._lag),))


class GatewayMetrics:
    """Everything that is measured, put together when it is asked for.

    Args:
        kernel: Of a gateway that is open.

    Attributes:
        loop: Has to run, to measure the event loop.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._orders = OrderMetrics(kernel)
        self.loop = LoopMonitor()
        kernel.pipeline.executor.watching.observe(self._orders)

    def close(self) -> None:
        """Follow orders no more."""
        self._kernel.pipeline.executor.watching.observe(self._orders, wanted=False)

    @property
    def not_ready(self) -> tuple[str, ...]:
        """Return why nobody should be led here now, a line each; empty: nothing speaks against.

        A messenger that is away is none of it while another way in is there, the page perhaps: who
        stops a robot by that one must still be led here.
        """
        late = ("the record does not answer in time",) if self._kernel.changes.late else ()
        links = [is_connected(messenger) for messenger in self._kernel.messengers]
        deaf = links and all(link is False for link in links)
        heard = ("no messenger is connected",) if deaf else ()
        process = self._kernel.shared.not_ready.find()
        return (*late, *heard, *(() if process is None else process()))

    def page(self) -> bytes:
        """Return all of it as Prometheus reads it."""
        return page(self.metrics())

    def metrics(self) -> Iterator[Metric]:
        """Yield it metric by metric; one may have no sample."""
        yield from self._orders.metrics()
        yield from self._robots()
        refusals = self._kernel.access.refusals
        yield Metric(
            "rosic_refusals_total",
            COUNTER,
            said("What was refused to somebody known, by code."),
            tuple(Sample({"code": code}, n) for code, n in refusals.items()),
        )
        yield from self._traffic("messenger", messenger_counts(self._kernel))
        yield from self._traffic("robot", robot_counts(self._kernel))
        yield from self.loop.metrics()
        yield from self._process()

    def _robots(self) -> Iterator[Metric]:
        rooms = self._kernel.rooms
        robots = tuple(rooms.profiles)
        stops = {robot: rooms.stops[robot] for robot in robots}
        found = {robot: rooms.linker.presence(robot) for robot in robots}
        yield self._each(
            "rosic_stops_total",
            said("Stops of a robot since its record began."),
            {r: stop.generation for r, stop in stops.items()},
            COUNTER,
        )
        yield self._each(
            "rosic_robot_stopped",
            said("1 while a robot is stopped."),
            {r: int(stop.latched) for r, stop in stops.items()},
        )
        yield self._each(
            "rosic_robot_up",
            said("1 while a robot is heard; nothing where its link cannot tell."),
            {r: int(one.online) for r, one in found.items() if one.online is not None},
        )
        yield self._each(
            "rosic_robot_age_seconds",
            said("Since a robot was last heard."),
            {r: one.age_s for r, one in found.items() if one.age_s is not None},
        )
        yield self._each(
            "rosic_robot_queue_length",
            said("Orders that wait for a robot."),
            {robot: len(rooms.linker.queues[robot]) for robot in robots},
        )

    @staticmethod
    def _each(
        name: str, about: str, values: dict[str, int] | dict[str, float], kind: str = GAUGE
    ) -> Metric:
        samples = tuple(Sample({"robot": robot}, value) for robot, value in values.items())
        return Metric(name, kind, about, samples)

    @staticmethod
    def _traffic(what: str, counts: dict[str, TrafficCount]) -> Iterator[Metric]:
        for number, unit in enumerate(("messages", "bytes")):
            yield Metric(
                f"rosic_{what}_{unit}_total",
                COUNTER,
                _PASSED[what, unit],
                tuple(
                    Sample({what: link, "direction": way}, count[2 * number + place])
                    for link, count in counts.items()
                    if unit == "messages" or count.received_bytes or count.sent_bytes
                    for place, way in enumerate(("received", "sent"))
                ),
            )

    def _process(self) -> Iterator[Metric]:
        used = resource.getrusage(resource.RUSAGE_SELF)
        version = (Sample({"version": __version__}, 1),)
        yield Metric("rosic_build_info", GAUGE, said("1; the version is a label."), version)
        spent = (Sample({}, used.ru_utime + used.ru_stime),)
        yield Metric("process_cpu_seconds_total", COUNTER, said("Processor time used."), spent)
        late = int(self._kernel.changes.late)
        yield _value("rosic_record_late", said("1 while the record does not answer in time."), late)
        ready = int(not self.not_ready)
        yield _value("rosic_ready", said("1 while /readyz says so."), ready)
        links = {one.name: is_connected(one) for one in self._kernel.messengers}
        yield Metric(
            "rosic_messenger_up",
            GAUGE,
            said("1 while a platform answers; nothing if none can tell."),
            tuple(
                Sample({"messenger": messenger}, int(link))
                for messenger, link in links.items()
                if link is not None
            ),
        )
        about = said("Tasks of the event loop that are not over.")
        yield _value("rosic_loop_tasks", about, len(asyncio.all_tasks()))
        descriptors = _open_descriptors()
        if descriptors:
            yield _value("process_open_fds", said("Open file descriptors."), descriptors)
        resident = _resident_bytes()
        if resident:
            yield _value("process_resident_memory_bytes", said("Memory in use."), resident)


def _value(name: str, about: str, value: float) -> Metric:
    return Metric(name, GAUGE, about, (Sample({}, value),))


def _open_descriptors() -> int:
    """Return how many descriptors are open; 0 where it is not told."""
    try:
        with os.scandir("/proc/self/fd") as found:
            return sum(1 for _ in found) - 1  # that of the list itself
    except OSError:
        return 0


def _resident_bytes() -> int:
    """Return how much memory is in use; 0 where it is not told."""
    try:
        with open("/proc/self/statm", encoding="ascii") as told:  # noqa: PTH123 - no file
            return int(told.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0
