"""Looking at a robot for a live card."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.robot.view import Sight
from rosic.features.media.snapshot import SnapshotCommands

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.core.message import Outbound
    from rosic.core.robot.profile import RobotId
    from rosic.features.media.context import MediaContext
    from rosic.gateway.office import CommandContext


class DashboardCamera:
    """What live cards look through."""

    def __init__(self, seeing: MediaContext) -> None:
        self._seeing = seeing
        self._looking = SnapshotCommands(seeing)

    def offers(self, robot: RobotId) -> bool:
        """Whether anybody may look through its camera, and something can be drawn."""
        return self._seeing.studio.works and self._seeing.profiles[robot].offers(Sight.PICTURE)

    def look(
        self,
        asked: CommandContext,
        robot: RobotId,
        deliver: Callable[[int, Outbound], Awaitable[None]],
        *,
        unasked: bool = False,
    ) -> None:
        """Make a picture within the bounds of all pictures, and hand it over.

        Raises:
            Refusal: Not now; nothing was begun.
        """
        self._looking.picture_for(asked, robot, deliver, unasked=unasked)
