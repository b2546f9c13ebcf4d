"""What decides is there from the first moment: until whoever knows is made, it refuses (I18)."""

from __future__ import annotations

import pytest

from rosic.app.documents.profiles import known_units
from rosic.app.placing.access import Access, authoriser_of
from rosic.app.placing.authority import Authority
from rosic.authoriser.highwater import HighWater
from rosic.authoriser.invitation import Given
from rosic.core.deferred import Deferred
from rosic.core.roles import DEFAULT_ROLES, Rulebook
from rosic.core.stopboard import StopBoard, not_known_yet
from rosic.errors import RobotStopped
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy


def test_until_it_is_bound_it_refuses_and_it_is_bound_once() -> None:
    decides: Deferred[[str], bool] = Deferred(lambda _who: False)
    assert not decides("Ada")
    decides.bind(lambda who: who == "Ada")
    assert decides("Ada")
    with pytest.raises(RuntimeError):
        decides.bind(lambda _who: True)
    assert not decides("Bo")


def test_nothing_is_resumed_before_it_is_known_what_may_be() -> None:
    board = StopBoard(["omni"], {}, not_known_yet())
    assert isinstance(board.barred("omni"), RobotStopped)
    board.barred.bind(lambda _robot: None)
    assert board.barred("omni") is None


def test_nobody_is_let_in_before_it_is_known_who_may_let_them() -> None:
    clock, entropy = ManualClock(), SeededEntropy()
    authoriser = authoriser_of(HighWater(clock), clock, entropy)
    rulebook = Rulebook(roles=DEFAULT_ROLES)
    authority = Authority(rulebook, (), known_units(), clock, lambda _who: ())
    access = Access(authoriser, authority, MemoryStore(), entropy, "lab")
    assert not access.enrolment.may_invite("p-1", Given(roles=("viewer",)))
