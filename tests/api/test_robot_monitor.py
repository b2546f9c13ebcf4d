"""Robots at rest are looked at seldom, and nothing that matters is seen late."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.api.robot_monitor import REST_NS, VALUES_NS, RobotMonitor
from rosic.api.schemas import PresenceOut, RobotOut
from rosic.app.demo import fleet

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

LOOK_NS = 200_000_000
OMNI = next(profile for profile in fleet() if profile.id == "omni")


class Place:
    """A robot, the time, and who looks at it; counts how often it is asked how it is."""

    def __init__(self) -> None:
        self.now_ns, self.asked = 0, 0
        self.held = (False, "")
        self.presence = PresenceOut(
            online=True,
            age_s=0.0,
            doing="",
            at_rest=True,
            values={"battery": 90.0},
            ages_s={"battery": 0.0},
            pose=None,
        )
        self.looks = RobotMonitor(self._show, lambda _robot: self.held, lambda: self.now_ns)

    def _show(self, profile: Profile) -> RobotOut:
        self.asked += 1
        stopped, holder = self.held
        return RobotOut(
            id=profile.id,
            name=profile.shown,
            groups=(),
            skills=(),
            stopped=stopped,
            holder=holder,
            presence=self.presence,
            views=(),
            units={},
            watchdog_s=None,
        )

    def after(self, past_ns: int = LOOK_NS) -> RobotOut:
        """Return what is shown so much later."""
        self.now_ns += past_ns
        return self.looks.look(OMNI)

    def seen_within(self, most_ns: int) -> bool:
        """Whether something else than now is shown within that time."""
        before, begun_ns = self.looks.look(OMNI), self.now_ns
        while self.now_ns - begun_ns < most_ns:
            if self.after() is not before:
                return True
        return False


def test_ages_alone_are_no_news() -> None:
    place = Place()
    before = place.after()
    place.presence = replace(place.presence, age_s=60.0, ages_s={"battery": 60.0})
    assert place.after(REST_NS) is before


def test_a_robot_at_rest_is_asked_twice_a_second_and_one_that_moves_at_every_look() -> None:
    place = Place()
    for _ in range(50):
        place.after()
    assert place.asked <= 10 * 2 + 1
    place.presence = replace(place.presence, at_rest=False)
    place.after(REST_NS)
    place.asked = 0
    for _ in range(50):
        place.after()
    assert place.asked == 50


@pytest.mark.parametrize("change", [{"online": False}, {"at_rest": False}, {"doing": "dock"}])
def test_what_becomes_of_a_robot_at_rest_is_seen_within_a_second(change: dict[str, object]) -> None:
    place = Place()
    place.after()
    place.presence = replace(place.presence, **change)
    assert place.seen_within(REST_NS + LOOK_NS)


def test_a_stop_and_a_holder_and_an_order_are_seen_at_the_next_look() -> None:
    place = Place()
    place.after()
    for held in ((True, ""), (True, "Ada"), (False, "Ada")):
        place.held = held
        shown = place.after()
        assert (shown.stopped, shown.holder) == held
    place.presence = replace(place.presence, at_rest=False)
    place.looks.wake("omni")
    assert place.after().presence.at_rest is False


def test_values_that_creep_are_told_once_a_second_and_an_age_never() -> None:
    place = Place()
    told: list[RobotOut] = []
    for number in range(50):
        place.presence = replace(place.presence, values={"battery": 90.0 - number}, age_s=number)
        shown = place.after()
        if not told or told[-1] is not shown:
            told.append(shown)
    assert 8 <= len(told) <= 50 * LOOK_NS // VALUES_NS + 1
    assert place.looks.look(OMNI, anew=True).presence.age_s == 49
    before = place.looks.look(OMNI)
    for number in range(50):
        place.presence = replace(place.presence, age_s=50.0 + number)
        assert place.after() is before


def test_what_is_no_more_is_forgotten_and_comes_back_as_new() -> None:
    place = Place()
    before = place.after()
    place.looks.keep(())
    assert place.looks.look(OMNI) is not before
