"""The messenger at a homeserver that a test speaks for; Ada's keys were compared."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING, Any, Final

from rosic.core.message import MessageValidity
from rosic.core.time_units import SECOND_NS
from rosic.messengers.matrix.messenger import MatrixMessenger, matrix_messenger
from rosic.testing.clock import ManualClock
from rosic.testing.messenger_harness import HarnessInbox, settled
from tests.messengers.matrix_homeserver import (
    ENCRYPTION,
    ROBOTS,
    EncryptingDevice,
    Owner,
    WireHomeserver,
    text,
)
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence
    from pathlib import Path

    from rosic.core.identity import Address
    from rosic.core.message import Inbound

Event = dict[str, Any]

ADA: Final = "@ada:example.org"
BOB: Final = "@bob:example.org"
EVE: Final = "@eve:example.org"
KNOWN: Final = frozenset({ADA, BOB})
WITHIN_S: Final = 30.0
LIFETIME_NS: Final = 5 * SECOND_NS
MILLISECOND_NS: Final = SECOND_NS // 1_000


class HostileLab:
    """What a test looks at, and writes with.

    Attributes:
        alarms: What admins were told.
        eve: A stranger, with keys of her own.
    """

    def __init__(
        self, server: WireHomeserver, messenger: MatrixMessenger, clock: ManualClock
    ) -> None:
        self.server = server
        self.messenger = messenger
        self.clock = clock
        self.inbox = HarnessInbox()
        self.alarms: list[str] = []
        self.ada, self.bob, self.eve = Owner(ADA), Owner(BOB), Owner(EVE)
        self._events = count(1)
        for owner in (self.ada, self.bob, self.eve):
            server.knows(owner)

    @property
    def now_ms(self) -> int:
        return self.clock.wall_ns() // MILLISECOND_NS

    async def compare(self, owner: Owner) -> None:
        """Have two people compared this person's keys."""
        signing = self.messenger._trust._cross_signing
        assert signing is not None
        keys, _ = await signing.look_up(owner.user)
        device = keys.device(owner.phone.device)
        assert device is not None
        await signing.compared(device, keys.master)

    # ---- events ----

    def event(self, sender: str, kind: str, content: object, **more: object) -> Event:
        """Return an event as it comes in a sync."""
        found = {
            "type": kind,
            "sender": sender,
            "event_id": f"$event{next(self._events)}",
            "origin_server_ts": self.now_ms,
            "content": content,
        }
        return found | more

    def state(self, kind: str, key: str, content: object, sender: str = ADA) -> Event:
        return self.event(sender, kind, content, state_key=key)

    def members(self, *users: str) -> list[Event]:
        joined = {"membership": "join"}
        return [self.state("m.room.member", user, joined, user) for user in users]

    def sealed(self, device: EncryptingDevice, room: str, body: str, **more: object) -> Event:
        """Return what a device says in a room, encrypted."""
        content = device.sealed(room, text(body))
        return self.event(device.user, "m.room.encrypted", content) | more

    def plain(self, sender: str, body: str, **more: object) -> Event:
        return self.event(sender, "m.room.message", text(body)) | more

    def entering(self, *users: str, encrypted: bool = True) -> Event:
        """Return what a sync shows of a room that was just entered."""
        state = self.members(*users)
        if encrypted:
            state.append(self.state("m.room.encryption", "", ENCRYPTION))
        return {"state": {"events": state}, "timeline": {"events": self.members(ROBOTS)}}

    # ---- syncs ----

    async def gives(
        self,
        rooms: dict[str, Sequence[Event]] | None = None,
        *,
        joined: dict[str, Event] | None = None,
        to_device: Sequence[Event] = (),
        **more: Any,  # noqa: ANN401 - any part of an answer
    ) -> None:
        """Answer a sync, and wait until it was taken apart."""
        join = dict(joined or {})
        for room, events in (rooms or {}).items():
            join[room] = {"timeline": {"events": list(events)}}
        answer = {"rooms": {"join": join}, "to_device": {"events": list(to_device)}} | more
        async with asyncio.timeout(WITHIN_S * pace()):
            await self.server.taken(self.server.gives(answer))

    async def hears(self, body: str) -> Inbound:
        """Wait until a message with this text was handed over."""
        await self.until(lambda: any(one.text == body for one in self.inbox.heard))
        return next(one for one in self.inbox.heard if one.text == body)

    async def until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(WITHIN_S * pace()):
            while not condition():  # noqa: ASYNC110 - several things may make it true
                await asyncio.sleep(0.001)

    async def listens(self) -> None:
        """Wait until nothing is backlog any more."""
        async with asyncio.timeout(WITHIN_S * pace()):
            while self.messenger.catching_up():  # noqa: ASYNC110 - likewise
                await asyncio.sleep(0.002)

    def moved(self) -> list[Inbound]:
        """Return what would have moved a robot, if it asked for that."""
        return [one for one in self.inbox.heard if moves(one)]


def moves(one: Inbound) -> bool:
    """Whether a gateway would act on a message, or on a tap, that asks for a motion."""
    fresh = one.received_ns - one.sent_ns <= LIFETIME_NS
    listened = one.sent_ns >= one.listening_since_ns
    return one.standing is MessageValidity.FRESH and fresh and listened


@asynccontextmanager
async def hostile_lab(folder: Path) -> AsyncIterator[HostileLab]:
    """Run a messenger that follows verified devices alone, listening already."""
    clock = ManualClock()
    async with WireHomeserver().running() as server:
        settings = {
            "homeserver": server.url,
            "user": ROBOTS,
            "password": "secret",
            "folder": str(folder / "robots"),
        }
        messenger = matrix_messenger("lab", settings, clock)
        lab = HostileLab(server, messenger, clock)
        messenger.settle_with(settled)
        messenger.know_with(_known)
        messenger.alarm_with(lambda fault: lab.alarms.append(str(fault)))
        run = asyncio.create_task(messenger.run(lab.inbox.receive))
        try:
            await lab.until(lambda: messenger.is_connected() or run.done())
            assert not run.done(), run.exception()
            await lab.listens()
            await lab.compare(lab.ada)
            yield lab
        finally:
            run.cancel()
            await asyncio.wait([run])


def _known(who: Address) -> bool:
    return who.account in KNOWN
