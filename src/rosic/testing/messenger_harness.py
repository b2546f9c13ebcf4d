"""The other side of a messenger under the rules: people, what they see, and an inbox."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.contracts.messenger import settle_with
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable
    from contextlib import AbstractAsyncContextManager

    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Chat, Inbound, MessageValidity


class SeenMessage(NamedTuple):
    """A message as a person sees it now."""

    message: str
    text: str


class MessengerHarness(Protocol):
    """A messenger, and what happens on the other side of it.

    Attributes:
        messenger: The one under test, not running.
        people: One or more, each in a private chat with it.
        patience_s: How long something that must happen may take.
        keeps: The platform gives out again what was not confirmed.
        taps: People have buttons to tap.
        unusual: How else than fresh a message may come on this platform: changed, passed on.
    """

    messenger: Messenger
    people: tuple[str, ...]
    patience_s: float
    keeps: bool
    taps: bool
    unusual: tuple[MessageValidity, ...]

    def chat(self, person: str) -> Chat:
        """Return the person's chat, as the messenger names it."""
        ...

    async def write(self, person: str, text: str) -> None:
        """Let a person write."""
        ...

    async def write_unusually(self, person: str, text: str, standing: MessageValidity) -> None:
        """Let a person change a message of theirs to this text, or pass on what another wrote."""

    async def tap(self, person: str, message: str, label: str) -> None:
        """Let a person tap the button with this label under a message of the messenger."""
        ...

    async def screen(self, person: str) -> list[SeenMessage]:
        """Return what the messenger shows to this person now, oldest first."""
        ...

    async def files(self, person: str) -> list[tuple[str, bytes]]:
        """Return the files that this person was sent: name and content, oldest first."""
        ...

    async def enclose(self, person: str, name: str, content: bytes) -> None:
        """Let a person send a file; only asked where the messenger fetches any."""

    async def pinned(self, person: str) -> list[str]:
        """Return which messages are kept in sight in this person's chat."""
        ...

    async def unconfirmed(self) -> int:
        """Return how many messages the platform would give out again."""
        ...

    def outage(self) -> AbstractAsyncContextManager[None]:
        """Let the platform be away while inside."""
        ...


class HarnessInbox:
    """What a messenger hands its messages to.

    Attributes:
        heard: What was handed over.
        done: What was received to the end.
        gate: While it is cleared, nothing is received to the end.
    """

    def __init__(self) -> None:
        self.heard: list[Inbound] = []
        self.done: list[Inbound] = []
        self.gate = asyncio.Event()
        self.gate.set()

    async def receive(self, inbound: Inbound) -> None:
        """Take one message."""
        self.heard.append(inbound)
        await self.gate.wait()
        self.done.append(inbound)

    def texts(self, chat: Chat) -> list[str]:
        """Return what was handed over in one chat."""
        return [inbound.text for inbound in self.heard if inbound.chat.id == chat.id]


async def until(stage: MessengerHarness, condition: Callable[[], bool], otherwise: str) -> None:
    """Wait for a condition; an AssertionError says what did not happen."""
    loop = asyncio.get_running_loop()
    give_up_s = loop.time() + stage.patience_s
    while not condition():
        assert loop.time() < give_up_s, otherwise
        await asyncio.sleep(0.005)


async def until_confirmed(stage: MessengerHarness) -> None:
    """Wait until the platform has nothing to give out again."""
    loop = asyncio.get_running_loop()
    give_up_s = loop.time() + stage.patience_s
    while await stage.unconfirmed():
        assert loop.time() < give_up_s, "what was received to the end was not confirmed"
        await asyncio.sleep(0.005)


async def until_fresh(stage: MessengerHarness, inbox: HarnessInbox) -> None:
    """Wait until what is written now is no backlog any more; then forget what was heard."""
    give_up_s = asyncio.get_running_loop().time() + stage.patience_s
    while not inbox.done or inbox.done[-1].sent_ns < inbox.done[-1].listening_since_ns:
        assert asyncio.get_running_loop().time() < give_up_s, "everything is taken for backlog"
        count = len(inbox.done)
        await stage.write(stage.people[0], "hello")
        await until(stage, lambda more=count: len(inbox.done) > more, "a message was swallowed")  # type: ignore[misc]
    inbox.heard.clear()
    inbox.done.clear()


async def settled(_within_s: float) -> bool:
    """Say that what was received is on disk: an inbox keeps what it is handed."""
    return True


@asynccontextmanager
async def listening(
    stage: MessengerHarness, inbox: HarnessInbox | None = None
) -> AsyncIterator[HarnessInbox]:
    """Let the messenger run while inside."""
    inbox = HarnessInbox() if inbox is None else inbox
    settle_with(stage.messenger, settled)
    run = asyncio.create_task(stage.messenger.run(inbox.receive))
    try:
        yield inbox
    finally:
        run.cancel()
        ended, _ = await asyncio.wait([run], timeout=stage.patience_s)
        assert ended, "run did not end when it was cancelled"
        if not run.cancelled() and (error := run.exception()) is not None:
            raise AssertionError("run ended by itself") from error


async def faults_only(what: str, call: Awaitable[object]) -> None:
    """Make a call that must fail, and fail as the contract says."""
    try:
        await call
    except MessengerFault:
        return
    except Exception as error:
        raise AssertionError(f"{what} raised {type(error).__name__}") from error
    raise AssertionError(f"{what} did not fail")
