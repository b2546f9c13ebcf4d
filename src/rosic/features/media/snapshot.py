"""``/picture``, ``/clip`` and ``/map``: what the robot's side shows now."""

from __future__ import annotations

import asyncio
from contextlib import aclosing
from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language.compiled import fold
from rosic.core.message import Button
from rosic.core.robot.view import Clip, CompressedFrame, OccupancyMap, RawFrame, View, ViewKind
from rosic.errors import NothingToSee, NotUnderstood
from rosic.features.media import messages as words
from rosic.features.media.render_queue import RenderJob
from rosic.gateway.commands import Reply
from rosic.gateway.observed_state import ShownView
from rosic.gateway.robot_argument import RobotArgument

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.message import Outbound
    from rosic.core.robot.profile import RobotId
    from rosic.features.media.context import MediaContext
    from rosic.gateway.commands import CommandContext

LOW = "low"
PICTURE_COST, CLIP_COST = 1.0, 4.0
WITHIN_S = 15.0
CLIP_FRAMES = 14
CLIP_EVERY_S = 0.2
CLIP_S = 5.0
CLIP_BYTES = 64_000_000
SEVERAL = 2
ANSWERED_LATER = Reply("")
_ENDS = ".,;:!?"


class SnapshotCommands:
    """The handler who looks at robots."""

    def __init__(self, media: MediaContext) -> None:
        self._media = media
        self._naming = RobotArgument(media)

    async def picture(self, asked: CommandContext) -> Reply:
        """Show a frame.

        Raises:
            Refusal: No such robot, no camera, not now.
        """
        robot, low = self._asked(asked, "picture", ViewKind.PICTURE)
        self._begin(asked, robot, PICTURE_COST, partial(self._picture, robot, low=low))
        return ANSWERED_LATER

    def picture_for(
        self,
        asked: CommandContext,
        robot: RobotId,
        deliver: Callable[[int, Outbound], Awaitable[None]],
        *,
        unasked: bool = False,
    ) -> None:
        """Have a frame handed over instead of sent, and when it was taken, wall clock.

        Raises:
            Refusal: Not now; nothing was begun.
        """

        async def take() -> RenderJob:
            view = await self._first(robot, ViewKind.PICTURE)
            past_ns = int(self._media.age_s(view.taken_ns) * 1e9)
            shot = self._shot(robot, view, words.camera(), (), low=True)
            at_ns = self._media.clock.wall_ns() - past_ns
            return replace(shot, deliver=partial(deliver, at_ns))

        self._media.render_queue.begin(asked, robot, PICTURE_COST, take, unasked=unasked)

    async def shown_to(
        self, who: PrincipalId, robot: RobotId, kind: ViewKind, *, low: bool
    ) -> ShownView:
        """Return what a robot shows now, as a picture; see `RobotViews`."""
        taken_ns = 0

        async def take() -> RenderJob:
            nonlocal taken_ns
            view = await self._first(robot, kind)
            taken_ns = self._media.clock.wall_ns() - int(self._media.age_s(view.taken_ns) * 1e9)
            return self._shot(robot, view, words.camera(), (), low=low)

        shown = self._media.profiles[robot]
        if not shown.offers(kind):
            why = words.no_camera if kind is ViewKind.PICTURE else words.no_map
            raise NothingToSee(why(shown.shown))
        drawing = await self._media.render_queue.drawn(who, robot, PICTURE_COST, take)
        return ShownView(drawing.media_type, drawing.content, taken_ns)

    async def clip(self, asked: CommandContext) -> Reply:
        """Show some seconds. Raises as `picture` does."""
        robot, low = self._asked(asked, "clip", ViewKind.PICTURE)
        self._begin(asked, robot, CLIP_COST, partial(self._clip, robot, low=low))
        return ANSWERED_LATER

    async def map(self, asked: CommandContext) -> Reply:
        """Show the map. Raises as `picture` does."""
        robot, low = self._asked(asked, "map", ViewKind.MAP)
        self._begin(asked, robot, PICTURE_COST, partial(self._map, robot, low=low))
        return ANSWERED_LATER

    def _asked(self, asked: CommandContext, verb: str, sight: ViewKind) -> tuple[RobotId, bool]:
        """Return which robot is meant, and whether it may be coarse."""
        text = asked.rest.strip().rstrip(_ENDS)
        alone = fold(text) == LOW and not self._naming.calls(asked, text)
        robot, rest = self._naming.robot(asked, verb, text, nameless=alone)
        profile = self._media.profiles[robot]
        if not profile.offers(sight):
            why = words.no_camera if sight is ViewKind.PICTURE else words.no_map
            raise NothingToSee(why(profile.shown))
        if rest and fold(rest) != LOW:
            raise NotUnderstood(words.too_much(verb), offers=(f"{verb} {robot}",))
        return robot, bool(rest)

    def _begin(
        self,
        asked: CommandContext,
        robot: RobotId,
        cost: float,
        take: Callable[[], Awaitable[RenderJob]],
    ) -> None:
        self._media.render_queue.begin(asked, robot, cost, take)

    async def _picture(self, robot: RobotId, *, low: bool) -> RenderJob:
        view = await self._first(robot, ViewKind.PICTURE)
        again = Button(said("Again"), _command("picture", robot, low=low))
        moving = Button(said("Clip"), _command("clip", robot, low=low))
        buttons = (again, moving, *_coarser("picture", robot, low=low))
        return self._shot(robot, view, words.camera(), buttons, low=low)

    async def _map(self, robot: RobotId, *, low: bool) -> RenderJob:
        view = await self._first(robot, ViewKind.MAP)
        again = Button(said("Again"), _command("map", robot, low=low))
        buttons = (again, *_coarser("map", robot, low=low))
        return self._shot(robot, view, words.plan(), buttons, low=low)

    def _shot(
        self, robot: RobotId, view: View, what: str, buttons: tuple[Button, ...], *, low: bool
    ) -> RenderJob:
        shown, age_s = self._media.profiles[robot].shown, self._media.age_s
        grid = view.content if isinstance(view.content, OccupancyMap) else None

        def caption() -> str:
            pose_ns = None if grid is None else grid.pose_ns
            text = words.caption(
                shown,
                what,
                age_s(view.taken_ns),
                foreign=view.foreign,
                low=low,
                pose_age_s=None if pose_ns is None else age_s(pose_ns),
            )
            beside = None if grid is None else grid.outside
            return text if beside is None else joined(". ", (text, words.outside(shown, beside)))

        return RenderJob(view.content, caption, robot, low, (buttons,))

    async def _first(self, robot: RobotId, sight: ViewKind) -> View:
        shown = self._media.profiles[robot].shown
        try:
            async with (
                asyncio.timeout(WITHIN_S),
                aclosing(self._media.linker.look(robot, sight)) as views,
            ):
                async for view in views:
                    return view
        except TimeoutError:
            pass
        raise NothingToSee(said("{robot} has shown nothing.", robot=shown))

    async def _clip(self, robot: RobotId, *, low: bool) -> RenderJob:
        shown = self._media.profiles[robot].shown
        views = await self._several(robot)
        if len(views) < SEVERAL:
            raise NothingToSee(said("{robot} shows pictures too seldom for a clip.", robot=shown))
        last = views[-1]
        seconds = max(0.1, (last.taken_ns - views[0].taken_ns) / 1e9)
        clip = Clip(tuple(view.content for view in views), seconds / (len(views) - 1))
        again = Button(said("Again"), _command("clip", robot, low=low))
        still = Button(said("Picture"), _command("picture", robot, low=low))
        return RenderJob(
            clip,
            lambda: words.caption(
                shown,
                words.clip(seconds),
                self._media.age_s(last.taken_ns),
                foreign=last.foreign,
                low=low,
            ),
            robot,
            low,
            ((again, still, *_coarser("clip", robot, low=low)),),
        )

    async def _several(self, robot: RobotId) -> list[View]:
        """Return frames one after another, until there are enough or it has taken long enough."""
        clock, views = self._media.clock, list[View]()
        begun_ns, size = clock.monotonic_ns(), 0
        try:
            async with (
                asyncio.timeout(WITHIN_S),
                aclosing(self._media.linker.look(robot, ViewKind.PICTURE)) as frames,
            ):
                async for view in frames:
                    views.append(view)
                    size += _size(view)
                    past_s = (clock.monotonic_ns() - begun_ns) / 1e9
                    if len(views) >= CLIP_FRAMES or size > CLIP_BYTES or past_s > CLIP_S:
                        break
                    await clock.sleep(CLIP_EVERY_S)
        except TimeoutError:
            pass
        except NothingToSee:
            if len(views) < SEVERAL:
                raise
        return views


def _command(verb: str, robot: RobotId, *, low: bool) -> str:
    return f"/{verb} {robot} {LOW}" if low else f"/{verb} {robot}"


def _coarser(verb: str, robot: RobotId, *, low: bool) -> tuple[Button, ...]:
    """Return the button for the other quality."""
    label = said("Better quality") if low else said("Lower quality")
    return (Button(label, _command(verb, robot, low=not low)),)


def _size(view: View) -> int:
    return len(view.content.data) if isinstance(view.content, (CompressedFrame, RawFrame)) else 0


# ---- pictures for live cards ----


class DashboardCamera:
    """What live cards, and whoever shows pictures elsewhere than in a chat, look through."""

    def __init__(self, media: MediaContext) -> None:
        self._media = media
        self._looking = SnapshotCommands(media)

    def offers(self, robot: RobotId) -> bool:
        """Whether anybody may look through its camera, and something can be drawn."""
        return self._media.render_queue.works and self._media.profiles[robot].offers(
            ViewKind.PICTURE
        )

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

    async def picture(
        self, who: PrincipalId, robot: RobotId, kind: ViewKind, *, low: bool
    ) -> ShownView:
        """Look, and draw, within the bounds of all pictures; see `RobotViews`."""
        return await self._looking.shown_to(who, robot, kind, low=low)
