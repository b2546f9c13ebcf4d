"""What an interpreter answers: read as what people write is, and believed no more than that."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.core.language import Do, LineContext, hears_cancel, hears_stop, understand
from rosic.core.message import Button
from rosic.errors import Refusal
from rosic.gateway.limit_clamping import ArgumentClamping

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.identity import Caller
    from rosic.core.message import Chat
    from rosic.gateway.agreement import ActPart, Agreements, ResolvedAct
    from rosic.gateway.components import Components

PROPOSALS_AT_MOST: Final = 3
LONGEST_PROPOSAL: Final = 120
LONGEST_LABEL: Final = 64


def lines_of(answer: str) -> Iterator[str]:
    """Yield the first lines of an answer that have a word in them."""
    found = (line.strip(" \t") for line in answer.splitlines())
    worded = (line for line in found if any(map(str.isalnum, line)))
    for _, line in zip(range(PROPOSALS_AT_MOST), worded, strict=False):
        yield line


class ProposalReader:
    """Makes buttons of those lines of an answer that somebody could have written themselves.

    A line counts if it is one order, to robots that this person sees, for skills that they may
    use, with each value within its bounds and theirs. What the button would do is worked out here
    and bound to it: at the tap it is worked out once more, and has to be the same (I16).
    """

    def __init__(self, rooms: Components, agreements: Agreements) -> None:
        self._rooms = rooms
        self._agreements = agreements
        self._clamping = ArgumentClamping(rooms.vocabularies, rooms.organiser)

    async def read(self, answer: str, caller: Caller, chat: Chat) -> tuple[Button, ...]:
        """Return what an answer proposes to somebody, best first; mostly one, three at most."""
        found: dict[bytes, Button] = {}
        for line in lines_of(answer):
            await asyncio.sleep(0)  # each line is a step
            act = self._act(line, caller, chat)
            if act is not None:
                button = Button(act.shown, act.command, act=act.digest)
                found.setdefault(act.digest, button)
        return tuple(found.values())

    def _act(self, text: str, caller: Caller, chat: Chat) -> ResolvedAct | None:
        """Return what a line comes to for somebody; None where it is nothing to propose."""
        # What is no letter at the beginning is a sign to a button that is tapped.
        if len(text) > LONGEST_PROPOSAL or not text.isprintable() or not text[:1].isalnum():
            return None
        rooms, who = self._rooms, caller.principal
        vocabulary = rooms.vocabulary
        known = vocabulary.known
        if hears_stop(text, known) is not None or hears_cancel(text, known) is not None:
            return None
        context = LineContext(rooms.container.selected(who, chat), rooms.organiser.visible(who))
        lines = understand(text, vocabulary, context, mends=False)
        line = lines[0]
        if len(lines) != 1 or not isinstance(line, Do):
            return None
        return self._resolved(line, caller)

    def _resolved(self, line: Do, caller: Caller) -> ResolvedAct | None:
        try:
            act = self._agreements.of(line, caller)
        except Refusal:
            return None
        if not all(self._is_bounded(caller, part) for part in act.parts):
            return None
        # What is longer would be cut off on a button, and a tap agrees to what is read.
        return act if act.parts and len(act.shown) <= LONGEST_LABEL else None

    def _is_bounded(self, caller: Caller, part: ActPart) -> bool:
        """Whether somebody may let a robot do this, so far: a text for it has no bounds at all."""
        compiled = self._rooms.vocabulary.compiled_skill(part.robot, part.skill)
        if compiled is None or (compiled.text and compiled.text.name in part.arguments):
            return False
        return self._clamping.may(caller.principal, part.robot, part.skill, part.arguments)
