"""Buttons that are no longer good disappear: nobody is left with one that only looks alive.

What was tapped is edited by its answer. This is for questions that nobody answered: when their
time is over they lose their buttons, all but the ones that are good for ever.
"""

from __future__ import annotations

import asyncio
from heapq import heappop, heappush
from itertools import count
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.authoriser.buttons import is_lasting, lifetime_of
from rosic.core.message import Weight

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.pipeline.telling import Note, Teller

# Each is a message that a platform counts; of a flood, the oldest stay as they are.
AT_MOST = 5_000
LOOK_EVERY_S = 1.0


class Expiring:
    """Remembers which messages show buttons, and until when."""

    def __init__(self, teller: Teller, clock: Clock) -> None:
        self._teller = teller
        self._clock = clock
        self._serial = count()
        self._due: list[tuple[int, int, str]] = []
        self._shown: dict[str, tuple[int, Note]] = {}
        self._watching: asyncio.Task[None] | None = None
        self._looks_ns = 0
        teller.on_buttons = self.shown

    def shown(self, note: Note, message: str) -> None:
        """A message was sent or edited, and shows these buttons now, or none any more."""
        where = f"{note.messenger.name}/{note.outbound.chat.id}/{message}"
        self._shown.pop(where, None)
        buttons = [button for row in note.outbound.buttons for button in row]
        mortal = [button for button in buttons if not is_lasting(button)]
        if not mortal or not note.messenger.edits:
            return
        if len(self._shown) >= AT_MOST:
            del self._shown[next(iter(self._shown))]
        serial = next(self._serial)
        self._shown[where] = (serial, replace(note, edit_of=message, cid=None, also=()))
        due_ns = self._clock.monotonic_ns() + min(map(lifetime_of, mortal))
        heappush(self._due, (due_ns, serial, where))
        if self._watching is not None and due_ns < self._looks_ns:
            self._watching.cancel()  # it sleeps until something that is due later
            self._watching = None
        if self._watching is None:
            self._looks_ns = due_ns
            self._watching = asyncio.create_task(self._watch())

    async def _watch(self) -> None:
        while self._due:
            now_ns = self._clock.monotonic_ns()
            while self._due and self._due[0][0] <= now_ns:
                _, serial, where = heappop(self._due)
                known = self._shown.get(where)
                if known is not None and known[0] == serial:
                    del self._shown[where]
                    self._strip(known[1])
            if self._due:
                wait_s = max(LOOK_EVERY_S, (self._due[0][0] - now_ns) / 1e9)
                self._looks_ns = now_ns + int(wait_s * 1e9)
                await self._clock.sleep(wait_s)
        self._watching = None

    def _strip(self, note: Note) -> None:
        left = tuple(
            kept
            for row in note.outbound.buttons
            if (kept := tuple(b for b in row if is_lasting(b)))
        )
        self._teller.say(
            replace(
                note,
                outbound=replace(note.outbound, buttons=left, weight=Weight.FEEDBACK),
                edit_only=True,
                then=None,
                landed=None,
            )
        )

    async def close(self) -> None:
        """Look no more."""
        if self._watching is not None:
            self._watching.cancel()
            await asyncio.gather(self._watching, return_exceptions=True)
