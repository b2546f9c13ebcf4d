"""Every guard of authority was seen to matter: taken out, the oracle disagrees."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.core.rights.planted import FAULTS
from tests.planted import test_faults

if TYPE_CHECKING:
    from pathlib import Path

    from tests.planted.faults import Fault


pytestmark = pytest.mark.limit(test_faults.WITHIN_S + 10)


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_the_oracle_notices(fault: Fault, tmp_path: Path) -> None:
    test_faults.test_the_fault_is_caught(fault, tmp_path)
