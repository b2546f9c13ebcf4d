"""Who does which errand of seeing, and which buttons a robot's menu has for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.message import Button
from rosic.core.robot.view import Sight
from rosic.features.media.history import HistoryCommands
from rosic.features.media.snapshot import SnapshotCommands

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.features.media.context import MediaContext
    from rosic.gateway.office import CommandRegistry


def employ_clerks(office: CommandRegistry, seeing: MediaContext) -> None:
    """Let ``picture``, ``clip``, ``map``, ``chart`` and ``trajectory`` (or ``path``) be done."""
    looking, recalling = SnapshotCommands(seeing), HistoryCommands(seeing)
    office.employ("picture", looking.picture)
    office.employ("clip", looking.clip)
    office.employ("map", looking.map)
    office.employ("chart", recalling.chart)
    office.employ("trajectory", recalling.trajectory)
    office.employ("path", recalling.trajectory)


def sights(seeing: MediaContext, robot: RobotId) -> list[Button]:
    """Return buttons for everything that can be seen of a robot."""
    profile = seeing.profiles[robot]
    if not seeing.studio.works:
        return []
    buttons: list[Button] = []
    if profile.offers(Sight.PICTURE):
        buttons += [
            Button(said("Picture"), f"/picture {robot}"),
            Button(said("Clip"), f"/clip {robot}"),
        ]
    if profile.offers(Sight.MAP):
        buttons.append(Button(said("Map"), f"/map {robot}"))
    if profile.telemetry:
        buttons.append(Button(said("Chart"), f"/chart {robot}"))
    if profile.pose is not None:
        buttons.append(Button(said("Way"), f"/trajectory {robot}"))
    return buttons
