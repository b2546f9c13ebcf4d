"""The newcomer's seat: this terminal, from the moment at which it is their turn."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.messengers.terminal import TerminalMessenger
from rosic.messengers.terminal.messenger import own_locale

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.core.message import Outbound


class UserTerminal(TerminalMessenger):
    """A terminal that neither asks nor shows anything before somebody sits down.

    Attributes:
        taken: Set it, and they may type. What they are told before is shown to the play's person.
    """

    def __init__(self, *, clock: Clock, plain: bool) -> None:
        super().__init__("seat", clock=clock, plain=plain, locale=own_locale())
        self.taken = asyncio.Event()
        self._unseen = 0

    async def run(self, receive: Receive) -> None:
        """Listen from then on."""
        await self.taken.wait()
        await super().run(receive)

    async def send(self, outbound: Outbound) -> str:
        """Show it, once there is somebody to see it."""
        if self.taken.is_set():
            return await super().send(outbound)
        self._unseen += 1
        return f"unseen-{self._unseen}"
