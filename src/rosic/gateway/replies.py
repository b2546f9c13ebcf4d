"""Short answers that are no life: to a question, a refusal, a tap, a stranger."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from functools import partial
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from rosic.authoriser.button_tokens import OPEN
from rosic.authoriser.program_keys import without_keys
from rosic.container.records import KeptAnswer
from rosic.core.i18n import in_language, joined, said
from rosic.core.language import clean, hears_stop
from rosic.core.message import AnswerState, Button, ChatKind, Outbound
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.time_units import MINUTE_NS
from rosic.errors import Fault, FirstNeeded, Refusal, Repeated, TooManyRequests, Unrecognised
from rosic.gateway.commands import Reply, is_question
from rosic.gateway.delivery.catch_up import BacklogReplies
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.delivery.translation import translated
from rosic.gateway.order_label import label_of
from rosic.gateway.requests import is_missed

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.authoriser.button_tokens import RedeemedButton
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Address, Caller, CommandId
    from rosic.core.message import Chat, Inbound
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext

# What only a button says; typed, it means nothing.
LEAVE = "leave it"
ASK_FIRST = "?"
CONFIRMED = "!"
# The same for a robot that is at work: behind what it does, or instead of that.
AFTER, INSTEAD = ">", "^"
BEHIND = (AFTER, INSTEAD)
MARKS = (CONFIRMED, *BEHIND)
# Between a command and those that it was before, the newest first; the oldest is the menu it came
# from.
TRAIL = "\x1f"
ONLY_A_PERSON = said(
    "Only a person can confirm that, in a chat of their own or on the page. Nothing was done."
)
DO_IT, LEAVE_IT, PREVIOUS = said("Do it"), said("Leave it"), said("Previous")
# What a refusal offers to tap: a page. A robot beyond it can be named; platforms take 100 at most.
OFFERED_AT_MOST = 8
ASKED_KEPT = 300
"""Letters of what was refused that are kept beside the refusal, sealed as it is."""
NOT_KEPT = "(not kept)"
STRANGERS = RateLimit(burst=5.0, per_s=0.2)
STRANGERS_KEPT = 1_000
AGAIN_NS = 10 * MINUTE_NS
"""Whoever is unknown and goes on writing is told so again after so long, and no sooner."""


STOP_AT_MOST = 64
"""Letters of a stranger's message in which a stop is sought: nothing is paid for longer ones."""
NOTHING_STOPPED = said(
    "I do not know you, so I stopped nothing. Use the stop button of the robot itself, or ask the "
    "admin here."
)
ENDED_STOPPED_NOTHING = said("I stopped nothing. Use the stop button of the robot itself.")


LATE_AFTER_S = 1.0
LATE = said(
    "The record cannot keep up. What you asked for waits for it; it is not done yet, and you hear "
    "how it ends. Stop still works."
)
R = TypeVar("R")

Bind: TypeAlias = "Callable[[Button, Caller, Chat], Button]"


class Replies:
    """Hands answers to the chat sender, with buttons bound to the one who is answered.

    Args:
        rooms: Who knows the person.
        chat_sender: Says it.
        clock: Of the gateway.
        bind: Binds a button to what it lets robots do for somebody in a chat.

    Attributes:
        backlog: Answers to what was sent while nobody listened.
    """

    def __init__(
        self, rooms: Components, chat_sender: ChatSender, clock: Clock, bind: Bind
    ) -> None:
        self._bind_act = bind
        self._authoriser = rooms.authoriser
        self._container = rooms.container
        self._vocabularies = rooms.vocabularies
        self._chat_sender = chat_sender
        self._languages = chat_sender.languages
        self._clock = clock
        self.backlog = BacklogReplies(chat_sender, clock)
        self._strangers = Bucket(STRANGERS, clock.monotonic_ns())
        self._turned_away: OrderedDict[tuple[Address, bool], int] = OrderedDict()

    def say(
        self,
        messenger: Messenger,
        inbound: Inbound,
        text: str,
        state: AnswerState = AnswerState.FINAL,
        code: str = "",
    ) -> None:
        """Answer without buttons."""
        plain = in_language(text, self._languages.of_sender(inbound))
        outbound = Outbound(
            chat=inbound.chat,
            text=plain,
            reply_to=reply_id(inbound),
            cause=inbound.message,
            state=state,
            code=code,
        )
        self._say(self._note(messenger, outbound, inbound), inbound)

    async def while_late(
        self,
        messenger: Messenger,
        inbound: Inbound,
        late: Callable[[], bool],
        doing: Awaitable[R],
    ) -> R:
        """Wait for what somebody asked for; tell them, once, if it waits for the disk.

        Args:
            messenger: By which they asked.
            inbound: What they sent.
            late: Whether things wait for the disk.
            doing: What is waited for. It is not cut off.
        """
        telling = asyncio.create_task(self._tell_late(messenger, inbound, late))
        try:
            return await doing
        finally:
            telling.cancel()

    async def _tell_late(
        self, messenger: Messenger, inbound: Inbound, late: Callable[[], bool]
    ) -> None:
        await self._clock.sleep(LATE_AFTER_S)
        while not late():
            await self._clock.sleep(LATE_AFTER_S)
        self.say(messenger, inbound, LATE, AnswerState.GOES_ON)

    def deny(
        self, messenger: Messenger, inbound: Inbound, text: str, code: str = Fault.code
    ) -> None:
        """Answer without buttons that something is not done, or that nobody knows whether it is.

        Args:
            messenger: By which it is said.
            inbound: What is answered.
            text: Why not.
            code: Of the refusal, for programs.
        """
        self.say(messenger, inbound, text, AnswerState.NOT_DONE, code)

    def reject(self, messenger: Messenger, inbound: Inbound, refusal: Refusal) -> None:
        """Answer that something is refused, without buttons, and write nothing of it down."""
        plain = in_language(refusal.sentence, self._languages.of_sender(inbound))
        outbound = Outbound(
            chat=inbound.chat,
            text=plain,
            reply_to=reply_id(inbound),
            cause=inbound.message,
            state=AnswerState.NOT_DONE,
            code=refusal.code,
            retry_after_s=refusal.retry_after_s,
        )
        self._say(self._note(messenger, outbound, inbound), inbound)

    def offer(self, messenger: Messenger, inbound: Inbound, caller: Caller, reply: Reply) -> None:
        """Answer with buttons that only this person, in this chat, can use, once (I16)."""
        if self._cannot_answer(messenger, inbound, caller, reply):
            return
        outbound = Outbound(
            chat=inbound.chat,
            text=reply.text,
            reply_to=reply_id(inbound),
            buttons=self._bind(inbound, caller, reply.buttons),
            cause=inbound.message,
            state=reply.state,
        )
        plain = translated(outbound, self._languages.of(caller.principal))
        self._say(self._note(messenger, plain, inbound), inbound)

    def _note(self, messenger: Messenger, plain: Outbound, inbound: Inbound) -> OutgoingMessage:
        known = self._authoriser.directory.at(inbound.sender)
        asker = known[0].id if known is not None else str(inbound.sender)
        return OutgoingMessage(messenger, plain, None, edited_by(inbound), asker=asker)

    def _bind(
        self, inbound: Inbound, caller: Caller, buttons: tuple[tuple[Button, ...], ...]
    ) -> tuple[tuple[Button, ...], ...]:
        issue, bind = self._authoriser.buttons.issue, self._bind_act
        who, chat = caller.principal, inbound.chat
        return tuple(
            tuple(issue(bind(b, caller, chat), who, chat.id) for b in row) for row in buttons
        )

    def _cannot_answer(
        self, messenger: Messenger, inbound: Inbound, caller: Caller, reply: Reply
    ) -> bool:
        """Refuse what a program would have to confirm: nobody reads there, so nobody taps there."""
        if not caller.is_program or not is_question(reply):
            return False
        text = joined("\n", (ONLY_A_PERSON, reply.text))
        self.deny(messenger, inbound, text, FirstNeeded.code)
        return True

    def hand_over(
        self, messenger: Messenger, inbound: Inbound, caller: Caller, reply: Reply
    ) -> None:
        """Answer with a whole reply: buttons as `offer` has them, and a file if there is one.

        An empty text says nothing: the handler answers later.
        """
        if not reply.text and reply.attachment is None:
            return
        if self._cannot_answer(messenger, inbound, caller, reply):
            return
        outbound = Outbound(
            chat=inbound.chat,
            text=reply.text,
            reply_to=reply_id(inbound),
            buttons=self._bind(inbound, caller, reply.buttons),
            attachment=reply.attachment,
            cause=inbound.message,
            state=reply.state,
        )
        plain = translated(outbound, self._languages.of(caller.principal))
        note = OutgoingMessage(messenger, plain, asker=caller.principal)
        note.about = reply.about
        if reply.landed is not None:
            note.landed = partial(reply.landed, messenger, inbound.chat)
        if reply.attachment is not None:  # no file comes into a message that is there
            self._chat_sender.say(note)
        else:
            note.edit_of = "" if reply.anew else edited_by(inbound)
            self._say(note, inbound)

    def say_with(self, messenger: Messenger, inbound: Inbound, reply: Reply) -> None:
        """Answer somebody who is nobody yet; buttons carry their own nonces already.

        An empty text says nothing.
        """
        if not reply.text:
            return
        outbound = Outbound(
            chat=inbound.chat, text=reply.text, reply_to=reply_id(inbound), buttons=reply.buttons
        )
        plain = translated(outbound, self._languages.of_sender(inbound))
        self._chat_sender.say(self._note(messenger, plain, inbound))

    async def refuse(
        self, message: MessageContext, cid: CommandId, refusal: Refusal, asked: str
    ) -> None:
        """Write a refusal down with what it refuses, then tell it, once.

        It is only begun, if the messenger waits for it before it confirms anything: nothing moves
        by it, and a stop may wait behind a hundred of them.
        """
        awaited = message.inbound.awaits_answer
        # Who waits may say the same again once the limit has passed: it is not settled by it. In a
        # chat it is: there nobody says it again but the platform.
        if awaited and isinstance(refusal, TooManyRequests):
            self.reject(message.messenger, message.inbound, refusal)
            return
        if refusal.silent:
            if awaited or message.agreed:  # whoever confirms anew what was done is told so
                self.reject(message.messenger, message.inbound, refusal)
            return
        writing = self._refuse(message, cid, refusal, asked)
        if self.backlog.settles(message.messenger):
            self.backlog.begin(writing)
        else:
            await writing

    async def _refuse(
        self, message: MessageContext, cid: CommandId, refusal: Refusal, asked: str
    ) -> None:
        messenger, inbound, caller = message.messenger, message.inbound, message.caller
        plain = in_language(refusal.sentence, self._languages.of(caller.principal))
        kept = clean(without_keys(asked, NOT_KEPT)[:ASKED_KEPT])
        answer = KeptAnswer(messenger.name, inbound.chat, reply_id(inbound), plain, kept)
        try:
            await self._container.refuse(cid, caller, refusal, answer)
        except Repeated:  # the same message was settled before
            if message.agreed:
                self.reject(messenger, inbound, refusal)
            return
        buttons: tuple[tuple[Button, ...], ...] = tuple(
            (Button(label_of(offer, self._vocabularies.current), offer),)
            for offer in refusal.offers[:OFFERED_AT_MOST]
        )
        if refusal.choices:
            buttons = (tuple(Button(*choice) for choice in refusal.choices), *buttons)
        if refusal.access_request:
            buttons = (*buttons, (Button(ask_for_it(), refusal.access_request),))
        outbound = Outbound(
            chat=inbound.chat,
            text=refusal.sentence,
            reply_to=reply_id(inbound),
            buttons=self._bind(inbound, caller, buttons),
            cause=inbound.message,
            state=AnswerState.NOT_DONE,
            code=refusal.code,
            offers=refusal.offers[:OFFERED_AT_MOST],
            retry_after_s=refusal.retry_after_s,
        )
        who = caller.principal
        told = translated(outbound, self._languages.of(who))
        note = OutgoingMessage(messenger, told, cid, edited_by(inbound), to=who, asker=who)
        self._say(note, inbound, refusal)

    def _say(self, note: OutgoingMessage, inbound: Inbound, refusal: Refusal | None = None) -> None:
        if is_missed(inbound):
            catalogue = self._languages.of_sender(inbound)
            self.backlog.keep(note, refusal, catalogue, away=inbound.network_away)
        else:
            self._chat_sender.say(note)

    def turn_away(self, messenger: Messenger, inbound: Inbound, sentence: str) -> None:
        """Answer a stranger in private, once and not again soon; all strangers share one bucket.

        That their stop stopped nothing is said to them whatever they were told before, likewise.
        """
        who, now_ns = inbound.sender, self._clock.monotonic_ns()
        stops = _is_short_stop(inbound)
        told = who, stops
        silent = now_ns < self._turned_away.get(told, 0)
        if inbound.chat.kind is not ChatKind.PRIVATE or silent or self._strangers.take(now_ns):
            return
        unknown = self._authoriser.directory.at(who) is None
        if unknown:  # and not somebody whose access has ended
            self._turned_away[told] = now_ns + AGAIN_NS
            self._turned_away.move_to_end(told)
            if len(self._turned_away) > STRANGERS_KEPT:
                self._turned_away.popitem(last=False)
        if stops:
            ended = joined(" ", (ENDED_STOPPED_NOTHING, sentence))
            sentence = NOTHING_STOPPED if unknown else ended
        self.deny(messenger, inbound, sentence, Unrecognised.code)

    async def redeem(
        self, messenger: Messenger, inbound: Inbound, caller: Caller
    ) -> RedeemedButton:
        """Return what a tap says and agrees to; the tap itself is answered in any case.

        Raises:
            Repeated: The button is no longer good, or somebody else's; the tap was told so.
        """
        nonce = inbound.nonce or ""
        try:
            redeemed = self._authoriser.buttons.redeem(nonce, caller.principal, inbound)
        except Refusal as refusal:
            plain = in_language(refusal.sentence, self._languages.of(caller.principal))
            await messenger.answer_tap(inbound, plain)
            raise Repeated(refusal.sentence) from refusal
        await messenger.answer_tap(inbound, "")
        return redeemed


def _is_short_stop(inbound: Inbound) -> bool:
    heard = inbound.text if inbound.nonce is None else inbound.nonce
    return len(heard) <= STOP_AT_MOST and hears_stop(heard) is not None


def ask_for_it() -> str:
    """Return the label of the button that asks for the right that is missing."""
    return said("Ask for it")


def edited_by(inbound: Inbound) -> str:
    """Return which message the answer takes the place of: mostly the one that was tapped.

    What says how an order ended goes on saying it, however often its buttons are tapped.
    """
    lasts = inbound.nonce is not None and inbound.nonce.startswith(OPEN)
    return "" if lasts else inbound.under


def reply_id(inbound: Inbound) -> str:
    """Return the id of the message to answer; a tap has none."""
    return "" if inbound.nonce is not None else inbound.message
