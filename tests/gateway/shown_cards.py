"""A place whose chats may have live cards, and what people read on them."""

from __future__ import annotations

import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import ChatKind
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.messengers.memory import MemoryMessenger
from rosic.testing.clock import START_WALL_NS
from tests.gateway.place import ADA, FLEET, Place, edited

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.core.message import Outbound
    from rosic.core.robot.profile import Profile
    from rosic.messengers.memory import ShownMessage
    from rosic.stores.memory import MemoryStore
    from rosic.testing.clock import ManualClock

STAMP = re.compile(r"(?:updated|Stand) (\d+), (?:next by|der nächste bis) (\d+)")
ONE_ROBOT = Role(scopes=("omni:*",), priority=5)
GROUP: dict[str, Any] = {"chat": "-7", "kind": ChatKind.GROUP}


class Shown:
    """A place, and its cards.

    Attributes:
        place: All of it.
    """

    def __init__(self, place: Place) -> None:
        self.place = place

    def cards(self, chat: str = "1") -> list[str]:
        """Return the messages that were ever a card in a chat."""
        told = [t for t in self.place.chat.told if t.outbound.chat.id == chat]
        return [t.message for t in told if not t.edited and STAMP.search(t.outbound.text)]

    def card(self, chat: str = "1") -> Outbound:
        """Return the newest card of a chat as it looks now."""
        return self.place.chat.shown(self.cards(chat)[-1])

    def text(self, chat: str = "1") -> str:
        """Return what it says."""
        return self.card(chat).text

    def edits(self, chat: str = "1") -> list[ShownMessage]:
        """Return every edit of a chat's cards."""
        cards = self.cards(chat)
        return [t for t in self.place.chat.told if t.edited and t.message in cards]

    def now_s(self) -> int:
        """Return the time as the cards say it: whole seconds of this test."""
        return (self.place.clock.wall_ns() - START_WALL_NS) // 1_000_000_000

    def stamp(self, chat: str = "1") -> tuple[int, int]:
        """Return when the card says it was so, and by when it says something new."""
        found = STAMP.search(self.text(chat))
        assert found is not None, self.text(chat)
        return int(found[1]), int(found[2])

    async def pass_s(self, seconds: int) -> None:
        """Let time pass, a second at a time."""
        for _ in range(seconds):
            await self.place.clock.advance(1.0)
            await self.place.quiet()

    async def begins(self, line: str = "/card", account: str = ADA, **how: object) -> str:
        """Ask for a card; return what it says."""
        how.setdefault("chat", account)
        await self.place.say(line, account=account, **how)
        return self.text(str(how["chat"]))

    def finish(self, robot: str) -> None:
        """Let a robot end what it does."""
        end = self.place.robot(robot)._end
        assert end is not None
        end.set_result(None)


class SlowMessenger(MemoryMessenger):
    """Its platform takes an edit only after a while."""

    def __init__(self, clock: ManualClock) -> None:
        super().__init__("memory", clock=clock)
        self.slow_s = 0.0

    async def edit(self, message: str, outbound: Outbound) -> None:
        if self.slow_s:
            await self._clock.sleep(self.slow_s)
        await super().edit(message, outbound)


@asynccontextmanager
async def showing(
    store: MemoryStore | None = None,
    *,
    chat: Callable[[ManualClock], MemoryMessenger] = edited,
    clock: ManualClock | None = None,
    roles: dict[str, str] | None = None,
    fleet: tuple[Profile, ...] = FLEET,
    more: int = 0,
) -> AsyncIterator[Shown]:
    """Run a place whose clock on the wall shows the seconds of this test.

    Args:
        store: Its record.
        chat: Its messenger.
        clock: Its clock.
        roles: Of people, where they are others.
        fleet: Its robots.
        more: So many more viewers are known, at ``1000`` and so on.
    """
    place = Place(store, chat=chat, clock=clock, fleet=fleet)
    gateway = place.gateway
    gateway._parts = replace(
        gateway._parts, face=lambda ns: str((ns - START_WALL_NS) // 1_000_000_000)
    )
    people = (
        *(
            replace(seed, roles=((roles or {}).get(seed.name, seed.roles[0]),))
            for seed in gateway._settings.people
        ),
        *(
            ConfiguredPerson(f"P{n}", (Address("memory", str(1_000 + n)),), ("viewer",))
            for n in range(more)
        ),
    )
    rulebook = RoleRules(roles={**DEFAULT_ROLES, "narrow": ONE_ROBOT})
    gateway._settings = replace(gateway._settings, people=people, rulebook=rulebook)
    async with place.open():
        yield Shown(place)
