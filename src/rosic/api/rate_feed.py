"""Rates of messengers and robots, measured once a second while anybody wants to know them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.api.event_schemas import MessengerRate, RatesEvent, RobotRate
from rosic.contracts.traffic import CountsTraffic, traffic_of
from rosic.core.time_units import SECOND_NS
from rosic.core.traffic import TrafficMeter

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.robot.profile import RobotId
    from rosic.core.traffic import TrafficCount
    from rosic.gateway.feature import Kernel

EVERY_NS: Final = SECOND_NS


def messenger_counts(kernel: Kernel) -> dict[str, TrafficCount]:
    """Return what has passed each messenger that counts, by its name."""
    return dict(_counted((each.name, each) for each in kernel.messengers))


def robot_counts(kernel: Kernel) -> dict[RobotId, TrafficCount]:
    """Return what has passed each robot's link that counts."""
    return dict(_counted(kernel.robots.items()))


def _counted(links: Iterable[tuple[str, object]]) -> Iterator[tuple[str, TrafficCount]]:
    for name, link in links:
        count = traffic_of(link)
        if count is not None:
            yield name, count


class _Counting:
    """The links that count; of each is found out once whether it does."""

    def __init__(self) -> None:
        self._links: Mapping[str, object] = {}
        self._counting: dict[str, CountsTraffic] = {}

    def counts(self, links: Mapping[str, object]) -> dict[str, TrafficCount]:
        """Return what has passed those of these links that count."""
        if links != self._links:
            self._links = links
            self._counting = {n: x for n, x in links.items() if isinstance(x, CountsTraffic)}
        return {name: link.traffic for name, link in self._counting.items()}


class RateFeed:
    """Says once a second what passed in the last one."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._speaking, self._linked = _Counting(), _Counting()
        self._messengers, self._robots = TrafficMeter(), TrafficMeter()
        self._taken_ns: int | None = None

    def look(self) -> RatesEvent | None:
        """Return the rates of everything; None: a second is not over yet, or nothing is known."""
        now_ns = self._kernel.machine_clock.monotonic_ns()
        if self._taken_ns is not None and now_ns - self._taken_ns < EVERY_NS:
            return None
        self._taken_ns = now_ns
        spoken = {each.name: each for each in self._kernel.messengers}
        messengers = self._messengers.take(self._speaking.counts(spoken), now_ns)
        robots = self._robots.take(self._linked.counts(dict(self._kernel.robots)), now_ns)
        if not messengers and not robots:
            return None
        return RatesEvent(
            tuple(
                MessengerRate(
                    name,
                    round(rate.received_per_s, 3),
                    round(rate.sent_per_s, 3),
                    round(rate.received_bytes_s, 3),
                    round(rate.sent_bytes_s, 3),
                )
                for name, rate in messengers.items()
            ),
            tuple(
                RobotRate(robot, round(rate.sent_per_s, 3), round(rate.received_per_s, 3))
                for robot, rate in robots.items()
            ),
        )


def of_visible(event: RatesEvent, visible: frozenset[RobotId]) -> RatesEvent:
    """Return the rates without those of robots that somebody may not see."""
    return RatesEvent(event.messengers, tuple(r for r in event.robots if r.robot in visible))
