"""Algorithm 1: authoriser, organiser, container, linker. No path to a robot skips one of them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.container.history import CommandHistory
from rosic.container.records import ReplyTo
from rosic.core.i18n import in_language
from rosic.core.language import Do, LanguageReader
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.order_status import ENGLISH, OrderStatus, wording_in
from rosic.core.synchronised_start import begin_together
from rosic.errors import OutOfBounds, Refusal
from rosic.gateway.agreement import Agreements
from rosic.gateway.busy import BusyRobots
from rosic.gateway.button_expiry import ButtonExpiry
from rosic.gateway.cancel import CancelLane
from rosic.gateway.chat_handler import ChatHandler, ChatParts, may_bring_a_code
from rosic.gateway.chat_locks import ChatLocks
from rosic.gateway.command_builder import CommandBuilder
from rosic.gateway.end_buttons import EndButtons
from rosic.gateway.limit_clamping import LimitClamping
from rosic.gateway.live_control import LiveControl
from rosic.gateway.order_execution import OrderExecutor
from rosic.gateway.order_status import OrderMessage, stop_button
from rosic.gateway.replies import Replies
from rosic.gateway.reply_context import GroupConversations, RobotFollowers
from rosic.gateway.requests import RequestFactory, line_id
from rosic.gateway.unfollowed_messages import UnfollowedMessages
from rosic.gateway.unverified_messages import UnverifiedMessages
from rosic.gateway.urgent_lane import UrgentLane

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.message import Inbound
    from rosic.core.order import Order, Permit, Request
    from rosic.core.order_status import Face
    from rosic.core.robot.skill import Argument
    from rosic.gateway.commands import Reply
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.hooks import PipelineHooks
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.order_execution import Dispatch
    from rosic.gateway.robot_registry import AddedRobot
    from rosic.gateway.stop import StopLane

LONG = 1_000
FRESH = MessageValidity.FRESH
UNVERIFIED = MessageValidity.UNVERIFIED
PRIVATE = ChatKind.PRIVATE


class Pipeline:
    """Takes messages from messengers, moves robots, tells what they did.

    Attributes:
        command_history: What people ask for often.
        executor: The orders under way.
        followers: Who hears what robots say of their own accord.
        hooks: Who receives what is no order.
        confirmation: Asks for confirmations.
        resuming: Undoes stops.
        cancels: Ends what people have under way themselves.
        backlog: Answers to what was sent while nobody listened.
        face: What a clock on the wall shows here.
        agreements: Binds what a tap agrees to.
        ends: What stands beneath an order that has ended.
        live: Has live orders steered.
    """

    def __init__(
        self,
        rooms: Components,
        stop_lane: StopLane,
        chat_sender: ChatSender,
        clock: Clock,
        face: Face,
        hooks: PipelineHooks,
    ) -> None:
        self._rooms = rooms
        self._reader = reader = LanguageReader(rooms.vocabularies)
        self._chat_sender = chat_sender
        self._languages = chat_sender.languages
        self._clock = clock
        self.face = face
        self._shown = {robot: profile.shown for robot, profile in rooms.profiles.items()}
        self._chat_locks = ChatLocks()
        self._requesting = RequestFactory(rooms, clock)
        self._clamping = LimitClamping(rooms, self._requesting, clock)
        self.agreements = Agreements(rooms, reader, self._clamping, hooks.task_steps)
        self._replies = replies = Replies(rooms, chat_sender, clock, self.agreements.bind)
        self._expiring = ButtonExpiry(chat_sender, clock, rooms.authoriser.buttons)
        self.resuming = resuming = stop_lane.resuming
        self.command_history = CommandHistory()
        builder = CommandBuilder(
            reader, self.command_history, self.agreements, self._clamping, resuming
        )
        self.backlog = replies.backlog
        self.executor = OrderExecutor(
            rooms.organiser, rooms.container, rooms.linker, chat_sender, clock
        )
        self.live = LiveControl(rooms, self.executor, clock)
        self.followers = RobotFollowers(rooms.organiser)
        self._busy = BusyRobots(rooms, self.executor)
        self.hooks, self.confirmation = hooks, hooks.confirmation_of(self.agreements)
        self.ends = EndButtons(rooms, self.agreements, hooks)
        self.cancels = CancelLane(rooms, self.executor, stop_lane, replies, hooks.commands, clock)
        self._stop_lane = stop_lane
        self._urgent = UrgentLane(stop_lane, self.cancels, self.executor)
        parts = ChatParts(
            reader,
            builder,
            self.confirmation,
            self._busy,
            self.followers,
            resuming,
            self.cancels,
            self._urgent,
            GroupConversations(clock),
        )
        self._chat = ChatHandler(rooms, chat_sender, replies, hooks, self.agreements, parts)
        self._unverified = UnverifiedMessages(self._chat, rooms, reader, replies)
        self._unfollowed = UnfollowedMessages(
            rooms, reader, replies, self._chat.addressed, self._chat.brought_a_code, clock
        )

    async def receive(self, messenger: Messenger, inbound: Inbound) -> None:
        """Take one message. On return it is settled, or on disk and under way.

        Never raises: what is wrong with a message is said to its author.
        """
        arrived_ns = self._clock.monotonic_ns()
        heard = inbound.text if inbound.nonce is None else inbound.nonce
        urgent = self._reader.urgent(heard) if self._stop_lane.hears(inbound) else None
        if urgent is not None and await self._urgent.take(messenger, inbound, urgent):
            await self._unfollowed.take(messenger, inbound)
            return
        if inbound.standing is not FRESH and inbound.standing is not UNVERIFIED:
            await self._unfollowed.take(messenger, inbound)
            return
        try:
            if not self._chat_locks.try_acquire(inbound.chat):
                await self._chat_locks.take(inbound.chat)
        except Refusal as refusal:
            self._replies.reject(messenger, inbound, refusal)
            return
        try:
            if len(heard) > LONG:
                await asyncio.sleep(0)  # looking for a stop was a step
            await self._carry(messenger, inbound, arrived_ns)
        finally:
            self._chat_locks.give(inbound.chat)

    async def _carry(self, messenger: Messenger, inbound: Inbound, arrived_ns: int) -> None:
        """Algorithm 1 of the paper: one message, from whoever sent it to its robots.

        What is said beside orders is answered by the chat handler. How an order ends comes back by
        way of the executor, which awaits what `Linker.dispatch` returns.
        """
        rooms, chat = self._rooms, self._chat if inbound.standing is FRESH else self._unverified
        try:
            if may_bring_a_code(inbound) and await chat.brought_a_code(messenger, inbound):
                return
            caller = rooms.authoriser.identify(inbound)  # AUTHENTICATE, GENERATEKEY
            message = chat.met(messenger, inbound, caller, arrived_ns)
            for number, line in enumerate(await chat.lines(message)):
                if number:
                    await asyncio.sleep(0)  # each line is a step: a stop does not wait for twenty
                cid = message.agreed if message.agreed and not number else line_id(inbound, number)
                permits: tuple[Permit, ...] = ()
                try:
                    if not isinstance(line, Do):
                        await chat.answer(message, line, cid)
                        continue
                    asked, note, requests = line, "", self._requests(message, line, cid)
                    try:
                        permits = rooms.organiser.admit(  # CHECKPERMISSIONS
                            message.caller, requests, self._arguments_of, message.auth_context
                        )
                    except OutOfBounds as over:
                        asked, requests, permits, note = self._clamping.admit(
                            message, line, cid, over
                        )
                    origin = self._origin(message, asked, requests)
                    orders = await rooms.container.prepare(  # PROCESSCOMMAND
                        permits, requests, origin
                    )
                    permits = ()
                    self._begin(
                        message, asked, note, orders, origin, rooms.linker.dispatch
                    )  # RELAYCOMMAND
                except BaseException as why:  # noqa: BLE001 - said, or raised again
                    rooms.organiser.abandon(permits)
                    await chat.not_done(message, line, cid, why)
        except Exception as why:  # noqa: BLE001 - said, or logged
            await chat.not_followed(messenger, inbound, why)

    def _requests(self, message: MessageContext, line: Do, cid: CommandId) -> list[Request]:
        """Return what a line asks of each robot, counted against what its author may ask.

        Raises:
            Refusal: It is too old, or too much, or a number of it may be in feet or in metres.
            FirstNeeded: In a chat of many it may be meant for somebody else.
        """
        caller = message.caller
        if message.inbound.live:
            self.live.check(line)
        if self.cancels.last:
            self.cancels.check(caller, message.inbound)
        requests = self._requesting.requests(message, line, cid, self._clock.monotonic_ns())
        self._rooms.organiser.charge(caller)  # not for what was sent in vain while nobody listened
        self._chat.check_units(message, line)
        if message.inbound.chat.kind is not PRIVATE:
            self._chat.check_meant(message, line, cid)
        return requests

    def _arguments_of(self, request: Request) -> Mapping[str, Argument]:
        return self._rooms.container.complete(request).arguments

    def _origin(self, message: MessageContext, line: Do, requests: Sequence[Request]) -> ReplyTo:
        """Return where a permitted line is answered, also by another run.

        Raises:
            RobotBusy: A robot is at work, and does not queue.
        """
        inbound, caller = message.inbound, message.caller
        if message.proven and any(map(self._rooms.organiser.wants_proof, requests)):
            self.hooks.proof_used(caller.principal, inbound.chat)
        for request in requests:
            if self._rooms.linker.queues[request.robot].current is not None:
                self._busy.check(request, caller.principal, line.text)
        title = f"{line.group or self._shown[line.robots[0]]}: {line.text}"
        return ReplyTo(
            message.messenger.name,
            inbound.chat,
            "" if inbound.nonce is not None else inbound.message,
            title,
        )

    def _begin(
        self,
        message: MessageContext,
        line: Do,
        note: str,
        orders: tuple[Order, ...],
        origin: ReplyTo,
        dispatch: Dispatch,
    ) -> None:
        """Let the orders of a line be relayed, each as soon as its robot has its turn.

        Args:
            message: The line is in it.
            line: As it is carried out.
            note: What is said beside its orders: that a default was lowered; mostly empty.
            orders: As the container has claimed them.
            origin: Where they are answered.
            dispatch: Relays one.
        """
        messenger, chat, caller = message.messenger, message.inbound.chat, message.caller
        if chat.kind is not PRIVATE and message.is_sure:
            self._chat.spoke_to(message, line)
        message.asks(line.robots)
        about, live = line.group or line.robots[0], orders[0].live
        if message.is_sure and not live:  # nobody typed it: it is nothing to ask for again
            self.command_history.note(caller.principal, chat, about, line.text)
        if len(orders) > 1:
            orders = begin_together(orders, self._clock.monotonic_ns())
        catalogue = self._languages.of(caller.principal)
        words = ENGLISH if catalogue is None else wording_in(catalogue)
        ends = self.ends
        after = ends.of_task(about, "", catalogue) if live else ends[about, line.text, catalogue]
        order_message = OrderMessage(
            messenger,
            chat,
            origin.message,
            caller.principal,
            words,
            about=about,
            buttons=stop_button(about),
            after=after,
            cause=message.inbound.message,
        )
        if message.confirmed and messenger.edits and len(message.asked) == len(orders):
            # The question that was answered becomes the message of the order that it asked about.
            order_message.adopt(message.inbound.under)
        now_ns = self._clock.wall_ns()
        for order in orders:
            shown = self._shown[order.robot]
            what = order.words if catalogue is None else in_language(order.words, catalogue)
            if note:
                what = f"{what}, {in_language(note, catalogue)}"
            status = OrderStatus(shown, f"{shown}: {what}", self.face, now_ns, words)
            order_message.show(order.cid, status)
            if message.is_sure:
                self.followers.note(order.robot, messenger, chat, caller.principal)
            relays = self.live.begin(order, message) if order.live else dispatch
            self.executor.begin(order, message, order_message, status, relays)
        self._chat_sender.show(order_message)

    # ---- for features ----

    def answer(self, messenger: Messenger, inbound: Inbound, caller: Caller, reply: Reply) -> None:
        """Answer somebody once something that took a while is done."""
        self._replies.hand_over(messenger, inbound, caller, reply)

    def plain(self, inbound: Inbound, text: str) -> str:
        """Return a sentence as whoever wrote reads it."""
        return in_language(text, self._languages.of_sender(inbound))

    def menu(self, principal: PrincipalId) -> Reply:
        """Return what somebody who has just come in may begin with."""
        return self._chat.menu(principal)

    async def close(self) -> None:
        """End every order: robots come to rest, outcomes are written and told."""
        self.backlog.flush()
        await self.executor.close()
        await self.cancels.close()
        await self._expiring.close()
        await self._unfollowed.close()
        await asyncio.sleep(0)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Show one more robot; what the ends of orders offer is worked out anew."""
        self._shown[newcomer.profile.id] = newcomer.profile.shown
        self.ends.clear()
