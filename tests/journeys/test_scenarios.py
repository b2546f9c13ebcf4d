"""The paper's five scenarios over the fake Bot API server."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from rosic.testing.ros2.graph import why_missing
from tests.journeys.chats import telegram_chats
from tests.journeys.scenarios import ScenarioTests, scenarios
from tests.journeys.scenes import scenes

if TYPE_CHECKING:
    import asyncio
    from collections.abc import AsyncIterator

    from tests.journeys.running import Launcher

pytestmark = [
    pytest.mark.limit(480),
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def acts(
    tmp_path_factory: pytest.TempPathFactory, launcher: Launcher
) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin every scenario; a test waits for the end of one."""
    folder = tmp_path_factory.mktemp("scenes")
    async with (
        telegram_chats(folder, launcher) as chats,
        scenes(folder, launcher, chats) as here,
        scenarios(here) as begun,
    ):
        yield begun


class TestTelegram(ScenarioTests):
    """By Telegram."""
