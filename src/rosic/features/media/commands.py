"""Who does which command of seeing, and which buttons a robot's menu has for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import figure, joined, said
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage
from rosic.core.language.common_names import shown_name, typed_names
from rosic.core.language.compiled import fold
from rosic.core.message import Button
from rosic.core.robot.view import PathView, TimeSeries, ViewKind
from rosic.errors import NothingToSee, NotUnderstood
from rosic.features.media import messages as words
from rosic.features.media.render_queue import RenderJob
from rosic.features.media.snapshot import ANSWERED_LATER, LOW, PICTURE_COST, SnapshotCommands
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.features.media.context import MediaContext
    from rosic.features.media.telemetry_buffer import RobotTrack
    from rosic.gateway.commands import CommandContext, CommandRegistry


# ---- history ----

# ``/chart`` and ``/trajectory``: what the gateway remembers of the last minutes.

MOST_BUTTONS = 12
_ENDS = ".,;:!?"


class HistoryCommands:
    """The handler who draws what was kept."""

    def __init__(self, media: MediaContext) -> None:
        self._media = media
        self._naming = RobotArgument(media)

    # ---- charts ----

    async def chart(self, asked: CommandContext) -> Reply:
        """Draw one value, or ask which.

        Raises:
            Refusal: No such robot or value, or nothing was heard.
        """
        robot, said_after, low = self._asked(asked, "chart")
        profile = self._media.profiles[robot]
        known = tuple(profile.telemetry)
        if not known:
            raise NothingToSee(words.no_values(profile.shown))
        numbers = self._media.sampler.samples.names(robot)
        if not said_after and len(numbers) != 1:
            offered = [
                Button(shown_name(n), f"/chart {robot} {n}")
                for n in (numbers or known)[:MOST_BUTTONS]
            ]
            return Reply(words.which_value(profile.shown), rows(offered))
        name = self._value(robot, said_after, known) if said_after else numbers[0]
        self._media.render_queue.begin(
            asked, robot, PICTURE_COST, self._curve(robot, name, low=low), kept=name
        )
        return ANSWERED_LATER

    def _value(self, robot: RobotId, text: str, known: tuple[str, ...]) -> str:
        wanted = fold(text).replace(" ", "_")
        wanted = next((name for name in known if wanted in typed_names(name)), wanted)
        if wanted not in known:
            shown = self._media.profiles[robot].shown
            offers = tuple(f"chart {robot} {name}" for name in known[:3])
            raise NotUnderstood(words.no_such_value(shown, text, known), offers=offers)
        return wanted

    def _curve(self, robot: RobotId, name: str, *, low: bool) -> _Take:
        """Look the samples up now; nobody has to be waited for.

        Raises:
            NothingToSee: There are none.
        """
        media, profile = self._media, self._media.profiles[robot]
        now_ns = media.clock.monotonic_ns()
        points = media.sampler.samples.points(robot, name, now_ns / 1e9)
        if not points:
            raise NothingToSee(words.no_samples(profile.shown, name))
        described = profile.telemetry[name]
        value = figure(f"{points[-1][1]:.4g} {described.unit}".strip())
        title = joined(": ", (profile.shown, shown_name(name)))
        what = words.chart(shown_name(name), value, -points[0][0])
        newest_ns = now_ns + int(points[-1][0] * 1e9)
        again = Button(said("Again"), f"/chart {robot} {name}")
        other = Button(said("Another value"), f"/chart {robot}")
        several = len(profile.telemetry) > 1
        return _Take(
            RenderJob(
                TimeSeries(title, described.unit, points, described.alert_below),
                lambda: words.caption(
                    profile.shown, what, media.age_s(newest_ns), foreign=False, low=low
                ),
                f"{robot}-{name}",
                low,
                ((again, other) if several else (again,),),
            )
        )

    # ---- ways ----

    async def trajectory(self, asked: CommandContext) -> Reply:
        """Draw where a robot went with its last order.

        Raises:
            Refusal: No such robot, or nothing is known.
        """
        robot, rest, low = self._asked(asked, "trajectory")
        profile = self._media.profiles[robot]
        if rest:
            raise NotUnderstood(words.too_much("trajectory"), offers=(f"trajectory {robot}",))
        if profile.pose is None:
            raise NothingToSee(words.no_pose(profile.shown))
        track = self._media.sampler.tracks.get(robot)
        if track is None or not track.points:
            raise NothingToSee(words.no_way(profile.shown))
        if track.length_m < words.NOTHING_M:
            over = track.ended_ns is not None
            raise NothingToSee(words.stayed(profile.shown, track.words, over=over))
        self._media.render_queue.begin(
            asked, robot, PICTURE_COST, self._way(robot, track, low=low), kept="way"
        )
        return ANSWERED_LATER

    def _way(self, robot: RobotId, track: RobotTrack, *, low: bool) -> _Take:
        media, profile = self._media, self._media.profiles[robot]
        until_ns = track.ended_ns or media.clock.monotonic_ns()
        seconds = (until_ns - track.begun_ns) / 1e9
        what = words.way(track.words, track.length_m, seconds, over=track.ended_ns is not None)
        again = Button(said("Again"), f"/trajectory {robot}")
        return _Take(
            RenderJob(
                PathView(
                    joined(": ", (profile.shown, track.words)), tuple(track.points), track.rises
                ),
                lambda: words.caption(
                    profile.shown, what, media.age_s(until_ns), foreign=False, low=low
                ),
                f"{robot}-way",
                low,
                ((again,),),
            )
        )

    def _asked(self, asked: CommandContext, verb: str) -> tuple[RobotId, str, bool]:
        """Return the robot, what was said after it, and whether it may be coarse."""
        text = asked.rest.strip().rstrip(_ENDS)
        raw = text.split()
        low = bool(raw) and fold(raw[-1]) == LOW and not self._naming.calls(asked, text)
        if low:
            text = " ".join(raw[:-1])
        chosen = self._media.sides.selected(asked.caller.principal, asked.inbound.chat)
        profile = self._media.profiles.get(chosen)
        nameless = profile is not None and fold(text).replace(" ", "_") in profile.telemetry
        robot, rest = self._naming.robot(asked, verb, text, nameless=nameless)
        return robot, rest, low


class _Take:
    """A shot that is there already."""

    def __init__(self, shot: RenderJob) -> None:
        self._shot = shot

    async def __call__(self) -> RenderJob:
        """Return it."""
        return self._shot


# ---- commands ----

COMMANDS: Final = (
    Command(
        name="picture",
        observes=True,
        aliases=("bild",),
        typed=said("/picture"),
        summary=said("What its camera shows now"),
        help=HelpEntry(HelpPage.SEE, 50, HelpNeed.PICTURE),
    ),
    Command(
        name="clip",
        summary="what its camera shows, for some seconds",
        page=HelpPage.SEE,
        observes=True,
    ),
    Command(
        name="map",
        observes=True,
        aliases=("karte",),
        typed=said("/map"),
        summary=said("Where it is on its map"),
        help=HelpEntry(HelpPage.SEE, 60, HelpNeed.MAP),
    ),
    Command(
        name="chart",
        observes=True,
        aliases=("verlauf",),
        typed=said("/chart"),
        summary=said("A value over time"),
        help=HelpEntry(HelpPage.SEE, 80, HelpNeed.TELEMETRY),
        phrase=lambda what: said("Chart of {what}", what=what),
    ),
    Command(
        name="trajectory",
        observes=True,
        aliases=("weg",),
        typed=said("/trajectory"),
        summary=said("The way it has gone"),
        help=HelpEntry(HelpPage.SEE, 70, HelpNeed.POSE),
        phrase=lambda what: said("Trajectory of {what}", what=what),
    ),
    Command(
        name="path",
        observes=True,
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
