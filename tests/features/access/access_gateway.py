"""A whole gateway with two admins, somebody who gives rights on one robot, and private chats."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.gateway.place import ADA, BO, VI, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.core.message import Button, Outbound
    from rosic.stores.memory import MemoryStore
    from rosic.testing.clock import ManualClock

EVE, TIM = "4", "5"
TUTOR = Role(scopes=("kuka1:*", "kuka1:grant"), priority=15)
JUNIOR = Role(scopes=("*:move",), limits=("distance <= 1 m",), priority=5)


class House(Place):
    """A place with a second admin, Eve, and Tim, who gives rights on kuka1 alone."""

    def __init__(
        self,
        store: MemoryStore | None = None,
        clock: ManualClock | None = None,
        roles: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(store, clock=clock)
        more = (
            ConfiguredPerson("Eve", (Address("memory", EVE),), ("admin",)),
            ConfiguredPerson("Tim", (Address("memory", TIM),), ("tutor",)),
        )
        people = tuple(
            replace(seed, roles=((roles or {}).get(seed.name, seed.roles[0]),))
            for seed in (*self._settings.people, *more)
        )
        rulebook = RoleRules(
            roles={
                **DEFAULT_ROLES,
                "tutor": TUTOR,
                "junior": JUNIOR,
                "registrar": Role(scopes=("fleet:grant",)),
            }
        )
        self.gateway._settings = replace(self._settings, people=people, rulebook=rulebook)

    async def line(self, account: str, text: str) -> str:
        """Say something in private; return what was told in that chat because of it."""
        before = len(self.chat.told)
        await self.say(text, account=account, chat=account)
        return self.told(account, before)

    def told(self, chat: str, before: int = 0) -> str:
        news = list(self.chat.told)[before:]
        return "\n".join(t.outbound.text for t in news if t.outbound.chat.id == chat)

    def newest(self, chat: str) -> Outbound:
        return next(t.outbound for t in reversed(self.chat.told) if t.outbound.chat.id == chat)

    def labels(self, chat: str) -> list[str]:
        return [button.label for row in self.newest(chat).buttons for button in row]

    def shown(self, chat: str, label: str) -> tuple[Button, str]:
        for told in reversed(self.chat.told):
            if told.outbound.chat.id == chat:
                for button in (b for row in told.outbound.buttons for b in row):
                    if button.label == label:
                        return button, told.message
        raise AssertionError(f"no button {label!r} in the chat {chat}")

    async def press(self, account: str, label: str) -> str:
        """Tap the newest button of a label in somebody's chat; return what was told there."""
        button, under = self.shown(account, label)
        return await self.press_again(account, button, under)

    async def press_again(self, account: str, button: Button, under: str) -> str:
        before = len(self.chat.told)
        await self.tap(button, under, account)
        return self.told(account, before)

    async def pass_s(self, seconds: float) -> None:
        await self.clock.advance(seconds)
        await self.quiet()


@asynccontextmanager
async def house(**roles: str) -> AsyncIterator[House]:
    place = House(roles=roles)
    async with place.open():
        yield place


__all__ = ["ADA", "BO", "EVE", "TIM", "VI", "House", "house"]
