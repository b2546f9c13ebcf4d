"""After an interruption: what nobody saw the end of is unknown, said so, and never repeated."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.container.records import KeptAnswer, ReplyTo, read_answer, read_reply_to
from rosic.core import messages, records
from rosic.core.i18n import in_language, joined
from rosic.core.message import Outbound, Weight
from rosic.core.order import Ending
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


class UntoldOrders(NamedTuple):
    """Lives that one line gave, and where to say how they ended.

    Attributes:
        shown: Id of the message that shows them; empty when none is known.
    """

    origin: ReplyTo
    shown: str
    lives: list[Unfinished]


class Recovery:
    """Finishes what the last run could not (safety.md, crash recovery)."""

    def __init__(
        self,
        store: Store,
        linker: Linker,
        teller: ChatSender,
        clock: Clock,
        messengers: Mapping[str, Messenger],
        ends: EndButtons,
    ) -> None:
        self._store = store
        self._linker = linker
        self._teller = teller
        self._clock = clock
        self._messengers = messengers
        self._ends = ends

    async def settle(self, unfinished: Iterable[Unfinished], exists: Callable[[str], bool]) -> int:
        """Hold robots in doubt, write the missing outcomes, tell what was not told.

        Args:
            unfinished: From the store, at start.
            exists: Whether a robot is still configured.

        Returns:
            How many lives were settled.
        """
        settled: list[Unfinished] = []
        for life in unfinished:
            if life.ending is None:
                if exists(life.robot):
                    await self._linker.hold_for_good(life.robot, self._linker.halt(life.robot))
                if not await self._conclude(life):
                    continue  # the next start finds it again
            settled.append(life)
        for told in self._together(settled):
            self._tell(told, exists)
        return len(settled)

    async def _conclude(self, life: Unfinished) -> bool:
        try:
            await self._store.write(
                Concluded(
                    cid=life.cid,
                    ending=Ending.UNKNOWN.value,
                    at_ns=self._clock.wall_ns(),
                    letter=Letter(life.principal, b""),
                )
            )
        except StoreFault:
            log.exception("an interrupted order could not be settled")
            return False
        return True

    def _together(self, lives: Iterable[Unfinished]) -> Iterable[UntoldOrders]:
        """Repeat answers; return the rest, robots that one line commanded together."""
        answers: dict[tuple[str, Chat], list[tuple[Unfinished, KeptAnswer]]] = {}
        cards: dict[tuple[str, ...] | CommandId, UntoldOrders] = {}
        for life in lives:
            if life.claim is None:
                self._let_go(life)  # erased with its container: there is nobody to tell
                continue
            try:
                # A refusal names no robot; an order that was refused later does.
                if life.robot:
                    shown = (life.placed or b"").decode("utf-8", "replace")
                    _put_together(cards, UntoldOrders(read_reply_to(life.claim), shown, [life]))
                else:
                    answer = read_answer(life.claim)
                    answers.setdefault((answer.messenger, answer.chat), []).append((life, answer))
            except msgspec.DecodeError:
                log.warning("a letter of the last run cannot be read")
                self._let_go(life)
        for found in answers.values():
            self._repeat_answers(found)
        return cards.values()

    def _let_go(self, life: Unfinished) -> None:
        """Nobody can be told of this any more; it takes no room in the record from now on."""
        self._store.note(records.Told(cid=life.cid, at_ns=self._clock.wall_ns()))

    def _repeat_answers(self, found: list[tuple[Unfinished, KeptAnswer]]) -> None:
        """Repeat what was answered in one chat, many answers as one."""
        name, chat = found[0][1].messenger, found[0][1].chat
        messenger = self._messengers.get(name)
        if messenger is None:
            return  # no longer configured; the record keeps it
        languages = self._teller.languages
        if len(found) > SINGLY:
            note = together(messenger, chat, [life.cid for life, _ in found])
            catalogue = languages.of(found[-1][0].principal)
            text = in_language(messages.said_again(note.outbound.text), catalogue)
            note.outbound = msgspec.structs.replace(note.outbound, text=text)
            self._teller.say(note)
            return
        for life, answer in found:
            text = in_language(messages.said_again(answer.text), languages.of(life.principal))
            outbound = Outbound(
                chat=chat, text=text, reply_to=answer.message, weight=Weight.OUTCOME
            )
            self._say(name, outbound, [life])

    def _tell(self, told: UntoldOrders, exists: Callable[[str], bool]) -> None:
        origin, lives = told.origin, told.lives
        shown = [
            self._linker.profile(life.robot).shown if exists(life.robot) else life.robot
            for life in lives
        ]
        if len(lives) == 1 and origin.title.startswith(f"{shown[0]}:"):
            text = _ended(_named_once(origin.title), lives[0])
        else:  # in the order in which the line named them, which is that of their claims
            ends = [_ended(f"{name}:", life) for name, life in zip(shown, lives, strict=True)]
            text = joined("\n", [_named_once(origin.title), *ends])
        # Without a message to edit it may be the second time, unless the end was not known before.
        if not told.shown and any(life.ending is not None for life in lives):
            text = messages.said_again(text)
        reply_to = "" if told.shown else origin.message
        catalogue = self._teller.languages.of(lives[0].principal)
        name, _, asked = origin.title.partition(": ")
        asked_of = lives[0].robot if len(lives) == 1 else name
        outbound = Outbound(
            chat=origin.chat,
            text=in_language(text, catalogue),
            reply_to=reply_to,
            buttons=self._ends[asked_of, asked, catalogue] if asked else (),
            weight=Weight.OUTCOME,
        )
        self._say(origin.messenger, outbound, lives, edit_of=told.shown)

    def _say(
        self,
        messenger_name: str,
        outbound: Outbound,
        lives: list[Unfinished],
        *,
        edit_of: str = "",
    ) -> None:
        messenger = self._messengers.get(messenger_name)
        if messenger is None:
            return  # no longer configured; the record keeps it
        first, *also = [life.cid for life in lives]
        self._teller.say(
            OutgoingMessage(messenger, outbound, first, edit_of, tuple(also), to=lives[0].principal)
        )


def _named_once(title: str) -> str:
    """Return ``omni: move 2 m`` of ``omni: omni move 2 m``: most people begin with the name."""
    name, _, line = title.partition(": ")
    begins = line[: len(name) + 1].casefold() == f"{name} ".casefold()
    return f"{name}: {line[len(name) + 1 :]}" if begins else title


def _ended(title: str, life: Unfinished) -> str:
    if life.ending is None or (life.ending == Ending.UNKNOWN.value and not life.words):
        return messages.unknown_after_restart(title)
    return joined("\n", (title, (life.words or b"").decode("utf-8", "replace")))


def _put_together(
    cards: dict[tuple[str, ...] | CommandId, UntoldOrders], told: UntoldOrders
) -> None:
    """Add a life to the card of its line, unless it is known to be shown in another message."""
    origin, shown, [life] = told
    where = origin.message or shown
    key: tuple[str, ...] | CommandId = life.cid
    if where:
        key = (origin.messenger, origin.chat.id, where, origin.title)
        if key in cards and shown and cards[key].shown not in ("", shown):
            key = (*key, shown)
    before = cards.setdefault(key, told)
    if before is not told:
        before.lives.append(life)
        cards[key] = before._replace(shown=before.shown or shown)
