"""What a chat can be told no more: its author is told in private, and failing that the admins.

A bot is put out of a group, a group is dissolved, a person blocks the bot. What was to be said
there and matters (how an order ended, an alarm) is said once where it can still be read, then no
further: nothing is tried for ever, and nothing goes round in circles.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from rosic.core.message import Weight
from rosic.core.saying import said
from rosic.pipeline.cards import Card

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.identity import PrincipalId
    from rosic.pipeline.reach import Reach
    from rosic.pipeline.voice import Item

TO_ADMINS: Final = 2
"""How often a text that has come to the admins has been passed on."""

log = logging.getLogger("rosic.telling")


class Elsewhere:
    """Passes on what a chat did not take."""

    def __init__(
        self,
        reach: Reach,
        admins: Callable[[], Iterable[PrincipalId]],
        name: Callable[[PrincipalId], str],
    ) -> None:
        self._reach = reach
        self._admins = admins
        self._name = name

    def gone(self, item: Item) -> None:
        """Tell it elsewhere; it counts as told where it was to be said."""
        text = _what_matters(item)
        if not text:
            return
        to, hops = (item.principal, 0) if isinstance(item, Card) else (item.to, item.hops)
        besides = item.where if isinstance(item, Card) else item.where_to
        if to and not hops:
            here = said("I cannot speak any more where you asked this, so here:\n{text}", text=text)
            if self._reach.pass_on((to,), here, besides, hops=1):
                return
        if hops >= TO_ADMINS or not self._tell_admins(to, text, besides):
            log.error("nobody can be told any more what a chat did not take")

    def _tell_admins(self, to: PrincipalId, text: str, besides: tuple[str, str]) -> int:
        if to:
            sentence = said(
                "I cannot reach {name} any more. They were to be told:\n{text}",
                name=self._name(to),
                text=text,
            )
        else:
            sentence = said(
                "I cannot speak any more in a chat that was to be told:\n{text}", text=text
            )
        others = [admin for admin in self._admins() if admin != to]
        return self._reach.pass_on(others, sentence, besides, hops=TO_ADMINS)


def _what_matters(item: Item) -> str:
    """Return what somebody waits for; empty for what only shows how things go."""
    if isinstance(item, Card):
        return item.text(endings=True) if item.untold else ""
    weighs = bool(item.to) or item.outbound.weight <= Weight.ALARM
    return item.outbound.text if weighs else ""
