"""Who does which command of seeing, and which buttons a robot's menu has for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage
from rosic.core.message import Button
from rosic.core.robot.view import ViewKind
from rosic.features.media.history import HistoryCommands
from rosic.features.media.snapshot import SnapshotCommands

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.features.media.context import MediaContext
    from rosic.gateway.commands import CommandRegistry

COMMANDS: Final = (
    Command(
        name="picture",
        aliases=("bild",),
        typed=said("/picture"),
        summary=said("What its camera shows now"),
        help=HelpEntry(HelpPage.SEE, 50, HelpNeed.PICTURE),
    ),
    Command(name="clip", summary="what its camera shows, for some seconds", page=HelpPage.SEE),
    Command(
        name="map",
        aliases=("karte",),
        typed=said("/map"),
        summary=said("Where it is on its map"),
        help=HelpEntry(HelpPage.SEE, 60, HelpNeed.MAP),
    ),
    Command(
        name="chart",
        aliases=("verlauf",),
        typed=said("/chart"),
        summary=said("A value over time"),
        help=HelpEntry(HelpPage.SEE, 80, HelpNeed.TELEMETRY),
        phrase=lambda what: said("Chart of {what}", what=what),
    ),
    Command(
        name="trajectory",
        aliases=("weg",),
        typed=said("/trajectory"),
        summary=said("The way it has gone"),
        help=HelpEntry(HelpPage.SEE, 70, HelpNeed.POSE),
        phrase=lambda what: said("Trajectory of {what}", what=what),
    ),
    Command(
        name="path",
        summary="the same as trajectory",
    ),
)


def register_commands(commands: CommandRegistry, media: MediaContext) -> None:
    """Let ``picture``, ``clip``, ``map``, ``chart`` and ``trajectory`` (or ``path``) be done."""
    looking, recalling = SnapshotCommands(media), HistoryCommands(media)
    commands.register("picture", looking.picture)
    commands.register("clip", looking.clip)
    commands.register("map", looking.map)
    commands.register("chart", recalling.chart)
    commands.register("trajectory", recalling.trajectory)
    commands.register("path", recalling.trajectory)


def view_buttons(media: MediaContext, robot: RobotId) -> list[Button]:
    """Return buttons for everything that can be seen of a robot."""
    profile = media.profiles[robot]
    if not media.render_queue.works:
        return []
    buttons: list[Button] = []
    if profile.offers(ViewKind.PICTURE):
        buttons += [
            Button(said("Picture"), f"/picture {robot}"),
            Button(said("Clip"), f"/clip {robot}"),
        ]
    if profile.offers(ViewKind.MAP):
        buttons.append(Button(said("Map"), f"/map {robot}"))
    if profile.telemetry:
        buttons.append(Button(said("Chart"), f"/chart {robot}"))
    if profile.pose is not None:
        buttons.append(Button(said("Way"), f"/trajectory {robot}"))
    return buttons
