"""A whole gateway whose interpreter is a scripted endpoint, reached over real HTTP."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import TYPE_CHECKING

from rosic.features.interpreter import InterpreterFeature
from tests.gateway.place import ADA, Place
from tests.interpreters.scripted import saying
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.contracts.interpreter import Interpreter
    from rosic.contracts.store import Store
    from rosic.core.message import Button
    from rosic.core.robot.profile import Profile
    from tests.interpreters.scripted import Call, ScriptedEndpoint

GOOD = "omni move forward 0.5 m"
LABEL = "omni: move, 0.50 m forward"
UNREAD = "would you kindly shuffle a smidgen ahead"
TOLD = "What I do not understand I can show"
PROPOSED = "An interpreter takes that for one of these"
TURN_S = 0.002
LATER_S = 60.0
"""By then anybody may ask again, and no button of before is good any more."""


class Interpreted(Place):
    """A place with an interpreter."""

    def __init__(
        self,
        interpreter: Interpreter,
        store: Store | None = None,
        *,
        fleet: tuple[Profile, ...] | None = None,
    ) -> None:
        self.interpreter = interpreter
        if fleet is None:
            super().__init__(store)
        else:
            super().__init__(store, fleet=fleet)

    @property
    def feature(self) -> InterpreterFeature:
        """The feature that asks."""
        return self.gateway.features.get(InterpreterFeature)

    @property
    def counts(self) -> dict[str, int]:
        """What came of asking."""
        return dict(self.feature.client.counts)

    async def answered(self) -> None:
        """Wait until nothing is asked any more, and everything that follows has happened."""
        until = time.monotonic() + 60 * pace()
        while not self.feature.quiet:
            assert time.monotonic() < until, "the interpreter is asked for ever"
            await asyncio.sleep(TURN_S)
        await self.quiet()

    async def allow(self, account: str = ADA) -> None:
        """Have somebody told of the interpreter, so that the next line may be shown to it."""
        await self.say("hum hum hum", account=account, chat=account)
        await self.answered()
        await self.clock.advance(LATER_S)

    async def ask(self, text: str, account: str = ADA, **how: object) -> list[str]:
        """Say something; return what was told because of it, one text for each message."""
        before = len(self.chat.told)
        await self.say(text, account=account, **{"chat": account, **how})
        await self.answered()
        return [told.outbound.text for told in list(self.chat.told)[before:]]

    def proposals(self) -> list[tuple[Button, str]]:
        """Return the buttons of the newest message that proposes something, and its id."""
        for told in reversed(self.chat.told):
            shown = self.chat.shown(told.message)
            if shown.text.startswith(PROPOSED):
                rows = [button for row in shown.buttons for button in row]
                return [(button, told.message) for button in rows if button.act]
        return []

    def all_acted(self) -> int:
        """Return how often any robot acted."""
        return sum(len(self.robot(name).acted) for name in self.gateway.robots)


def silent(call: Call) -> None:
    """Say nothing for as long as the server runs."""
    call.ended.wait()


class Held:
    """Answers well, once it is let."""

    def __init__(self) -> None:
        self.let = threading.Event()

    def __call__(self, call: Call) -> None:
        """Wait, then answer."""
        self.let.wait()
        saying(GOOD)(call)


async def called(endpoint: ScriptedEndpoint, count: int) -> None:
    until = time.monotonic() + 60 * pace()
    while len(endpoint.calls) < count:
        assert time.monotonic() < until, "nobody calls"
        await asyncio.sleep(0.005)
