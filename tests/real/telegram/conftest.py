from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.telegram import FakeTelegram, Settings
from tests.real.telegram.gateway import Gateway

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
async def server() -> AsyncIterator[FakeTelegram]:
    """Without limits, and with the bot reading everything in groups."""
    settings = Settings(privacy=False, conflict_pause_s=0.0)
    async with FakeTelegram(limits=None, settings=settings) as running:
        yield running
    assert running.violations == []


@pytest.fixture
def gateway(server: FakeTelegram) -> Gateway:
    return Gateway(server)


@pytest.fixture
def ada(server: FakeTelegram) -> int:
    return server.create_user("Ada", username="ada")
