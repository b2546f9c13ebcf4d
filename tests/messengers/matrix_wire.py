"""Verifications of several accounts, joined by a wire that a test may bend."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosic.errors import MessengerFault
from rosic.messengers.matrix.verification import (
    EmojiVerification,
)
from rosic.testing.clock import ManualClock
from tests.messengers.matrix_identities import (
    ADA,
    ROBOT,
    Account,
    Device,
    Homeserver,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.verification import ShownCode, VerificationEnd, VerificationResult

ROOM = "!room:example.org"
Event = dict[str, Any]


class Wire:
    """Carries to-device messages and events of one room between ends; a test may change them.

    Attributes:
        sent: All that was sent, as it was sent.
        change: Is given each event, by kind, and returns what arrives: nothing, or several.
    """

    def __init__(self) -> None:
        self.ends: list[End] = []
        self.sent: list[tuple[str, Event]] = []
        self.change: dict[str, Callable[[Event], list[Event]]] = {}
        self.broken = False
        self._waiting: list[tuple[str, Event]] = []

    async def carry(self) -> None:
        """Let everything arrive, and what is answered to it."""
        while self._waiting:
            to, event = self._waiting.pop(0)
            change = self.change.get(event["type"])
            for arriving in change(event) if change else [event]:
                for end in self.ends:
                    if to == ROOM:
                        await end.emoji.on_room_event(ROOM, arriving)
                    elif to == f"{end.user} {end.device.device}":
                        await end.emoji.on_to_device(arriving)

    def put(self, to: str, event: Event) -> None:
        if self.broken:
            raise MessengerFault("The homeserver cannot be reached.")
        self.sent.append((to, event))
        self._waiting.append((to, event))

    def kinds(self) -> list[str]:
        return [event["type"].rpartition(".")[2] for _, event in self.sent]


class End(Account):
    """One account's verifications, on a wire. It is its own transport and its own people."""

    def __init__(
        self, wire: Wire, homeserver: Homeserver, clock: ManualClock, user: str, device: str
    ) -> None:
        own = Device(user, device)
        homeserver.add(own)
        super().__init__(homeserver, own)
        self.user = user
        self.wire = wire
        self.clock = clock
        self.codes: list[ShownCode] = []
        self.results: list[VerificationResult] = []
        self.strangers: set[str] = set()
        self.emoji = EmojiVerification(self.cross_signing, self, clock, self)
        wire.ends.append(self)

    async def to_device(self, user: str, device: str, kind: str, content: Event) -> None:
        event = {"type": kind, "sender": self.user, "content": content}
        for end in self.wire.ends:
            if end.user == user and device in {end.device.device, "*"}:
                self.wire.put(f"{user} {end.device.device}", event)

    async def in_room(self, room: str, kind: str, content: Event) -> str:
        assert room == ROOM
        event_id = f"${len(self.wire.sent)}"
        self.wire.put(
            ROOM,
            {
                "type": kind,
                "sender": self.user,
                "content": content,
                "event_id": event_id,
                "origin_server_ts": self.clock.wall_ns() // 10**6,
            },
        )
        return event_id

    def accepts(self, user: str) -> bool:
        return user not in self.strangers

    def show(self, code: ShownCode) -> None:
        self.codes.append(code)

    def tell(self, result: VerificationResult) -> None:
        self.results.append(result)

    async def trusts(self, user: str, device: str) -> bool:
        self.directory.forget(user)
        return await self.cross_signing.is_verified_device(user, device)


class Pair:
    """The robot and Ada, both with cross-signing, on one wire."""

    def __init__(self) -> None:
        self.wire = Wire()
        self.homeserver = Homeserver()
        self.clock = ManualClock()
        self.robot = self.end(ROBOT, "ROBOTDEV")
        self.ada = self.end(ADA, "PHONE")

    def end(self, user: str, device: str) -> End:
        return End(self.wire, self.homeserver, self.clock, user, device)

    async def begin(self, one: End, *, room: str = "") -> str:
        """Have one end begin, up to where both show a code, and return its id."""
        name = await one.emoji.begin(self.other(one).user, room=room)
        await self.wire.carry()
        return name

    def other(self, one: End) -> End:
        return self.ada if one is self.robot else self.robot

    async def confirm(self, name: str) -> None:
        for end in (self.robot, self.ada):
            await end.emoji.confirm(name)
        await self.wire.carry()

    def ends(self) -> set[tuple[VerificationEnd, str]]:
        assert len(self.robot.results) == len(self.ada.results) == 1
        return {(result.end, result.code) for result in self.robot.results + self.ada.results}
