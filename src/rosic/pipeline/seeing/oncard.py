"""Looking at a robot for a live card."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.view import Sight
from rosic.pipeline.seeing.looking import Looking

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.core.message import Outbound
    from rosic.core.robot import RobotId
    from rosic.pipeline.office import Asked
    from rosic.pipeline.seeing.parts import Seeing


class CardCamera:
    """What live cards look through."""

    def __init__(self, seeing: Seeing) -> None:
        self._seeing = seeing
        self._looking = Looking(seeing)

    def offers(self, robot: RobotId) -> bool:
        """Whether anybody may look through its camera, and something can be drawn."""
        return self._seeing.studio.works and self._seeing.profiles[robot].offers(Sight.PICTURE)

    def look(
        self, asked: Asked, robot: RobotId, deliver: Callable[[int, Outbound], Awaitable[None]],
        *, unasked: bool = False,
    ) -> None:  # fmt: skip
        """Make a picture within the bounds of all pictures, and hand it over.

        Raises:
            Refusal: Not now; nothing was begun.
        """
        self._looking.picture_for(asked, robot, deliver, unasked=unasked)
