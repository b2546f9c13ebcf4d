"""A thumb beside an alarm: whoever puts it there has seen it, within their own rights."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import reactions_of
from rosic.errors import MessengerFault
from rosic.features.alerts import messages as words

if TYPE_CHECKING:
    from rosic.authoriser.directory import Directory
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Reaction
    from rosic.features.alerts.evaluator import AlertEvaluator
    from rosic.features.alerts.following import ActiveRule
    from rosic.gateway.delivery.notifier import Notifier

SEEN: Final = frozenset({"👍", "👌", "👀", "🫡", "🆒"})
"""Any other says something else, or nothing: a thumb down is no acknowledgement."""
NOTED: Final = "👌"
_COLOURED: Final = "\ufe0f"

log = logging.getLogger("rosic.alerts")


class AlertReactions:
    """Follows reactions. They are asked of nobody, so what means nothing is met with silence."""

    def __init__(self, alerting: AlertEvaluator, directory: Directory, reach: Notifier) -> None:
        self._alerting = alerting
        self._directory = directory
        self._reach = reach
        self._tasks: set[asyncio.Task[None]] = set()

    def reacted(self, messenger: Messenger, reaction: Reaction) -> None:
        """Take an emoji beside an alarm that is open for what it says. Returns at once."""
        if SEEN.isdisjoint(emoji.replace(_COLOURED, "") for emoji in reaction.emoji):
            return
        found = self._directory.at(reaction.who) if reaction.who is not None else None
        placed, circles = self._alerting.telling.placed, self._alerting.circles
        told = placed.of(messenger, reaction.chat, reaction.message)
        if found is None or not told:
            return
        who = found[0].id
        meant = [f for f in self._alerting.meant(told) if circles.may_hear(who, f.rule.robot)]
        if not meant:
            return
        # Answered once, whatever else is put there: nobody is to be talked at for their thumbs.
        self._alerting.write(placed.answered(messenger, reaction.chat, reaction.message))
        theirs = [f for f in meant if circles.may_acknowledge(who, f.rule.robot)]
        fresh = [f for f in theirs if self._alerting.seen(f, who)]
        if not theirs:
            self._reach.tell((who,), words.may_not(self._alerting.shown(meant[0].rule)))
        elif fresh:
            self._confirm(messenger, reaction, who, fresh)
        else:
            self._reach.tell((who,), self._alerting.seen_before(theirs[0]))

    def _confirm(
        self, messenger: Messenger, reaction: Reaction, who: PrincipalId, fresh: list[ActiveRule]
    ) -> None:
        text = self._alerting.noted(fresh)
        task = asyncio.create_task(self._nod(messenger, reaction, who, text))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _nod(
        self, messenger: Messenger, reaction: Reaction, who: PrincipalId, otherwise: str
    ) -> None:
        """Answer with a sign as quick as theirs; in words where that cannot be."""
        react = reactions_of(messenger)
        try:
            if react is not None:
                await react(reaction.chat, reaction.message, NOTED)
                return
        except MessengerFault as fault:
            log.info("said in words, as a reaction was not taken: %s", fault)
        self._reach.tell((who,), otherwise)

    async def close(self) -> None:
        """Follow nothing any more."""
        for task in self._tasks:
            task.cancel()
