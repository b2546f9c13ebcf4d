"""Who does which errand of seeing, and which buttons a robot's menu has for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.message import Button
from rosic.core.saying import said
from rosic.core.view import Sight
from rosic.pipeline.seeing.looking import Looking
from rosic.pipeline.seeing.recalling import Recalling

if TYPE_CHECKING:
    from rosic.core.robot import RobotId
    from rosic.pipeline.office import Office
    from rosic.pipeline.seeing.parts import Seeing


def employ_clerks(office: Office, seeing: Seeing) -> None:
    """Let ``picture``, ``clip``, ``map``, ``chart`` and ``trajectory`` (or ``path``) be done."""
    looking, recalling = Looking(seeing), Recalling(seeing)
    office.employ("picture", looking.picture)
    office.employ("clip", looking.clip)
    office.employ("map", looking.map)
    office.employ("chart", recalling.chart)
    office.employ("trajectory", recalling.trajectory)
    office.employ("path", recalling.trajectory)


def sights(seeing: Seeing, robot: RobotId) -> list[Button]:
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
