"""Algorithm 1: authoriser, organiser, container, linker. No path to a robot skips one of them."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict, deque
from typing import TYPE_CHECKING

from rosic.container.history import CommandHistory
from rosic.container.records import ReplyTo
from rosic.core.i18n import in_language, said
from rosic.core.language import (
    CommandLine,
    Do,
    Halt,
    LanguageReader,
    Misunderstood,
    Resume,
    Use,
    kept_of,
)
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.order_status import ENGLISH, wording_in
from rosic.core.synchronised_start import begin_together
from rosic.errors import (
    Expired,
    FirstNeeded,
    NotUnderstood,
    OutOfBounds,
    Refusal,
    Repeated,
    TooManyRequests,
    Unrecognised,
)
from rosic.gateway.agreement import Agreements
from rosic.gateway.builtin_commands import BuiltinCommands
from rosic.gateway.busy import BusyRobots
from rosic.gateway.button_expiry import ButtonExpiry
from rosic.gateway.cancel import CancelLane
from rosic.gateway.command_builder import CommandBuilder
from rosic.gateway.commands import CommandContext
from rosic.gateway.end_buttons import EndButtons
from rosic.gateway.go_to_location import GoToLocation
from rosic.gateway.hooks import PipelineHooks, may_bring_a_code
from rosic.gateway.limit_clamping import LimitClamping
from rosic.gateway.message_context import MessageContext
from rosic.gateway.order_execution import OrderExecutor
from rosic.gateway.order_status import OrderMessage, stop_button
from rosic.gateway.replies import ASK_FIRST, BEHIND, CONFIRMED, LEAVE, Replies, reply_id
from rosic.gateway.reply_context import RobotFollowers, meant
from rosic.gateway.requests import RequestFactory, line_id
from rosic.gateway.unfollowed_messages import UnfollowedMessages
from rosic.gateway.urgent_lane import UrgentLane

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import Line
    from rosic.core.message import Chat, Inbound
    from rosic.core.order import Order, Request
    from rosic.core.order_status import Face
    from rosic.core.robot.skill import Argument
    from rosic.gateway.commands import Reply
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.robot_registry import AddedRobot
    from rosic.gateway.stop import StopLane


# ---- one chat's messages in order ----

WAITING_AT_MOST = 256


class ChatLocks:
    """A queue of one per chat that costs nothing while nobody waits.

    ``asyncio.Lock`` per chat would do the same, but would have to be created, kept and thrown
    away for every chat.
    """

    def __init__(self) -> None:
        # None: somebody has the turn, and nobody waits for it.
        self._chats: dict[tuple[str, str], deque[asyncio.Future[None]] | None] = {}

    def try_acquire(self, chat: Chat) -> bool:
        """Take the chat's turn if nobody has it; ``give`` must follow."""
        where = (chat.platform, chat.id)
        if where in self._chats:
            return False
        self._chats[where] = None
        return True

    async def take(self, chat: Chat) -> None:
        """Wait for the chat's turn; ``give`` must follow.

        Raises:
            TooManyRequests: Too many messages of this chat wait already (I15); no ``give`` is due.
        """
        if self.try_acquire(chat):
            return
        where = (chat.platform, chat.id)
        waiting = self._chats[where]
        if waiting is None:
            waiting = self._chats[where] = deque()
        if len(waiting) >= WAITING_AT_MOST:
            raise TooManyRequests(
                said("Too many messages at once. Wait a moment."), retry_after_s=5.0
            )
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        waiting.append(future)
        try:
            await future
        except asyncio.CancelledError:
            if future.done() and not future.cancelled():
                self.give(chat)
            raise

    def give(self, chat: Chat) -> None:
        """Give the turn to the next message of the chat."""
        where = (chat.platform, chat.id)
        waiting = self._chats[where]
        while waiting:
            future = waiting.popleft()
            if not future.done():
                future.set_result(None)
                return
        del self._chats[where]


FOLLOWED_KEPT, LONG = 10_000, 1_000
FRESH = MessageValidity.FRESH
FAULT = said("Something went wrong here. It is not known what was done; please look.")
NOTHING_DONE = said("Nothing was done.")

log = logging.getLogger("rosic.pipeline")


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
        organiser, container, linker = rooms.organiser, rooms.container, rooms.linker
        self._rooms = rooms
        self._reader = reader = LanguageReader(rooms.vocabularies)
        self._chat_sender = chat_sender
        self._languages = chat_sender.languages
        self._clock = clock
        self.face = face
        self._shown = {robot: profile.shown for robot, profile in rooms.profiles.items()}
        self._chat_locks = ChatLocks()
        self._requesting = RequestFactory(rooms, clock)
        self._followed: OrderedDict[CommandId, None] = OrderedDict()
        self._clamping = LimitClamping(rooms, self._requesting, clock)
        self.agreements = Agreements(rooms, self._reader, self._clamping)
        self._replies = Replies(rooms, chat_sender, clock, self.agreements.bind)
        self._expiring = ButtonExpiry(chat_sender, clock, rooms.authoriser.buttons)
        self._unfollowed = UnfollowedMessages(
            rooms, self._reader, self._replies, self._addressed, self._brought_a_code
        )
        self.resuming = resuming = stop_lane.resuming
        history = self.command_history = CommandHistory()
        self._choosing = CommandBuilder(reader, history, self.agreements, self._clamping, resuming)
        self.backlog = self._replies.backlog
        self.executor = OrderExecutor(organiser, container, linker, chat_sender, clock)
        self.followers, self._busy = RobotFollowers(organiser), BusyRobots(rooms, self.executor)
        self.hooks, self.confirmation = hooks, hooks.confirmation_of(self.agreements)
        self._going = GoToLocation(rooms, chat_sender.reply_targets)
        self.ends = EndButtons(rooms, self.agreements, self.hooks)
        self.cancels = CancelLane(
            rooms, self.executor, stop_lane, self._replies, self.hooks.commands, clock
        )
        self._stop_lane, self._urgent = (
            stop_lane,
            UrgentLane(stop_lane, self.cancels, self.executor),
        )
        self._builtin = BuiltinCommands(rooms, self._choosing, self.hooks, resuming)

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
        if inbound.standing is not FRESH:
            await self._unfollowed.take(messenger, inbound)
            return
        try:
            if not self._chat_locks.try_acquire(inbound.chat):
                await self._chat_locks.take(inbound.chat)
        except Refusal as refusal:
            self._replies.say(messenger, inbound, refusal.sentence)
            return
        try:
            if len(heard) > LONG:
                await asyncio.sleep(0)  # looking for a stop was a step
            await self._take(messenger, inbound, arrived_ns)
        finally:
            self._chat_locks.give(inbound.chat)

    async def _take(self, messenger: Messenger, inbound: Inbound, arrived_ns: int) -> None:
        """AUTHENTICATE and GENERATEKEY, then follow each line."""
        try:
            if may_bring_a_code(inbound) and await self._brought_a_code(messenger, inbound):
                return
            caller = self._rooms.authoriser.identify(inbound)
            if inbound.locale:
                self._languages.hear(caller.principal, inbound.locale)
            said = MessageContext(messenger, inbound, caller, arrived_ns, self.hooks.stepped_up)
            self._rooms.organiser.check_unlocked(caller)
            if inbound.brings:
                self._take_in(said)
            typed = inbound.nonce is None
            await (self._lines(said, inbound.text) if typed else self._tapped(said))
        except Unrecognised as stranger:
            await self._stranger(messenger, inbound, stranger)
        except Refusal as refusal:
            if not refusal.silent:
                self._replies.say(messenger, inbound, refusal.sentence)
        except Exception:
            log.exception("a message could not be handled")
            self._replies.say(messenger, inbound, FAULT)

    def _take_in(self, said: MessageContext) -> None:
        """Take in what came that is no words: a file or a place.

        Only in private: in a group, nobody meant it for ROSIC.

        Raises:
            Refusal: It is not taken; what was written beneath is not followed either.
        """
        messenger, inbound, caller = said.messenger, said.inbound, said.caller
        if inbound.chat.kind is not ChatKind.PRIVATE:
            return
        self._rooms.organiser.charge(caller)
        if inbound.enclosed is not None:
            self.hooks.enclosed(messenger, inbound, caller)
        if inbound.place is not None:
            self.answer(messenger, inbound, caller, self._going.ask(messenger, inbound, caller))

    async def _stranger(self, messenger: Messenger, inbound: Inbound, who: Unrecognised) -> None:
        """Answer somebody unknown: whoever brings a good code is let in."""
        if not await self._brought_a_code(messenger, inbound):
            self._replies.turn_away(messenger, inbound, who.sentence)

    async def _tapped(self, said: MessageContext) -> None:
        messenger, inbound, caller = said.messenger, said.inbound, said.caller
        try:
            tapped = await self._replies.redeem(messenger, inbound, caller)
            command, said.act, said.shown_ns = tapped
        except Repeated as void:
            self._outdated(said, void)
            raise
        if command == LEAVE:
            self._replies.say(messenger, inbound, NOTHING_DONE)
        elif command.startswith(ASK_FIRST):
            visible = self._rooms.organiser.visible(caller.principal)
            reply = self._choosing.ask(caller, command[1:], visible)
            self._replies.offer(messenger, inbound, caller, reply.text, reply.buttons)
        else:
            if command.startswith(CONFIRMED):
                said.confirmed = True
                command, said.second = self.confirmation.redeem(command[1:], caller, said.act)
            elif command.startswith(BEHIND):
                visible = self._rooms.organiser.visible(caller.principal)
                lines = self._reader.lines(command[1:], "", visible)
                command = self._busy.follow(said, command, lines)
            await self._lines(said, command)

    def _outdated(self, said: MessageContext, void: Repeated) -> None:
        """Show again what still waits for an answer, if that may have been the question."""
        if isinstance(void.__cause__, Expired) and said.inbound.chat.kind is ChatKind.PRIVATE:
            self._rooms.organiser.charge(said.caller)
            self.hooks.outdated.emit(said.caller.principal)

    async def _lines(self, said: MessageContext, text: str) -> None:
        caller, inbound = said.caller, said.inbound
        visible = self._rooms.organiser.visible(caller.principal)
        container = self._rooms.container
        selected = (
            meant(said, self._chat_sender.reply_targets, container, visible, self._builtin.members)
            if inbound.answers
            else container.selected(caller.principal, inbound.chat)
        )
        lines = self._reader.lines(text, selected, visible)
        if inbound.nonce is not None:
            self.agreements.check(caller, lines, said.act)
        for number, line in enumerate(lines):
            if number:
                await asyncio.sleep(0)  # each line is a step: a stop does not wait for twenty
            cid = line_id(inbound, number)
            try:
                if isinstance(line, Do):
                    await self._command(said, line, cid)
                else:
                    await self._follow(said, line, cid)
            except FirstNeeded as needed:
                self._ask_for(said, line, needed)
            except Refusal as refusal:
                self.agreements.name_in(refusal, line)
                await self._replies.refuse(said, cid, refusal, kept_of(line, text))
                self.hooks.refused(caller, refusal)
            except Exception:
                log.exception("a line could not be followed")
                self._replies.say(said.messenger, inbound, FAULT)

    async def _follow(self, said: MessageContext, line: Line, cid: CommandId) -> None:
        """Follow one line that gives no order.

        Raises:
            Refusal: Why not; no robot has moved because of this line.
        """
        if isinstance(line, Halt):
            # Obeyed before anything was understood; what only the grammar takes for a stop is one.
            if self._reader.urgent(said.inbound.text) is None:
                await self._urgent.take(said.messenger, said.inbound, line)
            return
        if isinstance(line, Misunderstood) and await self._brought_a_code(
            said.messenger, said.inbound
        ):
            return
        if isinstance(line, Misunderstood) and not self._addressed(said.inbound):
            return  # people talk to each other in groups, and write beneath files what they show
        # Before anything may refuse it: what was refused once is not done when it comes again.
        repeated = self._repeated(cid)
        self._rooms.organiser.charge(said.caller)
        if isinstance(line, Misunderstood):
            raise NotUnderstood(line.sentence, offers=line.offers)
        if not repeated:
            await self._answer(said, line, cid)

    async def _answer(self, said: MessageContext, line: Line, cid: CommandId) -> None:
        """Do what is asked beside orders, and say so."""
        if isinstance(line, Resume):
            text = await self.resuming.resume(said, line, cid)
            self._replies.say(said.messenger, said.inbound, text)
        elif isinstance(line, CommandLine):
            self.cancels.check(said.caller, said.inbound)
            asked = CommandContext(
                said.messenger, said.inbound, said.caller, line.rest, cid, said.act
            )
            reply = await self.hooks.commands.do(line, asked)
            self._replies.hand_over(said.messenger, said.inbound, said.caller, reply)
        else:
            self._question(said, line)

    async def _brought_a_code(self, messenger: Messenger, inbound: Inbound) -> bool:
        """Whether somebody brought an invitation, or showed one in a group; then it is answered."""
        reply = await self.hooks.newcomer(messenger, inbound, inbound.text)
        if reply is None:
            return False
        self._replies.say_with(messenger, inbound, reply)
        return True

    def _ask_for(self, said: MessageContext, line: Line, needed: FirstNeeded) -> None:
        """Say what has to come before something that is permitted."""
        if not isinstance(line, Do):
            self._replies.say(said.messenger, said.inbound, needed.sentence)
            return
        reply = self.confirmation.ask(said.caller, line, needed)
        self._replies.offer(said.messenger, said.inbound, said.caller, reply.text, reply.buttons)

    def _repeated(self, cid: CommandId) -> bool:
        """Whether this line, which moves nothing, was followed before."""
        if cid in self._followed:
            return True
        self._followed[cid] = None
        if len(self._followed) > FOLLOWED_KEPT:
            self._followed.popitem(last=False)
        return False

    def _addressed(self, inbound: Inbound) -> bool:
        """Whether words that make no sense were meant for ROSIC at all."""
        first = inbound.text[:64].split(maxsplit=1)[:1]
        return (
            (inbound.chat.kind is ChatKind.PRIVATE and not inbound.brings)
            or inbound.addressed
            or inbound.text.startswith("/")
            or (bool(first) and first[0].lower() in self._rooms.vocabulary.callees)
        )

    def answer(self, messenger: Messenger, inbound: Inbound, caller: Caller, reply: Reply) -> None:
        """Answer somebody once something that took a while is done."""
        self._replies.hand_over(messenger, inbound, caller, reply)

    def plain(self, inbound: Inbound, text: str) -> str:
        """Return a sentence as whoever wrote reads it."""
        return in_language(text, self._languages.of_sender(inbound))

    def menu(self, principal: PrincipalId) -> Reply:
        """Return what somebody who has just come in may begin with."""
        return self._builtin.menu(principal)

    def _question(self, said: MessageContext, line: Line) -> None:
        messenger, inbound, caller = said.messenger, said.inbound, said.caller
        if isinstance(line, Use):
            for robot in self._builtin.members(line.name):
                self.followers.note(robot, messenger, inbound.chat, caller.principal)
        reply = self._builtin.answer(caller, inbound.chat, line)
        self._replies.hand_over(messenger, inbound, caller, reply)

    async def _command(self, said: MessageContext, line: Do, cid: CommandId) -> None:
        """CHECKPERMISSIONS, PROCESSCOMMAND; RELAYCOMMAND goes on in a life of its own."""
        organiser, inbound, caller = self._rooms.organiser, said.inbound, said.caller
        if self.cancels.last:
            self.cancels.check(caller, inbound)
        requests = self._requesting.requests(said, line, cid, self._clock.monotonic_ns())
        organiser.charge(caller)  # not for what was sent in vain while nobody listened
        try:
            permits = organiser.admit(caller, requests, self._arguments_of, said.auth_context)
        except OutOfBounds as over:
            line, requests, permits = self._clamping.admit(said, line, cid, over)
        if said.proven and any(organiser.wants_proof(request) for request in requests):
            self.hooks.proof_used(caller.principal, inbound.chat)
        title = f"{line.group or self._shown[line.robots[0]]}: {line.text}"
        origin = ReplyTo(said.messenger.name, inbound.chat, reply_id(inbound), title)
        try:
            self._busy.check(requests, caller.principal, line.text)
            orders = await self._rooms.container.prepare(permits, requests, origin)
        except BaseException:
            organiser.abandon(permits)
            raise
        said.asked += line.robots
        self.command_history.note(
            caller.principal, inbound.chat, line.group or line.robots[0], line.text
        )
        if len(orders) > 1:
            orders = begin_together(orders, self._clock.monotonic_ns())
        self._begin(said, line, orders)

    def _arguments_of(self, request: Request) -> Mapping[str, Argument]:
        return self._rooms.container.complete(request).arguments

    def _begin(self, said: MessageContext, line: Do, orders: tuple[Order, ...]) -> None:
        messenger, chat, caller = said.messenger, said.inbound.chat, said.caller
        catalogue = self._languages.of(caller.principal)
        words = ENGLISH if catalogue is None else wording_in(catalogue)
        card = OrderMessage(
            messenger, chat, reply_id(said.inbound), caller.principal, self.face, words
        )
        card.about = line.group or line.robots[0]
        card.buttons = stop_button(card.about)
        card.after = self.ends[card.about, line.text, catalogue]
        if said.confirmed and messenger.edits and len(said.asked) == len(orders):
            # The question that was answered becomes the life it asked for.
            card.message, card.adopted = said.inbound.under, bool(said.inbound.under)
        now_ns = self._clock.wall_ns()
        for order in orders:
            shown = self._shown[order.robot]
            what = order.words if catalogue is None else in_language(order.words, catalogue)
            if said.note:
                what = f"{what}, {in_language(said.note, catalogue)}"
            life = card.add(order.cid, shown, f"{shown}: {what}", now_ns)
            self.followers.note(order.robot, messenger, chat, caller.principal)
            self.executor.begin(order, said, card, life)
        self._chat_sender.show(card)

    async def close(self) -> None:
        """End every life: robots come to rest, outcomes are written and told."""
        self.backlog.flush()
        await self.executor.close()
        await self.cancels.close()
        await self._expiring.close()
        await asyncio.sleep(0)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Show one more robot; what the ends of orders offer is worked out anew."""
        self._shown[newcomer.profile.id] = newcomer.profile.shown
        self.ends.clear()
