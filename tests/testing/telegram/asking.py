"""A bare client of the Bot API, so that the tests see what is on the wire."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

import aiohttp

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram

START_S = 1_800_000_000.0


class Wall:
    """A clock that stands still until it is told otherwise."""

    def __init__(self) -> None:
        self.now_s = START_S

    def __call__(self) -> float:
        return self.now_s


class Api:
    """Calls methods with a JSON body, unless told otherwise."""

    def __init__(self, server: FakeTelegram) -> None:
        self.server = server
        self.session = aiohttp.ClientSession()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.session.close()

    def url(self, method: str) -> str:
        return f"{self.server.api_base}{self.server.token}/{method}"

    async def raw(self, method: str, **parameters: object) -> dict[str, Any]:
        """Return the whole answer."""
        async with self.session.post(self.url(method), json=parameters) as response:
            answer: dict[str, Any] = await response.json()
            assert response.status == (200 if answer["ok"] else answer["error_code"])
            return answer

    async def ok(self, method: str, **parameters: object) -> Any:  # noqa: ANN401 - any JSON
        """Return the result of a call that must succeed."""
        answer = await self.raw(method, **parameters)
        assert answer["ok"], answer
        return answer["result"]

    async def refusal(self, method: str, **parameters: object) -> str:
        """Return code and description of a call that must be refused."""
        answer = await self.raw(method, **parameters)
        assert not answer["ok"], answer
        return f"{answer['error_code']} {answer['description']}"

    async def texts(self, offset: int = 0, **parameters: object) -> list[str]:
        """Return the texts of the waiting messages."""
        updates = await self.ok("getUpdates", offset=offset, **parameters)
        return [update["message"]["text"] for update in updates]
