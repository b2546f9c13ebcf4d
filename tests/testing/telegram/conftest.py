from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.telegram import FakeTelegram, Settings
from tests.testing.telegram.asking import Api, Wall

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
def wall() -> Wall:
    return Wall()


@pytest.fixture
async def server(wall: Wall) -> AsyncIterator[FakeTelegram]:
    """Without limits; its clock stands still; the second 409 is not delayed."""
    settings = Settings(conflict_pause_s=0.0)
    async with FakeTelegram(limits=None, settings=settings, wall_s=wall) as running:
        yield running


@pytest.fixture
async def api(server: FakeTelegram) -> AsyncIterator[Api]:
    async with Api(server) as client:
        yield client


@pytest.fixture
def ada(server: FakeTelegram) -> int:
    return server.create_user("Ada", username="ada")
