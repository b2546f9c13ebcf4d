"""One browser for all the pages of a module, and a page of a gateway whose robots take notes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest_asyncio

from tests.api.served import served
from tests.console.browser import DESK, chromium, opened
from tests.console.robots import CUT, DRAINED, RESTLESS, SILENT, STOPPED_AT, noting

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    import pytest
    from playwright.async_api import Browser

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    async with chromium() as browser:
        yield browser


@pytest_asyncio.fixture(loop_scope="module")
async def place() -> AsyncIterator[ServedGateway]:
    for kept in (STOPPED_AT, CUT, SILENT, RESTLESS, DRAINED):
        kept.clear()
    async with served(robots_of=noting) as place:
        yield place


@pytest_asyncio.fixture(loop_scope="module")
async def there(
    request: pytest.FixtureRequest, browser: Browser, place: ServedGateway
) -> AsyncIterator[OpenPage]:
    """A page that nobody has signed in to yet; on a phone where the test asks for that."""
    async with opened(browser, place, getattr(request, "param", DESK)) as there:
        yield there
