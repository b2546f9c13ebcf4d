"""After an interruption: what nobody saw the end of is unknown, said so, and never repeated."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.container.records import KeptAnswer, ReplyTo, read_answer, read_reply_to
from rosic.core import messages, records
from rosic.core.i18n import in_language, joined
from rosic.core.message import Outbound, SendPriority
from rosic.core.order import OrderEnding
from rosic.core.records import Concluded, Letter, Unfinished
from rosic.errors import StoreFault
from rosic.gateway.delivery.catch_up import SINGLY, together
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import Store
    from rosic.core.identity import CommandId
    from rosic.core.message import Chat
    from rosic.gateway.end_buttons import EndButtons
    from rosic.linker.linker import Linker

log = logging.getLogger("rosic.recovery")


class UnreportedOrders(NamedTuple):
    """Lives that one line gave, and where to say how they ended.

    Attributes:
        shown: Id of the message that shows them; empty when none is known.
    """

    origin: ReplyTo
    shown: str
    orders: list[Unfinished]


class Recovery:
    """Finishes what the last run could not (safety.md, crash recovery).

    Attributes:
        in_doubt: Orders whose end was unknown until `settle` wrote that.
    """

    def __init__(
        self,
        store: Store,
        linker: Linker,
        chat_sender: ChatSender,
        clock: Clock,
        messengers: Mapping[str, Messenger],
        ends: EndButtons,
    ) -> None:
        self._store = store
        self._linker = linker
        self._chat_sender = chat_sender
        self._clock = clock
        self._messengers = messengers
        self._ends = ends
        self.in_doubt: list[Unfinished] = []

    async def settle(self, unfinished: Iterable[Unfinished], exists: Callable[[str], bool]) -> int:
        """Hold robots in doubt, write the missing outcomes, tell what was not told.

        Args:
            unfinished: From the store, at start.
            exists: Whether a robot is still configured.

        Returns:
            How many lives were settled.
        """
        settled: list[Unfinished] = []
        for order in unfinished:
            if order.ending is None:
                if exists(order.robot):
                    await self._linker.hold_for_good(order.robot, self._linker.halt(order.robot))
                if not await self._conclude(order):
                    continue  # the next start finds it again
                self.in_doubt.append(order)
            settled.append(order)
        for told in self._together(settled):
            self._tell(told, exists)
        return len(settled)

    async def _conclude(self, order: Unfinished) -> bool:
        try:
            await self._store.write(
                Concluded(
                    cid=order.cid,
                    ending=OrderEnding.UNKNOWN.value,
                    at_ns=self._clock.wall_ns(),
                    letter=Letter(order.principal, b""),
                )
            )
        except StoreFault:
            log.exception("an interrupted order could not be settled")
            return False
        return True

    def _together(self, orders: Iterable[Unfinished]) -> Iterable[UnreportedOrders]:
        """Repeat answers; return the rest, robots that one line commanded together."""
        answers: dict[tuple[str, Chat], list[tuple[Unfinished, KeptAnswer]]] = {}
        cards: dict[tuple[str, ...] | CommandId, UnreportedOrders] = {}
        for order in orders:
            if order.claim is None:
                self._let_go(order)  # erased with its container: there is nobody to tell
                continue
            try:
                # A refusal names no robot; an order that was refused later does.
                if order.robot:
                    shown = (order.placed or b"").decode("utf-8", "replace")
                    _put_together(
                        cards, UnreportedOrders(read_reply_to(order.claim), shown, [order])
                    )
                else:
                    answer = read_answer(order.claim)
                    answers.setdefault((answer.messenger, answer.chat), []).append((order, answer))
            except msgspec.DecodeError:
                log.warning("a letter of the last run cannot be read")
                self._let_go(order)
        for found in answers.values():
            self._repeat_answers(found)
        return cards.values()

    def _let_go(self, order: Unfinished) -> None:
        """Nobody can be told of this any more; it takes no room in the record from now on."""
        self._store.note(records.Told(cid=order.cid, at_ns=self._clock.wall_ns()))

    def _repeat_answers(self, found: list[tuple[Unfinished, KeptAnswer]]) -> None:
        """Repeat what was answered in one chat, many answers as one."""
        name, chat = found[0][1].messenger, found[0][1].chat
        messenger = self._messengers.get(name)
        if messenger is None:
            return  # no longer configured; the record keeps it
        languages = self._chat_sender.languages
        if len(found) > SINGLY:
            note = together(messenger, chat, [order.cid for order, _ in found])
            catalogue = languages.of(found[-1][0].principal)
            text = in_language(messages.said_again(note.outbound.text), catalogue)
            note.outbound = msgspec.structs.replace(note.outbound, text=text)
            self._chat_sender.say(note)
            return
        for order, answer in found:
            text = in_language(messages.said_again(answer.text), languages.of(order.principal))
            outbound = Outbound(
                chat=chat, text=text, reply_to=answer.message, weight=SendPriority.OUTCOME
            )
            self._say(name, outbound, [order])

    def _tell(self, told: UnreportedOrders, exists: Callable[[str], bool]) -> None:
        origin, orders = told.origin, told.orders
        shown = [
            self._linker.profile(order.robot).shown if exists(order.robot) else order.robot
            for order in orders
        ]
        if len(orders) == 1 and origin.title.startswith(f"{shown[0]}:"):
            text = _ended(_named_once(origin.title), orders[0])
        else:  # in the order in which the line named them, which is that of their claims
            ends = [_ended(f"{name}:", order) for name, order in zip(shown, orders, strict=True)]
            text = joined("\n", [_named_once(origin.title), *ends])
        # Without a message to edit it may be the second time, unless the end was not known before.
        if not told.shown and any(order.ending is not None for order in orders):
            text = messages.said_again(text)
        reply_to = "" if told.shown else origin.message
        catalogue = self._chat_sender.languages.of(orders[0].principal)
        name, _, asked = origin.title.partition(": ")
        asked_of = orders[0].robot if len(orders) == 1 else name
        outbound = Outbound(
            chat=origin.chat,
            text=in_language(text, catalogue),
            reply_to=reply_to,
            buttons=self._ends[asked_of, asked, catalogue] if asked else (),
            weight=SendPriority.OUTCOME,
        )
        self._say(origin.messenger, outbound, orders, edit_of=told.shown)

    def _say(
        self,
        messenger_name: str,
        outbound: Outbound,
        orders: list[Unfinished],
        *,
        edit_of: str = "",
    ) -> None:
        messenger = self._messengers.get(messenger_name)
        if messenger is None:
            return  # no longer configured; the record keeps it
        first, *also = [order.cid for order in orders]
        self._chat_sender.say(
            OutgoingMessage(
                messenger, outbound, first, edit_of, tuple(also), to=orders[0].principal
            )
        )


def _named_once(title: str) -> str:
    """Return ``omni: move 2 m`` of ``omni: omni move 2 m``: most people begin with the name."""
    name, _, line = title.partition(": ")
    begins = line[: len(name) + 1].casefold() == f"{name} ".casefold()
    return f"{name}: {line[len(name) + 1 :]}" if begins else title


def _ended(title: str, order: Unfinished) -> str:
    if order.ending is None or (order.ending == OrderEnding.UNKNOWN.value and not order.words):
        return messages.unknown_after_restart(title)
    return joined("\n", (title, (order.words or b"").decode("utf-8", "replace")))


def _put_together(
    cards: dict[tuple[str, ...] | CommandId, UnreportedOrders], told: UnreportedOrders
) -> None:
    """Add an order to the message of its line, unless it is known to be in another message."""
    origin, shown, [order] = told
    where = origin.message or shown
    key: tuple[str, ...] | CommandId = order.cid
    if where:
        key = (origin.messenger, origin.chat.id, where, origin.title)
        if key in cards and shown and cards[key].shown not in ("", shown):
            key = (*key, shown)
    before = cards.setdefault(key, told)
    if before is not told:
        before.orders.append(order)
        cards[key] = before._replace(shown=before.shown or shown)
