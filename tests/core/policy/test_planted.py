"""Every guard of authority was seen to matter: taken out, the oracle disagrees."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.core.policy.planted import FAULTS
from tests.planted.planting import WITHIN_S, assert_caught, opened

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.planted.faults import Fault
    from tests.planted.planting import Nursery


pytestmark = pytest.mark.limit(WITHIN_S + 10)


@pytest.fixture(scope="module")
def nursery() -> Iterator[Nursery]:
    with opened() as nursery:
        yield nursery


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_the_oracle_notices(fault: Fault, tmp_path: Path, nursery: Nursery) -> None:
    assert_caught(fault, tmp_path, nursery)
