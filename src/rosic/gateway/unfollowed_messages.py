"""Messages that are not followed (I17): edited, forwarded, posted by a channel, or given up.

Whoever edits a command into an old message is told once that it does nothing, and whoever sent what
its messenger gave up is told how much that was. A code that a group
reads in any of them is burnt all the same: that gives nobody anything.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import said, said_n
from rosic.core.language import Answered, Misunderstood
from rosic.core.message import Button, ChatKind, MessageValidity
from rosic.errors import Refusal
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.language import LanguageReader
    from rosic.core.message import Inbound
    from rosic.gateway.components import Components
    from rosic.gateway.replies import Replies

NOT_FOLLOWED: Final = said(
    "I do not follow messages that were changed, so this change did nothing. Tap to send it as it "
    "reads now."
)
KEPT: Final = 1_000
"""Messages about which something was said: each once, however often it is changed."""
OFFERED_LETTERS: Final = 60
COUNTED_S: Final = 0.5
"""For so long what is given up is counted before a chat is told of it."""

log = logging.getLogger("rosic.pipeline")


def given_up(messages: int) -> str:
    """Say that so many messages are not followed."""
    return said_n(
        "The record cannot keep up, so I gave up {n} message of yours. Nothing was done for it. "
        "Stop still works.",
        "The record cannot keep up, so I gave up {n} messages of yours. Nothing was done for them. "
        "Stop still works.",
        messages,
    )


class UnfollowedMessages:
    """Answers whoever changes a message into a command, once for each message.

    Args:
        rooms: Who knows people, and what they may see.
        reader: What a text says.
        replies: Says it.
        addressed: Whether a message is meant for ROSIC at all.
        showed_a_code: Burns a code that a group has read, and says so; whether there was one.
        clock: Waits.
    """

    def __init__(
        self,
        rooms: Components,
        reader: LanguageReader,
        replies: Replies,
        addressed: Callable[[Inbound], bool],
        showed_a_code: Callable[[Messenger, Inbound], Awaitable[bool]],
        clock: Clock,
    ) -> None:
        self._rooms = rooms
        self._reader = reader
        self._replies = replies
        self._addressed = addressed
        self._showed_a_code = showed_a_code
        self._answered: OrderedDict[tuple[str, str, str], None] = OrderedDict()
        self._clock = clock
        self._given_up: dict[tuple[str, str, str], int] = {}
        self._telling: BackgroundTasks[None] = BackgroundTasks()

    async def take(self, messenger: Messenger, inbound: Inbound) -> None:
        """Take a message that is not followed, or was a stop. Never raises."""
        private = inbound.chat.kind is ChatKind.PRIVATE
        try:
            burnt = not private and await self._showed_a_code(messenger, inbound)
        except Refusal as refusal:
            log.warning("a code that a group has read could not be burnt: %s", refusal)
        except Exception:
            log.exception("a message that is not followed could not be looked at")
        else:
            if inbound.standing is MessageValidity.DROPPED:
                self._count(messenger, inbound)
            elif not burnt:
                self.answer(messenger, inbound)

    def _count(self, messenger: Messenger, inbound: Inbound) -> None:
        """Tell somebody known, in one sentence for all of it, that it is not followed."""
        directory, who = self._rooms.authoriser.directory, inbound.sender
        if directory.at(who) is None or not self._addressed(inbound):
            return
        where = (messenger.name, inbound.chat.id, who.account)
        before = self._given_up.get(where, 0)
        self._given_up[where] = before + 1
        if not before:
            self._telling.begin(self._tell(messenger, inbound, where))

    async def _tell(
        self, messenger: Messenger, inbound: Inbound, where: tuple[str, str, str]
    ) -> None:
        await self._clock.sleep(COUNTED_S)
        self._replies.say(messenger, inbound, given_up(self._given_up.pop(where)))

    async def close(self) -> None:
        """Tell nobody any more."""
        for task in self._telling:
            task.cancel()
        await asyncio.gather(*self._telling, return_exceptions=True)

    def answer(self, messenger: Messenger, inbound: Inbound) -> None:
        """Say, to somebody known, that a changed message does nothing. Never raises a refusal."""
        where = (messenger.name, inbound.chat.id, inbound.message)
        backlog = inbound.listening_since_ns > inbound.received_ns
        if inbound.standing is not MessageValidity.EDITED or backlog or where in self._answered:
            return
        if not self._addressed(inbound) or self._reader.urgent(inbound.text) is not None:
            return  # a stop or a cancel in it was obeyed
        try:
            caller = self._rooms.authoriser.identify(inbound)
            self._rooms.organiser.charge(caller)
        except Refusal:
            return
        visible = self._rooms.organiser.visible(caller.principal)
        selected = self._rooms.container.selected(caller.principal, inbound.chat)
        lines = self._reader.lines(inbound.text, selected, visible)
        if all(isinstance(line, Misunderstood | Answered) for line in lines):
            return
        self._answered[where] = None
        if len(self._answered) > KEPT:
            self._answered.popitem(last=False)
        text = inbound.text.strip()
        label = text if len(text) <= OFFERED_LETTERS else f"{text[:OFFERED_LETTERS]}..."
        row = (Button(label, text),)
        self._replies.offer(messenger, inbound, caller, Reply(NOT_FOLLOWED, (row,)))
