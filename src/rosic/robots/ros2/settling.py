"""After a motion was broken off and rest not seen: nothing moves before the robot has rested (I6).

A robot that was frozen, or out of reach, may go on with what it was told before as soon as it is
back. It is brought to rest then, before anything else is asked of it. Where that fails it is told
to stop no more, but nothing new moves it for as long as it is measured to move.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.errors import RobotOffline

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import Profile
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.stopping import RestResult
    from rosic.robots.ros2.telemetry import Measurements

EVERY_S: Final = 0.1
TRIES: Final = 3
"""Whoever drives a robot that is back by its own controls is not braked any more after so many."""


class RestInterlock:
    """Keeps one robot from moving after a motion was broken off, until it has rested.

    Args:
        profile, measured, clock: Of the robot.
        online: What `Presence.online` says.
        to_rest: Brings it to rest, or gives up.
    """

    def __init__(
        self,
        profile: Profile,
        measured: Measurements,
        clock: Clock,
        online: Callable[[], bool | None],
        to_rest: Callable[[], Awaitable[RestResult]],
    ) -> None:
        self._profile = profile
        self._measured = measured
        self._clock = clock
        self._online = online
        self._to_rest = to_rest
        self._task: asyncio.Task[None] | None = None
        self._gave_up = False

    @property
    def unheard(self) -> bool:
        """Whether it is not there, or has not been heard for as long as rest may go unmeasured."""
        age_s = self._measured.age_s()
        return self._online() is False or (age_s is not None and age_s > self._measured.within_s)

    def begin(self) -> None:
        """Bring it to rest as soon as it is heard; once is enough, until that was given up."""
        if self._task is not None and self._gave_up:
            self._task.cancel()
            self._task = None
        if self._task is None:
            self._gave_up = False
            self._task = asyncio.create_task(self._settle())

    def close(self) -> None:
        """Leave it to itself."""
        if self._task is not None:
            self._task.cancel()

    async def _settle(self) -> None:
        try:
            for _ in range(TRIES):
                while self.unheard:
                    await self._clock.sleep(EVERY_S)
                if (await self._to_rest()).confirmed or not self._measured.measures_rest:
                    return
            self._gave_up = True
            while self._measured.at_rest(self._measured.stale_ns()) is not True:
                await self._clock.sleep(EVERY_S)
        finally:
            if self._task is asyncio.current_task():
                self._task, self._gave_up = None, False

    async def check(self, call: BindingCall) -> None:
        """See that the robot is there, that its rest can be measured, and that it has rested.

        Raises:
            OrderVoid, RobotOffline: Not so; the robot has not moved because of the order.
        """
        shown = self._profile.shown
        try:
            await call.there(self._measured.fresh, self._profile.id)
        except RobotOffline:
            if self._online() is not True:
                raise
            raise RobotOffline(
                said(
                    "{shown} is there, but whether it rests cannot be measured now. "
                    "Nothing was sent. Whoever looks after {shown} can help.",
                    shown=shown,
                )
            ) from None
        if self._gave_up:
            if call.order.skill.to_safety:
                return  # it goes on by itself: a landing makes that no worse
            raise RobotOffline(
                said(
                    "{shown} still moves, though it was told to stop since its last motion was "
                    "broken off. Nothing was sent. Use its own stop button.",
                    shown=shown,
                )
            )
        if self._task is not None:
            await asyncio.wait((self._task,), timeout=self._profile.rest_timeout_s)
        if self._task is not None:
            raise RobotOffline(
                said(
                    "{shown} was not seen at rest since its last motion was broken off. "
                    "Nothing was sent; please look.",
                    shown=shown,
                )
            )
