"""What a chat can be told no more: its author is told in private, and failing that the admins.

A bot is put out of a group, a group is dissolved, a person blocks the bot. What was to be said
there and matters (how an order ended, an alarm) is said once where it can still be read, then no
further: nothing is tried for ever, and nothing goes round in circles.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.message import Weight
from rosic.errors import ChatNotBegun
from rosic.gateway.order_status import OrderMessage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.identity import PrincipalId
    from rosic.errors import ChatGone
    from rosic.gateway.delivery.chat_queue import Item
    from rosic.gateway.delivery.notifier import Notifier

TO_ADMINS: Final = 2
"""How often a text that has come to the admins has been passed on."""

log = logging.getLogger("rosic.telling")


class UndeliverableHandler:
    """Passes on what a chat did not take."""

    def __init__(
        self,
        reach: Notifier,
        admins: Callable[[], Iterable[PrincipalId]],
        name: Callable[[PrincipalId], str],
    ) -> None:
        self._reach = reach
        self._admins = admins
        self._name = name
        self._not_begun: set[tuple[str, str]] = set()

    def gone(self, item: Item, why: ChatGone) -> None:
        """Tell it elsewhere; it counts as told where it was to be said."""
        not_begun = isinstance(why, ChatNotBegun)
        told = self._pass_on(item, not_begun=not_begun)
        if not_begun:
            self._log_not_begun(item, again=not told)
        elif not told:
            log.error("nobody can be told any more what a chat did not take")

    def _pass_on(self, item: Item, *, not_begun: bool) -> bool:
        """Return whether somebody is told, or nobody has to be."""
        text = _what_matters(item)
        if not text:
            return True
        to, hops = (item.principal, 0) if isinstance(item, OrderMessage) else (item.to, item.hops)
        besides = _where(item)
        if to and not hops:
            here = said("I cannot speak any more where you asked this, so here:\n{text}", text=text)
            if self._reach.pass_on((to,), text if not_begun else here, besides, hops=1):
                return True
        return hops < TO_ADMINS and self._tell_admins(to, text, besides, not_begun=not_begun) > 0

    def _log_not_begun(self, item: Item, *, again: bool) -> None:
        """Say what has to be done before anything is told there: once, and when it mattered."""
        messenger, where = item.messenger, _where(item)
        if where in self._not_begun and not again:
            return
        self._not_begun.add(where)
        bot = getattr(messenger, "bot_name", "")
        us = f"@{bot}" if bot else messenger.name
        who = item.principal if isinstance(item, OrderMessage) else item.to
        name = self._name(who) if who else f"{messenger.platform}:{where[1]}"
        log.warning("%s has not written to %s yet: nothing is told there until then", name, us)

    def _tell_admins(
        self, to: PrincipalId, text: str, besides: tuple[str, str], *, not_begun: bool
    ) -> int:
        if to and not_begun:
            sentence = said(
                "{name} has not written to me yet, so I cannot reach them."
                " They were to be told:\n{text}",
                name=self._name(to),
                text=text,
            )
        elif to:
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
    if isinstance(item, OrderMessage):
        return item.text(endings=True) if item.untold else ""
    weighs = bool(item.to) or item.outbound.weight <= Weight.ALARM
    return item.outbound.text if weighs else ""


def _where(item: Item) -> tuple[str, str]:
    return item.where if isinstance(item, OrderMessage) else item.where_to
