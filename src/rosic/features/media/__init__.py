"""What robots show: pictures, clips, maps, charts and the ways they have gone."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.features.media.commands import register_commands, view_buttons
from rosic.features.media.context import MediaContext, MediaQueries
from rosic.features.media.render_queue import RenderQueue
from rosic.features.media.snapshot import DashboardCamera
from rosic.features.media.telemetry_buffer import TelemetrySampler
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.feature import Kernel
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["MediaFeature", "setup"]

PROVIDES: Final = ("camera", "telemetry", "views")


class MediaFeature(Feature):
    """Samples what robots report, and draws what people ask for.

    Attributes:
        sampler: What was reported lately.
        render_queue: What is being drawn.
    """

    def __init__(self, media: MediaContext, executor: OrderExecutor) -> None:
        self.sampler, self.render_queue = media.sampler, media.render_queue
        self._executor = executor
        for profile in media.profiles.values():
            self._add(profile)

    @property
    def quiet(self) -> bool:
        """Whether nothing is being drawn."""
        return self.render_queue.quiet

    async def run(self) -> None:
        """Sample until cancelled."""
        await self.sampler.run()

    async def leave(self) -> None:
        """Draw nothing more, and sample nothing more."""
        await self.render_queue.close()
        self.sampler.close()

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Let one more robot be looked at."""
        self._add(newcomer.profile)

    def _add(self, profile: Profile) -> None:
        """Sample what a robot reports, and follow where it goes if it says so."""
        self.sampler.add_robot(profile)
        if profile.pose is not None:
            self._executor.watching.watch_orders(self.sampler)


def setup(kernel: Kernel) -> MediaFeature:
    """Let people look at robots that they may read."""
    rooms, pipeline = kernel.rooms, kernel.pipeline
    organiser, profiles = rooms.organiser, rooms.profiles

    def may_see(principal: PrincipalId, robot: RobotId) -> bool:
        return principal not in organiser.locked and robot in organiser.visible(principal)

    render_queue = RenderQueue(
        kernel.renderer,
        kernel.orders.chat_sender,
        kernel.machine_clock,
        may_see=may_see,
        issue=rooms.authoriser.buttons.issue,
        shown=lambda robot: profiles[robot].shown,
    )
    media = MediaContext(
        vocabularies=rooms.vocabularies,
        profiles=profiles,
        sides=MediaQueries(visible=organiser.visible, selected=rooms.container.selected),
        linker=rooms.linker,
        render_queue=render_queue,
        sampler=TelemetrySampler(rooms.linker, kernel.machine_clock),
        clock=kernel.machine_clock,
    )
    register_commands(kernel.commands, media)
    pipeline.hooks.view_buttons.bind(partial(view_buttons, media))
    camera = DashboardCamera(media)
    kernel.shared.camera.provide(camera)
    kernel.shared.views.provide(camera)
    kernel.shared.telemetry.provide(media.sampler)
    return MediaFeature(media, pipeline.executor)
