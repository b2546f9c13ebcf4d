"""The control side from another process."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any, Self, Unpack

import aiohttp

from rosic.testing.telegram.refusals import ControlError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType

    from rosic.testing.telegram.people import MessageOptions
    from rosic.testing.telegram.state import JsonObject

SPARE_S = 60.0


class Control:
    """The verbs of `FakeTelegram` over HTTP; `call` reaches those without a method of their own.

    Args:
        url: As printed by `python -m rosic.testing.telegram`.
    """

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/")
        self._session: aiohttp.ClientSession | None = None

    @property
    def api_base(self) -> str:
        """For python-telegram-bot's `base_url`."""
        return f"{self.url}/bot"

    @property
    def file_base(self) -> str:
        """For python-telegram-bot's `base_file_url`."""
        return f"{self.url}/file/bot"

    async def __aenter__(self) -> Self:
        self._session = aiohttp.ClientSession()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._session is not None:
            await self._session.close()

    async def call(self, verb: str, **parameters: object) -> Any:  # noqa: ANN401 - any JSON
        """Call a verb by name.

        Raises:
            ControlError: The server says why.
        """
        if self._session is None:
            raise ControlError("use it as `async with Control(url) as control:`")
        patience_s = float(str(parameters.get("timeout_s", 0.0))) + SPARE_S
        async with self._session.post(
            f"{self.url}/_control/{verb}",
            json=parameters,
            timeout=aiohttp.ClientTimeout(total=patience_s),
        ) as response:
            answer = await response.json()
        if not answer["ok"]:
            raise ControlError(answer["error"])
        return answer["result"]

    async def create_user(self, first_name: str, **details: object) -> int:
        """See `FakeTelegram.create_user`."""
        return int(await self.call("create_user", first_name=first_name, **details))

    async def create_chat(self, kind: str, title: str, **details: object) -> int:
        """See `FakeTelegram.create_chat`."""
        return int(await self.call("create_chat", kind=kind, title=title, **details))

    async def say(
        self, chat: int, user: int | None, text: str, **unusual: Unpack[MessageOptions]
    ) -> int:
        """See `FakeTelegram.say`."""
        return int(await self.call("say", chat=chat, user=user, text=text, **unusual))

    async def edit(self, chat: int, message: int, text: str) -> int:
        """See `FakeTelegram.edit`."""
        return int(await self.call("edit", chat=chat, message=message, text=text))

    async def tap(self, user: int, chat: int, message: int, button: str, **how: bool) -> str:
        """See `FakeTelegram.tap`."""
        press = {"user": user, "chat": chat, "message": message, "button": button}
        return str(await self.call("tap", **press, **how))

    async def backlog(
        self, chat: int, user: int | None, text: str, count: int, **unusual: Unpack[MessageOptions]
    ) -> list[int]:
        """See `FakeTelegram.backlog`."""
        numbers: list[int] = await self.call(
            "backlog", chat=chat, user=user, text=text, count=count, **unusual
        )
        return numbers

    async def send_file(
        self, chat: int, user: int, name: str, content: bytes, **unusual: Unpack[MessageOptions]
    ) -> int:
        """See `FakeTelegram.send_file`."""
        coded = base64.b64encode(content).decode()
        return int(
            await self.call("send_file", chat=chat, user=user, name=name, content=coded, **unusual)
        )

    async def file(self, file_id: str) -> bytes:
        """See `FakeTelegram.file`."""
        return base64.b64decode(await self.call("file", file_id=file_id))

    async def fail(self, kind: str, method: str = "*", times: int = 1, **details: object) -> None:
        """See `FakeTelegram.fail`."""
        await self.call("fail", kind=kind, method=method, times=times, **details)

    async def message(self, chat: int, message: int) -> JsonObject:
        """See `FakeTelegram.message`."""
        seen: JsonObject = await self.call("message", chat=chat, message=message)
        return seen

    async def messages(
        self, chat: int, *, by_bot: bool = False, after: int = 0
    ) -> list[JsonObject]:
        """See `FakeTelegram.messages`."""
        seen: list[JsonObject] = await self.call("messages", chat=chat, by_bot=by_bot, after=after)
        return seen

    async def presses(self, chat: int) -> list[JsonObject]:
        """See `FakeTelegram.presses`."""
        found: list[JsonObject] = await self.call("presses", chat=chat)
        return found

    async def calls(self) -> list[JsonObject]:
        """See `FakeTelegram.calls`."""
        found: list[JsonObject] = await self.call("calls")
        return found

    async def violations(self) -> list[JsonObject]:
        """See `FakeTelegram.violations`."""
        found: list[JsonObject] = await self.call("violations")
        return found

    async def seq(self) -> int:
        """See `FakeTelegram.seq`."""
        return int(await self.call("seq"))

    async def pending(self) -> int:
        """See `FakeTelegram.pending`."""
        return int(await self.call("pending"))

    async def wait(
        self, after: int, timeout_s: float = 10.0, kinds: Sequence[str] = ()
    ) -> list[JsonObject]:
        """See `FakeTelegram.wait`."""
        found: list[JsonObject] = await self.call(
            "wait", after=after, timeout_s=timeout_s, kinds=list(kinds)
        )
        return found
