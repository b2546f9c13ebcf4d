"""One launcher for all journeys: importing ROSIC takes longer than most of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.journeys.running import Launcher

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="session")
def launcher() -> Iterator[Launcher]:
    """Fork gateways from a process that has imported everything."""
    launcher = Launcher()
    yield launcher
    launcher.close()
