"""The paper's five scenarios over XMPP: everybody in a private chat, on a real server."""

from __future__ import annotations

import asyncio
import re
import time
from contextlib import AsyncExitStack
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio

from rosic.testing.ros2.graph import why_missing
from tests.journeys.chats import ShownMessage
from tests.journeys.running import WITHIN_S, Launcher
from tests.journeys.scenarios import ScenarioTests, scenarios
from tests.journeys.scenes import scenes
from tests.real.xmpp.person import Person
from tests.real.xmpp.prosody import LOOPBACK

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Sequence

    from tests.real.xmpp.person import Seen
    from tests.real.xmpp.prosody import Prosody

pytestmark = [
    pytest.mark.limit(480),
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]
BUTTON = re.compile(r"(?<!\S)(\d+)\. (.+?)(?= {3}\d+\. |$)", re.MULTILINE)
CONFIG = """\
kind = "xmpp"
user = "{user}"
password = "{password}"
host = "{host}"
port = {port}
"""


class XmppChats:
    """People with a client of slixmpp each, who type the numbers of buttons."""

    def __init__(self, server: Prosody, stack: AsyncExitStack) -> None:
        self._server, self._stack = server, stack
        self._robots = server.create_account("robots")
        self._people: dict[str, Person] = {}
        user, password = self._robots
        self.messenger = CONFIG.format(
            user=user, password=password, host=LOOPBACK, port=server.port
        )

    async def open(self, people: Sequence[str]) -> None:
        for number, name in enumerate(people):
            account = self._server.create_account(f"person{number}n")
            self._people[name] = Person(self._server, account)

    def address(self, name: str) -> str:
        return f"xmpp:{self._people[name].user}"

    async def meet(self) -> None:
        for person in self._people.values():
            await self._stack.enter_async_context(person)

    async def say(self, name: str, text: str) -> str:
        return self._people[name].say(self._robots.user, text)

    async def messages(self, name: str) -> list[ShownMessage]:
        said = list(self._people[name].seen.values())
        above = {seen.message: before for before, seen in pairwise(said)}
        return [_shown(seen, above.get(seen.message), place) for place, seen in enumerate(said)]

    async def tap(self, name: str, message: ShownMessage, label: str) -> None:
        found = BUTTON.findall(self._people[name].seen[message.id].text)
        number = next(number for number, shown in found if shown == label)
        self._people[name].say(self._robots.user, number)

    async def until(self, name: str, look: Callable[[], Any]) -> Any:  # noqa: ANN401
        end_s = time.monotonic() + WITHIN_S
        while True:
            found = look()
            found = await found if asyncio.iscoroutine(found) else found
            if found or time.monotonic() > end_s:
                return found or None
            await self._people[name].wait()

    async def settle(self) -> None:
        for person in self._people.values():
            assert person.client.is_connected()


def _shown(seen: Seen, above: Seen | None, place: int) -> ShownMessage:
    """Return a message; what stands above words is the file that they are of."""
    text, _, below = seen.text.rpartition("\n\n")
    # What looks like a number elsewhere stands in a sentence.
    numbered = BUTTON.findall(below) if BUTTON.match(below) else []
    return ShownMessage(
        id=seen.message,
        text=text if numbered else seen.text,
        reply_to=seen.answers,
        place=place,
        labels=tuple(label for _, label in numbered),
        picture=above is not None and bool(above.url),
    )


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def acts(
    prosody: Prosody, tmp_path_factory: pytest.TempPathFactory, launcher: Launcher
) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin every scenario; a test waits for the end of one."""
    folder = tmp_path_factory.mktemp("scenes")
    async with (
        AsyncExitStack() as stack,
        scenes(folder, launcher, XmppChats(prosody, stack)) as here,
        scenarios(here) as begun,
    ):
        yield begun


class TestXmpp(ScenarioTests):
    """By XMPP."""
