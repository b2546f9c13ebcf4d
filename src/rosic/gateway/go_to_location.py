"""A place that somebody sends means "go there": asked first, and only of a robot that can.

It moves nothing by itself. The answer to the question is an order like any other.
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, NamedTuple

from rosic.core import messages
from rosic.core.i18n import said
from rosic.core.message import Button
from rosic.core.robot.geography import GeographicFrame, OutsidePlane, local_m
from rosic.core.units import bound_in_words, measured
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import CONFIRMED, DO_IT, LEAVE, LEAVE_IT

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller
    from rosic.core.message import Inbound
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Skill
    from rosic.gateway.components import Components
    from rosic.gateway.reply_context import ReplyTargets

NOBODY = said("No robot that you may send anywhere knows where on Earth it is.")
TOO_FAR = said("That is more than 10 km away. Nothing was done.")
WHICH = said("Several robots can go there. Choose one, and send the place again.")


class LocationSkill(NamedTuple):
    """How a robot is sent to a place."""

    frame: GeographicFrame
    skill: Skill
    x: str
    y: str


class GoToLocation:
    """Makes questions of places."""

    def __init__(self, rooms: Components, reply_targets: ReplyTargets) -> None:
        self._rooms = rooms
        self._reply_targets = reply_targets

    def ask(self, messenger: Messenger, inbound: Inbound, caller: Caller) -> Reply:
        """Return the question whether a robot is meant to go there.

        Meant is the robot whose message it answers; else, unless it answers one of ours, the
        chosen one; else the only one.

        Raises:
            NotUnderstood: No robot can, or several, and none is chosen.
            OutOfBounds: The robot does not go so far.
        """
        robot, way = self._who(messenger, inbound, caller)
        assert inbound.place is not None  # noqa: S101 - asked for a place alone
        shown = self._rooms.profiles[robot].shown
        try:
            exact = local_m(way.frame, inbound.place.latitude, inbound.place.longitude)
        except OutsidePlane:
            raise OutOfBounds(TOO_FAR) from None
        x, y = (round(value, 2) + 0.0 for value in exact)  # no minus before a nought
        for name, value in ((way.x, x), (way.y, y)):
            bounds = way.skill.parameters[name]
            low, high = bounds.min or 0.0, bounds.max or 0.0
            if not low <= value <= high:
                raise OutOfBounds(_outside(shown, (x, y), name, (low, high)))
        command = f"{robot} {messages.spoken(way.skill)} {way.x}={x:.2f} {way.y}={y:.2f}"
        row = (Button(DO_IT, f"{CONFIRMED}{command}"), Button(LEAVE_IT, LEAVE))
        return asks_first(self._question(robot, shown, x, y), (row,))

    def _question(self, robot: RobotId, shown: str, x: float, y: float) -> str:
        here = self._rooms.linker.presence(robot).values
        at_x, at_y = here.get("x"), here.get("y")
        to_x, to_y = (measured(f"{value:.1f} m", value, "m") for value in (x, y))
        if not isinstance(at_x, int | float) or not isinstance(at_y, int | float):
            return said("{robot}: go to {x}, {y}?", robot=shown, x=to_x, y=to_y)
        far = hypot(x - at_x, y - at_y)
        return said(
            "{robot}: go to {x}, {y} ({far} from where it is)?",
            robot=shown,
            x=to_x,
            y=to_y,
            far=measured(f"{far:.0f} m", far, "m"),
        )

    def _who(
        self, messenger: Messenger, inbound: Inbound, caller: Caller
    ) -> tuple[RobotId, LocationSkill]:
        rooms = self._rooms
        visible = rooms.organiser.visible(caller.principal)
        ways = {robot: way_of(rooms.profiles[robot]) for robot in sorted(visible)}
        able = {
            robot: way
            for robot, way in ways.items()
            if way is not None and rooms.organiser.allows(caller.principal, robot, way.skill.id)
        }
        chosen = self._reply_targets.answered(messenger.name, inbound)
        if chosen not in visible and not inbound.answers_us:
            chosen = rooms.container.selected(caller.principal, inbound.chat)
        if chosen in able:
            return chosen, able[chosen]
        if chosen in visible:
            shown = rooms.profiles[chosen].shown
            raise NotUnderstood(said("{robot} cannot be sent to a place on Earth.", robot=shown))
        if not able:
            raise NotUnderstood(NOBODY)
        if len(able) > 1:
            raise NotUnderstood(WHICH, offers=tuple(f"use {robot}" for robot in able))
        return next(iter(able.items()))


def way_of(profile: Profile) -> LocationSkill | None:
    """Return how a robot is sent to a place; None where its profile does not say."""
    said_parts = profile.go_to.split()
    if profile.frame is None or len(said_parts) != 3:  # noqa: PLR2004 - a skill, x and y
        return None
    name, x, y = said_parts
    return LocationSkill(profile.frame, profile.skills[name], x, y)


def _outside(shown: str, place: tuple[float, float], name: str, bounds: tuple[float, float]) -> str:
    return said(
        "For {robot} that is {x}, {y}, and its {name} goes from {low} to {high}. Nothing was done.",
        robot=shown,
        x=measured(f"{place[0]:.1f} m", place[0], "m"),
        y=measured(f"{place[1]:.1f} m", place[1], "m"),
        name=name,
        low=bound_in_words(bounds[0], "m", upper=False),
        high=bound_in_words(bounds[1], "m", upper=True),
    )
