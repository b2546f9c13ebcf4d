"""Who draws, and who may have pictures: the last step of putting seeing together."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, cast

from rosic.pipeline.benchmarks.judging import follow
from rosic.pipeline.seeing.clerks import employ_clerks, sights
from rosic.pipeline.seeing.parts import Onlookers, Seeing
from rosic.pipeline.seeing.sampler import Sampler
from rosic.pipeline.seeing.studio import Studio

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.painter import Painter
    from rosic.core.identity import PrincipalId
    from rosic.core.robot import Profile, RobotId
    from rosic.core.view import Drawing, Scene, Subject
    from rosic.pipeline import Pipeline
    from rosic.pipeline.rooms import Rooms
    from rosic.pipeline.telling import Teller


def painter() -> Painter | None:
    """Return who draws; None where Pillow is not installed.

    Nothing of it is loaded before the first picture is drawn.
    """
    return None if find_spec("PIL") is None else _draw


def _draw(subject: Subject, *, low: bool = False, say: Callable[[str], str] = str) -> Drawing:
    draw = cast("Painter", import_module("rosic.pictures.draw").draw)
    return draw(subject, low=low, say=say)


def jpeg_drawer() -> Callable[[Scene], bytes] | None:
    """Return what draws the frames of simulated cameras; None where Pillow is not installed."""
    return None if painter() is None else lambda scene: _draw(scene, low=True).content


def furnish_seeing(
    rooms: Rooms, pipeline: Pipeline, teller: Teller, draws: Painter | None, clock: Clock
) -> Seeing:
    """Let people look at robots that they may read."""
    organiser, profiles = rooms.organiser, rooms.profiles

    def may_see(principal: PrincipalId, robot: RobotId) -> bool:
        return principal not in organiser.locked and robot in organiser.visible(principal)

    studio = Studio(
        draws, teller, clock,
        may_see=may_see, issue=rooms.authoriser.buttons.issue,
        shown=lambda robot: profiles[robot].shown,
    )  # fmt: skip
    seeing = Seeing(
        vocabulary=rooms.vocabulary,
        profiles=profiles,
        sides=Onlookers(visible=organiser.visible, selected=rooms.container.selected),
        linker=rooms.linker,
        studio=studio,
        sampler=Sampler(rooms.linker, clock),
        clock=clock,
    )
    employ_clerks(pipeline.reception.office, seeing)
    pipeline.reception.sights = lambda robot: sights(seeing, robot)
    for profile in profiles.values():
        enlist_seen(seeing, pipeline, profile)
    return seeing


def enlist_seen(seeing: Seeing, pipeline: Pipeline, profile: Profile) -> None:
    """Sample what a robot reports, and follow where it goes if it says so."""
    seeing.sampler.enlist(profile)
    if profile.pose is not None:
        follow(pipeline.lives, seeing.sampler)
