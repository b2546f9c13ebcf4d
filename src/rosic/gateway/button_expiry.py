"""Buttons that are no longer good disappear: nobody is left with one that only looks alive.

What was tapped is edited by its answer. This is for questions that nobody answered: when their
time is over they lose their buttons, all but the ones that are good for ever. A question says then
that nothing was done, and it and a robot's menu keep one button that asks again: it moves nothing
and is bound to nobody, so that it is asked of whoever taps it, under what counts then (I16).
"""

from __future__ import annotations

import asyncio
from heapq import heappop, heappush
from itertools import count
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.authoriser.button_tokens import is_lasting, lifetime_of, open_button
from rosic.core.i18n import in_language, said
from rosic.core.message import AnswerState, SendPriority
from rosic.gateway.confirmation import SECONDED
from rosic.gateway.replies import ASK_FIRST, CONFIRMED, LEAVE, TRAIL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.authoriser.button_tokens import ButtonTokens
    from rosic.contracts.clock import Clock
    from rosic.core.message import Button
    from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage

# Each is a message that a platform counts; of a flood, the oldest stay as they are.
AT_MOST = 5_000
LOOK_EVERY_S = 1.0
TOO_LATE = said("Too late: nothing was done.")
SAY_AGAIN = said("Too late: nothing was done. Say it again.")
ASK_AGAIN, SHOW_AGAIN = said("Ask again"), said("Show again")


class ButtonExpiry:
    """Remembers which messages show buttons, and until when."""

    def __init__(self, chat_sender: ChatSender, clock: Clock, bound: ButtonTokens) -> None:
        self._chat_sender = chat_sender
        self._bound = bound
        self._clock = clock
        self._serial = count()
        self._due: list[tuple[int, int, str]] = []
        self._shown: dict[str, tuple[int, OutgoingMessage]] = {}
        self._watching: asyncio.Task[None] | None = None
        self._looks_ns = 0
        chat_sender.on_buttons.connect(self.shown)

    def shown(self, note: OutgoingMessage, message: str) -> None:
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

    def _strip(self, note: OutgoingMessage) -> None:
        left = tuple(
            kept
            for row in note.outbound.buttons
            if (kept := tuple(b for b in row if is_lasting(b)))
        )
        text, again = self._again(note)
        if again is not None:
            left = (*left, (again,))
        state = note.outbound.state
        outbound = replace(
            note.outbound,
            text=text,
            buttons=left,
            weight=SendPriority.FEEDBACK,
            state=AnswerState.NOT_DONE if state is AnswerState.ASKED else state,
        )
        self._chat_sender.say(
            replace(
                note,
                outbound=outbound,
                edit_only=True,
                then=None,
                landed=None,
            )
        )

    def _again(self, note: OutgoingMessage) -> tuple[str, Button | None]:
        """Return how a message reads without its buttons, and what asks again, if anything can.

        Where one of its buttons was used, something may have been done: then nothing is said.
        """
        text = note.outbound.text
        gone = [b for row in note.outbound.buttons for b in row if not is_lasting(b)]
        asked = [self._bound.asked(button.nonce) for button in gone]
        who = asked[0]
        if who is None or None in asked:
            return text, None
        catalogue = self._chat_sender.languages.of(who)
        if not any(button.command == LEAVE for button in gone):
            menu = _menu(gone)
            return text, open_button(in_language(SHOW_AGAIN, catalogue), menu)
        if any(button.command.startswith(f"{CONFIRMED}{SECONDED}") for button in gone):
            return text, None  # asked of others as well, who may have agreed
        again = open_button(in_language(ASK_AGAIN, catalogue), _question(gone))
        late = in_language(SAY_AGAIN if again is None else TOO_LATE, catalogue)
        return f"{text}\n{late}", again

    async def close(self) -> None:
        """Look no more."""
        if self._watching is not None:
            self._watching.cancel()
            await asyncio.gather(self._watching, return_exceptions=True)


def _menu(gone: Sequence[Button]) -> str:
    """Return what shows the menu of a robot again, if these were of one; else nothing."""
    ways = {button.command.rpartition(TRAIL)[2] for button in gone if TRAIL in button.command}
    return ways.pop() if len(ways) == 1 else ""


def _question(gone: Sequence[Button]) -> str:
    """Return what asks again whether a robot is meant to do something; else nothing."""
    meant = [button.command[1:] for button in gone if button.command.startswith(CONFIRMED)]
    return f"{ASK_FIRST}{meant[0]}" if len(meant) == 1 else ""
