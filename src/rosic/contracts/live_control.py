"""The controls of one live order, between whoever steers and the adapter that carries it out.

A sample is taken in where it comes, in one step of the event loop: checked, clamped, put in the
place of the one before. Nothing is queued and nothing grows, so the newest wins. Whoever carries
the order out is woken by it, and looks for itself before it sends.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.sample_gate import (
    CONTROLS_SILENT,
    LIVE_TIME_OVER,
    LiveEnd,
    SampleGate,
    SampleVerdict,
)
from rosic.core.time_units import MINUTE_S, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.robot.skill import Argument
    from rosic.core.sample_gate import LiveSample, SampleResult

SOONER_S: Final = 0.0005
"""A wait that is to end so much sooner than the one under way takes its place."""


class LiveControls:
    """What steers one live order.

    Attributes:
        gate: Which samples count.
        clock: By which they are late.
    """

    def __init__(self, gate: SampleGate, clock: Clock) -> None:
        """Make them; nothing is steered before the robot's turn has come.

        Args:
            gate: Which samples count.
            clock: The machine's.
        """
        self.gate = gate
        self.clock = clock
        self._news = False
        self._waiting: asyncio.Future[None] | None = None
        self._timer: asyncio.Task[None] | None = None
        self._timer_ns = 0

    # ---- whoever steers ----

    def put(self, sample: LiveSample) -> SampleResult:
        """Take a sample in, or drop it. It never waits."""
        result = self.gate.take(sample, self.clock.monotonic_ns())
        if result.verdict is SampleVerdict.TAKEN:
            self._wake()
        return result

    def release(self) -> None:
        """Let go: the robot comes to rest, and the order is done."""
        self.gate.release()
        self._wake()

    def close(self) -> None:
        """Steer nothing any more: something else has ended the order, or is about to."""
        self.gate.close()
        self._wake()

    # ---- whoever carries it out ----

    @property
    def values(self) -> Mapping[str, Argument]:
        """Every argument as the newest sample has it, SI."""
        return self.gate.values

    async def begin(self, watchdog_s: float) -> LiveEnd | None:
        """Wait for the first sample; nothing may be sent before it.

        Args:
            watchdog_s: The robot's own time-out.

        Returns:
            Why nothing is steered: it did not come, or whoever steers has let go. None: it came.
        """
        gate, clock = self.gate, self.clock
        gate.begin(clock.monotonic_ns(), watchdog_s=watchdog_s)
        while gate.look(clock.monotonic_ns()) is None and not gate.taken_ns:
            await self.changed((gate.until_ns - clock.monotonic_ns()) / SECOND_NS)
        return gate.end

    def look(self) -> LiveEnd | None:
        """Return why the newest values must not be sent; None: they may, now."""
        return self.gate.look(self.clock.monotonic_ns())

    def left_s(self) -> float:
        """Return the seconds until it ends if nothing comes."""
        return (self.gate.until_ns - self.clock.monotonic_ns()) / SECOND_NS

    async def changed(self, seconds: float) -> None:
        """Wait for a sample, or an end; at most so long. One at a time waits here.

        A wait that is over because of a sample leaves its timer for the next: at hundreds of
        samples a second, most waits need none of their own.
        """
        if self._news or seconds <= 0:
            self._news = False
            await asyncio.sleep(0)
            return
        self._set_timer(seconds)
        self._waiting = asyncio.get_running_loop().create_future()
        try:
            await self._waiting
        finally:
            self._waiting, self._news = None, False

    def leave(self) -> None:
        """Nobody carries it out any more: nothing is steered, and nobody waits."""
        self.gate.close()
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()

    def _set_timer(self, seconds: float) -> None:
        until_ns = self.clock.monotonic_ns() + int(seconds * SECOND_NS)
        if self._timer is not None:
            if until_ns > self._timer_ns - SOONER_S * SECOND_NS:
                return
            self._timer.cancel()
        self._timer_ns = until_ns
        self._timer = asyncio.create_task(self._ring(seconds))

    async def _ring(self, seconds: float) -> None:
        await self.clock.sleep(seconds)
        self._timer = None
        self._wake()

    def _wake(self) -> None:
        self._news = True
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_result(None)


def live_outcome(end: LiveEnd, seconds: float, most_s: float, driven: str = "") -> Outcome:
    """Return how a live order ended, once its robot is at rest.

    Args:
        end: As its controls know it.
        seconds: For how long it was driven.
        most_s: For how long it might have been.
        driven: What was measured of it instead; empty: nothing but how long.
    """
    how = driven or said("drove live for {seconds:.1f} s", seconds=seconds)
    if end is LiveEnd.RELEASED:
        return Outcome(OrderEnding.DONE, how)
    if end is LiveEnd.SILENT:
        return Outcome(OrderEnding.CANCELLED, joined("; ", (SILENT, how)), code=CONTROLS_SILENT)
    if end is LiveEnd.TIME_OVER:
        return Outcome(
            OrderEnding.CANCELLED, joined("; ", (_over(most_s), how)), code=LIVE_TIME_OVER
        )
    return Outcome(OrderEnding.CANCELLED, how)


SILENT: Final = said("the controls fell silent")
NEVER_STEERED: Final = said("the controls never said anything, so it did not move")


def never_steered(end: LiveEnd) -> Outcome:
    """Return the end of a live order before its first sample: its robot was sent nothing."""
    silent = end in (LiveEnd.SILENT, LiveEnd.TIME_OVER)
    note = NEVER_STEERED if silent else said("released before it moved")
    return Outcome(OrderEnding.CANCELLED, note, code=CONTROLS_SILENT if silent else "")


def _over(most_s: float) -> str:
    if most_s >= MINUTE_S:
        return said(
            "nobody drives live for longer than {minutes:g} minutes at once",
            minutes=most_s / MINUTE_S,
        )
    return said("it may be driven for no longer than {seconds:g} s at once", seconds=most_s)
