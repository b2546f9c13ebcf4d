"""The paper's five scenarios over Matrix: everybody in an encrypted room of a real homeserver."""

from __future__ import annotations

import asyncio
import re
import time
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio

from rosic.messengers.matrix.signs import KEYS
from rosic.testing.ros2.graph import why_missing
from tests.journeys.chats import ShownMessage
from tests.journeys.running import WITHIN_S, Launcher
from tests.journeys.scenarios import ScenarioTests, scenarios
from tests.journeys.scenes import scenes
from tests.real.matrix.person import Person

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Coroutine, Iterable, Iterator, Sequence
    from pathlib import Path

    from tests.real.matrix.person import Seen
    from tests.real.matrix.synapse import Synapse

pytestmark = [
    pytest.mark.limit(600),
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]
AT_ONCE = 4
BUTTON = re.compile(r"(?<!\S)(\d+)\. (.+?)(?= {3}\d+\. |$)", re.MULTILINE)
CONFIG = """\
kind = "matrix"
homeserver = "{url}"
user = "{user}"
password = "{password}"
folder = "{folder}"
require_verified = false
"""


class MatrixChats:
    """People with a client of matrix-nio each, in a room with the gateway."""

    def __init__(self, synapse: Synapse, folder: Path, stack: AsyncExitStack) -> None:
        self._synapse = synapse
        self._folder = folder
        self._stack = stack
        self._robots = synapse.create_account("robots")
        self._people: dict[str, Person] = {}
        self._rooms: dict[str, str] = {}
        robots = self._robots
        self.messenger = CONFIG.format(
            url=robots.url, user=robots.user, password=robots.password, folder=folder / "matrix"
        )

    async def open(self, people: Sequence[str]) -> None:
        async def one(number: int, name: str) -> None:
            account = self._synapse.create_account(f"person{number}")
            person = Person(account, self._folder / f"person{number}")
            self._people[name] = await self._stack.enter_async_context(person)

        await _few_at_once(one(number, name) for number, name in enumerate(people))

    def address(self, name: str) -> str:
        return f"matrix:{self._people[name].user}"

    async def meet(self) -> None:
        async def one(name: str, person: Person) -> None:
            room = await person.create_room(self._robots.user, direct=True)
            known = person.client.rooms[room]
            await person.until(
                lambda: self._robots.user in known.users and not known.invited_users, WITHIN_S
            )
            self._rooms[name] = room

        await _few_at_once(one(name, person) for name, person in self._people.items())

    async def say(self, name: str, text: str) -> str:
        return await self._people[name].say(self._rooms[name], text)

    async def messages(self, name: str) -> list[ShownMessage]:
        said = [one for one in self._timeline(name) if one.sender == self._robots.user]
        assert all(one.encrypted for one in said)
        return [_shown(seen, place) for place, seen in enumerate(said)]

    def _timeline(self, name: str) -> Iterable[Seen]:
        return self._people[name].timeline(self._rooms[name]).messages.values()

    async def tap(self, name: str, message: ShownMessage, label: str) -> None:
        number = message.labels.index(label)
        await self._people[name].react(self._rooms[name], message.id, KEYS[number])

    async def until(self, name: str, look: Callable[[], Any]) -> Any:  # noqa: ANN401
        end_s = time.monotonic() + WITHIN_S
        while True:
            found = look()
            found = await found if asyncio.iscoroutine(found) else found
            if found or time.monotonic() > end_s:
                return found or None
            await self._people[name].wait()

    async def settle(self) -> None:
        for name, person in self._people.items():
            assert not person.timeline(self._rooms[name]).unreadable


def _shown(seen: Seen, place: int) -> ShownMessage:
    text, _, below = seen.text.rpartition("\n\n")
    numbered = BUTTON.findall(below)
    if [number for number, _ in numbered] != [str(n + 1) for n in range(len(numbered))]:
        numbered = []  # what looks like one stands in a sentence
    return ShownMessage(
        id=seen.id,
        text=text if numbered else seen.text,
        reply_to=seen.reply_to,
        place=place,
        labels=tuple(label for _, label in numbered),
        picture=seen.kind == "m.image",
    )


async def _few_at_once(all_of_them: Iterable[Coroutine[object, object, None]]) -> None:
    places = asyncio.Semaphore(AT_ONCE)

    async def one(act: Coroutine[object, object, None]) -> None:
        async with places:
            await act

    await asyncio.gather(*map(one, all_of_them))


@asynccontextmanager
async def matrix_chats(synapse: Synapse, folder: Path) -> AsyncIterator[MatrixChats]:
    async with AsyncExitStack() as stack:
        yield MatrixChats(synapse, folder, stack)


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def acts(
    synapse: Synapse, tmp_path_factory: pytest.TempPathFactory, launcher: Launcher
) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin every scenario; a test waits for the end of one."""
    folder = tmp_path_factory.mktemp("scenes")
    async with (
        matrix_chats(synapse, folder) as chats,
        scenes(folder, launcher, chats) as here,
        scenarios(here) as begun,
    ):
        yield begun


class TestMatrix(ScenarioTests):
    """By Matrix."""
