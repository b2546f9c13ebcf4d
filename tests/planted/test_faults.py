"""Every guard was seen to matter: taken out, a test fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.planted.faults import FAULTS
from tests.planted.faults_of_alerts import OF_ALERTS
from tests.planted.faults_of_among import OF_AMONG
from tests.planted.faults_of_breaks import OF_BREAKS
from tests.planted.faults_of_busy import OF_BUSY
from tests.planted.faults_of_cancelling import OF_CANCELLING
from tests.planted.faults_of_cards import OF_CARDS
from tests.planted.faults_of_dispatch import OF_DISPATCH
from tests.planted.faults_of_fleet import OF_FLEET, OF_TASKS
from tests.planted.faults_of_keeping import OF_KEEPING
from tests.planted.faults_of_orders import OF_ORDERS
from tests.planted.faults_of_telling import OF_TELLING
from tests.planted.messenger_faults import MESSENGER_FAULTS
from tests.planted.planting import WITHIN_S, assert_caught, opened

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.planted.faults import Fault
    from tests.planted.planting import Nursery

ALL = (
    *FAULTS, *OF_ORDERS, *OF_DISPATCH, *OF_CARDS, *OF_TELLING, *OF_ALERTS, *OF_AMONG, *OF_FLEET,
    *OF_TASKS, *OF_KEEPING, *OF_BREAKS, *OF_CANCELLING, *OF_BUSY, *MESSENGER_FAULTS,
)  # fmt: skip


pytestmark = pytest.mark.limit(WITHIN_S + 10)


@pytest.fixture(scope="module")
def nursery() -> Iterator[Nursery]:
    with opened() as nursery:
        yield nursery


@pytest.mark.parametrize("fault", ALL, ids=[fault.name for fault in ALL])
def test_the_fault_is_caught(fault: Fault, tmp_path: Path, nursery: Nursery) -> None:
    assert_caught(fault, tmp_path, nursery)
