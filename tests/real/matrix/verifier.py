"""One account at our own client, with cross-signing and verification, and no messenger."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack, suppress
from typing import TYPE_CHECKING, Any, Final, Self

from rosic.core.secret import Secret
from rosic.messengers.matrix.client import MatrixClient
from rosic.messengers.matrix.cross_signing import CrossSigning, OlmDeviceAccount
from rosic.messengers.matrix.device_trust import DirectTransport
from rosic.messengers.matrix.olm_machine import EventDecryptionError
from rosic.messengers.matrix.settings import MatrixSettings
from rosic.messengers.matrix.sync_answer import room_part
from rosic.messengers.matrix.trust import SenderAssurance, Trust, evidence_of
from rosic.messengers.matrix.verification import EmojiVerification
from rosic.system import SystemClock
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path
    from types import TracebackType

    from rosic.contracts.verification import ShownCode, VerificationResult
    from rosic.messengers.matrix.identity_book import KeyChange
    from rosic.messengers.matrix.sync_answer import SyncAnswer
    from tests.real.matrix.synapse import Account

WITHIN_S: Final = 30.0
_POLL_MS: Final = 200


class Verifier:
    """It follows what comes until it is left.

    Attributes:
        told: What was heard of keys.
        codes: The emoji that were shown.
        results: How verifications ended.
        heard: Text and assurance of each message, in order.
        unread: Events that could not be decrypted.
    """

    def __init__(self, account: Account, folder: Path) -> None:
        """Prepare it; nothing is opened.

        Args:
            account: Whose it is.
            folder: Its own; in one that was used before it is the same device again.
        """
        self.user = account.user
        self._password = Secret(account.password)
        settings = MatrixSettings(
            homeserver=account.url, user=account.user, password=self._password, folder=folder
        )
        self.client = MatrixClient("matrix", settings, SystemClock(), _everybody)
        self.told: list[KeyChange] = []
        self.codes: list[ShownCode] = []
        self.results: list[VerificationResult] = []
        self.heard: list[tuple[str, SenderAssurance]] = []
        self.unread: list[str] = []
        self._since = ""
        self._moved = asyncio.Condition()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self.client.held())
            await self._set_up()
            self._following = asyncio.create_task(self._follow())
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._following.cancel()
        with suppress(asyncio.CancelledError):
            await self._following
        await self._stack.aclose()

    async def _set_up(self) -> None:
        await self._take(await self._sync(0, full=True))
        await self.client.upkeep()
        self.directory = self.client.directory
        self.cross_signing = CrossSigning(
            OlmDeviceAccount(self.client.machine),
            self.client.call,
            self.client.folder,
            self.directory,
            self.told.append,
            knows=_everybody,
        )
        await self.cross_signing.start(self._password)
        transport = DirectTransport(self.client)
        self.emoji = EmojiVerification(self.cross_signing, transport, SystemClock(), self)
        self.trust = Trust(self.cross_signing)

    @property
    def device(self) -> str:
        return self.client.device

    # ---- its people ----

    def accepts(self, user: str) -> bool:
        return user != self.user

    def show(self, code: ShownCode) -> None:
        self.codes.append(code)

    def tell(self, result: VerificationResult) -> None:
        self.results.append(result)

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds; it is asked after every sync."""
        async with asyncio.timeout(WITHIN_S * pace()), self._moved:
            await self._moved.wait_for(lambda: condition() or self._following.done())
        assert condition(), self._following

    async def shown(self) -> ShownCode:
        """Wait until there are emoji to compare, and return them."""
        await self.until(lambda: bool(self.codes))
        return self.codes[-1]

    async def ended(self) -> VerificationResult:
        """Wait until a verification has ended, and return how."""
        await self.until(lambda: bool(self.results))
        return self.results[-1]

    # ---- what comes ----

    async def join(self, room: str) -> None:
        await self.client.call("POST", f"/_matrix/client/v3/join/{room}", {})
        await self.until(lambda: room in self.client.rooms)

    async def _follow(self) -> None:
        while True:
            answer = await self._sync(_POLL_MS, full=False)
            await self.client.upkeep()
            await self.cross_signing.keys_changed(answer.changed)
            await self._take(answer)
            async with self._moved:
                self._moved.notify_all()

    async def _take(self, answer: SyncAnswer) -> None:
        async for source in self.client.take_to_device(answer):
            await self.emoji.on_to_device(source)
        for room, piece in answer.joined.items():
            async for source in self.client.take_state(room, room_part(piece)):
                await self._hear(room, source)

    async def _hear(self, room: str, source: Mapping[str, Any]) -> None:
        try:
            event = self.client.open_event(room, source, SystemClock().wall_ns())
        except EventDecryptionError:
            self.unread.append(str(source["event_id"]))
            return
        await self.emoji.on_room_event(room, event.source)
        content = event.source.get("content", {})
        if content.get("msgtype") == "m.text" and event.sender != self.user:
            evidence = evidence_of(self.client.machine, room, event)
            self.heard.append((content["body"], await self.trust.assess(evidence)))

    async def _sync(self, timeout_ms: int, *, full: bool) -> SyncAnswer:
        answer = await self.client.sync(self._since, timeout_ms=timeout_ms, full=full, shape={})
        self._since = answer.next_batch
        return answer


def _everybody(_user: str) -> bool:
    return True
