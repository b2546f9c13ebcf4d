"""After a button that is no good any more: the questions that still wait for an answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.authoriser.newcomers import PENDING_S
from rosic.core.saying import joined
from rosic.pipeline.people import words, words_asking
from rosic.pipeline.people.admitting import buttons_for

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Button
    from rosic.pipeline.people.admitting import Admitting
    from rosic.pipeline.people.petitioning import Petitioning
    from rosic.pipeline.reach import Reach

MOST = 4


class Reminding:
    """Shows an admin again what they were asked, with new buttons and the words to write."""

    def __init__(self, reach: Reach, admitting: Admitting, petitioning: Petitioning) -> None:
        self._reach = reach
        self._admitting = admitting
        self._petitioning = petitioning

    def remind(self, principal: PrincipalId) -> None:
        """Tell somebody what still waits for them, if anything does."""
        lines: list[str] = []
        rows: list[tuple[Button, ...]] = []
        for name, line, row in self._open(principal)[:MOST]:
            lines += [line, words_asking.answer_so(name)]
            rows.append(row)
        if rows:
            text = joined("\n", (words_asking.still_open(), *lines))
            self._reach.tell((principal,), text, tuple(rows), lifetime_s=PENDING_S, still=True)

    def _open(self, principal: PrincipalId) -> list[tuple[str, str, tuple[Button, ...]]]:
        found = [
            (a.name, words.waits(a.name, a.pending.given.words, a.words), buttons_for(a, a.name))
            for a in self._admitting.waiting(principal)
        ]
        return found + list(self._petitioning.questions(principal))
