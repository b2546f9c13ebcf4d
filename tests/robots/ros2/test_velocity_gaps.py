"""What is not sent for as long as a robot's watchdog waits is sent no more (I6)."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

from rosic.core.deadman import BreakCause, MotionBreak
from rosic.robots.ros2 import velocity_stream
from rosic.robots.ros2.bindings.binding_call import over
from rosic.robots.ros2.velocity_stream import StreamPace, VelocityStream

WATCHDOG_S = 0.5


class SleepyClock:
    """A clock whose every sleep lasts as long as a machine lets it."""

    def __init__(self, sleeps_s: list[float]) -> None:
        self.now_s = 0.0
        self._sleeps_s = sleeps_s

    def monotonic_ns(self) -> int:
        return round(self.now_s * 1e9)

    async def sleep(self, seconds: float) -> None:
        self.now_s += self._sleeps_s.pop(0) if self._sleeps_s else seconds


class Side:
    """A robot's side that is heard all the time; beside it somebody joins, named only later."""

    within_s, restarts = 2.0, 0

    def __init__(self, clock: SleepyClock, named_at_s: float) -> None:
        self.sent_s: list[float] = []
        self.listeners = 1
        self._clock = clock
        self._named_at_s = named_at_s

    def takers(self) -> dict[bytes, str]:
        joined = {} if self._clock.now_s < 0.06 else {b"2": self._name()}
        return {b"1": "/driver"} | joined

    def _name(self) -> str:
        return "" if self._clock.now_s < self._named_at_s else "/rviz"

    def made(self, velocities: object) -> object:
        return velocities

    def send(self, _message: object) -> None:
        self.sent_s.append(self._clock.now_s)

    def age_s(self) -> float:
        return 0.0

    judged_age_s = age_s

    def at_rest(self, _since_ns: int) -> bool:
        return False


async def driven(monkeypatch: pytest.MonkeyPatch, sleeps_s: list[float], named_at_s: float) -> Any:  # noqa: ANN401
    clock = SleepyClock(sleeps_s)
    side = Side(clock, named_at_s)
    way = SimpleNamespace(look=lambda: None)
    monkeypatch.setattr(velocity_stream, "OdometryDistance", lambda *_: way)
    monkeypatch.setattr(velocity_stream, "told_m_s", lambda _: 0.2)
    call: Any = SimpleNamespace(
        side=SimpleNamespace(measured=side, watchdog_s=WATCHDOG_S, clock=clock),
        leave=lambda: None,
        allowed=lambda: True,
        received=lambda: None,
        running=lambda _share: None,
    )
    publisher: Any = side
    stream = VelocityStream(call, publisher, {}, StreamPace(0.05, 1.0))
    return side.sent_s, await stream.run()


async def test_whoever_is_named_too_late_finds_the_robot_left_at_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each look comes in time, and still nothing was sent for longer than the watchdog waits."""
    sent_s, broken = await driven(monkeypatch, [0.05, 0.2, 0.45], named_at_s=0.5)
    assert sent_s == [0.0, 0.05]
    assert broken is not None
    assert broken.seconds == pytest.approx(0.65)


async def test_whoever_is_named_in_time_is_driven_on(monkeypatch: pytest.MonkeyPatch) -> None:
    sent_s, broken = await driven(monkeypatch, [0.05, 0.2, 0.1], named_at_s=0.3)
    assert broken is None
    assert max(b - a for a, b in pairwise(sent_s)) < WATCHDOG_S


def test_why_it_was_broken_off_is_said_whether_or_not_anything_was_done_before() -> None:
    told = {over(MotionBreak(cause, 1.2)) for cause in BreakCause}
    assert len(told) == len(BreakCause)
    assert all(words.startswith("broken off because ") for words in told), told
    assert over(MotionBreak(BreakCause.SILENT, 1.2)) == (
        "broken off because it was not heard for 1.2 s"
    )
