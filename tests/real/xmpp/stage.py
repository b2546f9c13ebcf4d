"""XMPP with the people on its other side, for the rules of all messengers."""

from __future__ import annotations

import re
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any

import httpx

from rosic.core.message import Chat, MessageValidity
from rosic.messengers.xmpp import xmpp_messenger
from rosic.system import SystemClock
from tests.real.xmpp.person import Person
from tests.real.xmpp.prosody import LOOPBACK

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.messenger import Messenger
    from rosic.testing.messengers import SeenMessage
    from tests.real.xmpp.prosody import Account, Prosody


class XmppStage:
    """Two people in private chats with the account of the robots, on one server."""

    patience_s = 60.0
    keeps = True
    taps = True
    unusual: tuple[MessageValidity, ...] = (MessageValidity.EDITED,)

    def __init__(self, server: Prosody, robots: Account, persons: dict[str, Person]) -> None:
        self.server, self.robots, self.persons = server, robots, persons
        self.people: tuple[str, ...] = tuple(persons)
        self.messenger: Messenger = xmpp_messenger("lab", table(server, robots), SystemClock())

    def chat(self, person: str) -> Chat:
        return Chat("xmpp", self.persons[person].user)

    async def write(self, person: str, text: str) -> None:
        self.persons[person].say(self.robots.user, text)

    async def write_unusually(self, person: str, text: str, standing: MessageValidity) -> None:
        assert standing is MessageValidity.EDITED
        written = self.persons[person].say(self.robots.user, "hello")
        self.persons[person].correct(self.robots.user, written, text)

    async def tap(self, person: str, message: str, label: str) -> None:
        who = self.persons[person]
        await who.until(lambda: message in who.seen)
        found = re.search(rf"(\d+)\. {re.escape(label)}", who.seen[message].text)
        assert found is not None, who.seen[message]
        who.say(self.robots.user, found[1])

    async def screen(self, person: str) -> list[SeenMessage]:
        return await self.persons[person].screen(self.robots.user)

    async def files(self, person: str) -> list[tuple[str, bytes]]:
        return await self.persons[person].files(self.robots.user)

    async def enclose(self, person: str, name: str, content: bytes) -> None:
        await self.persons[person].send_file(self.robots.user, name, content)

    async def pinned(self, person: str) -> list[str]:
        raise AssertionError(f"nothing can be pinned for {person}")

    async def unconfirmed(self) -> int:
        user = self.robots.user.partition("@")[0]
        async with httpx.AsyncClient(trust_env=False) as http:
            answer = await http.get(f"http://{LOOPBACK}:{self.server.http}/unconfirmed/{user}")
        return int(answer.text)

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        self.server.stop()
        yield
        self.server.start()


def table(server: Prosody, robots: Account, **more: object) -> dict[str, Any]:
    """Return the table of a messenger at that server."""
    where = {"host": LOOPBACK, "port": server.port}
    return {"user": robots.user, "password": robots.password, **where, **more}


@asynccontextmanager
async def xmpp_stage(server: Prosody) -> AsyncIterator[XmppStage]:
    """Sign two people in, and make a messenger."""
    async with AsyncExitStack() as stack:
        persons = {name: Person(server, server.create_account(name)) for name in ("ada", "bob")}
        for person in persons.values():
            await stack.enter_async_context(person)
        yield XmppStage(server, server.create_account("robots"), persons)
