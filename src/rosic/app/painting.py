"""Who draws, and who may have pictures: the last step of putting seeing together."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, cast

from rosic.features.benchmarks.evaluation import follow
from rosic.features.media.commands import employ_clerks, sights
from rosic.features.media.context import MediaContext, MediaQueries
from rosic.features.media.render_queue import RenderQueue
from rosic.features.media.sampler import TelemetrySampler

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.renderer import Renderer
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.view import Drawing, Scene, Subject
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.sender import ChatSender


def painter() -> Renderer | None:
    """Return who draws; None where Pillow is not installed.

    Nothing of it is loaded before the first picture is drawn.
    """
    return None if find_spec("PIL") is None else _draw


def _draw(subject: Subject, *, low: bool = False, say: Callable[[str], str] = str) -> Drawing:
    draw = cast("Renderer", import_module("rosic.rendering.draw").draw)
    return draw(subject, low=low, say=say)


def jpeg_drawer() -> Callable[[Scene], bytes] | None:
    """Return what draws the frames of simulated cameras; None where Pillow is not installed."""
    return None if painter() is None else lambda scene: _draw(scene, low=True).content


def furnish_seeing(
    rooms: Components, pipeline: Pipeline, teller: ChatSender, draws: Renderer | None, clock: Clock
) -> MediaContext:
    """Let people look at robots that they may read."""
    organiser, profiles = rooms.organiser, rooms.profiles

    def may_see(principal: PrincipalId, robot: RobotId) -> bool:
        return principal not in organiser.locked and robot in organiser.visible(principal)

    studio = RenderQueue(
        draws, teller, clock,
        may_see=may_see, issue=rooms.authoriser.buttons.issue,
        shown=lambda robot: profiles[robot].shown,
    )  # fmt: skip
    seeing = MediaContext(
        vocabulary=rooms.vocabulary,
        profiles=profiles,
        sides=MediaQueries(visible=organiser.visible, selected=rooms.container.selected),
        linker=rooms.linker,
        studio=studio,
        sampler=TelemetrySampler(rooms.linker, clock),
        clock=clock,
    )
    employ_clerks(pipeline.reception.office, seeing)
    pipeline.reception.sights = lambda robot: sights(seeing, robot)
    for profile in profiles.values():
        enlist_seen(seeing, pipeline, profile)
    return seeing


def enlist_seen(seeing: MediaContext, pipeline: Pipeline, profile: Profile) -> None:
    """Sample what a robot reports, and follow where it goes if it says so."""
    seeing.sampler.enlist(profile)
    if profile.pose is not None:
        follow(pipeline.lives, seeing.sampler)
