"""What decides is there from the first moment: until whoever knows is made, it refuses (I18)."""

from __future__ import annotations

import pytest

from rosic.authoriser.invitations import InvitedRights
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.config.profiles import known_units
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.signal import Deferred
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import RobotStopped
from rosic.gateway.access_registry import AccessRegistry, PlaceNames, authoriser_of
from rosic.gateway.policy_service import PolicyService
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy
from tests.organiser.booking import UNNAMED


def test_until_it_is_bound_it_refuses_and_it_is_bound_once() -> None:
    decides: Deferred[[str], bool] = Deferred(lambda _who: False)
    assert not decides("Ada")
    decides.bind(lambda who: who == "Ada")
    assert decides("Ada")
    with pytest.raises(RuntimeError):
        decides.bind(lambda _who: True)
    assert not decides("Bo")


def test_nothing_is_resumed_before_it_is_known_what_may_be() -> None:
    stops = StopRegistry(["omni"], {}, not_known_yet())
    assert isinstance(stops.barred("omni"), RobotStopped)
    stops.barred.bind(lambda _robot: None)
    assert stops.barred("omni") is None


def test_nobody_is_let_in_before_it_is_known_who_may_let_them() -> None:
    clock, entropy = ManualClock(), SeededEntropy()
    authoriser = authoriser_of(MonotonicWallClock(clock), clock, entropy)
    rulebook = RoleRules(roles=DEFAULT_ROLES)
    authority = PolicyService(rulebook, (), known_units(), clock, lambda _who: ())
    stops = StopRegistry([], {}, not_known_yet())
    called = PlaceNames("lab", UNNAMED)
    access = AccessRegistry(authoriser, authority, MemoryStore(), entropy, stops, called)
    assert not access.enrolment.may_invite("p-1", InvitedRights(roles=("viewer",)))
