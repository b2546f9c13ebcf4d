"""What a message says, typed or tapped, and answers to those of its lines that order nothing."""

from __future__ import annotations

import logging
import re
from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.i18n import ImperialCatalogue, said
from rosic.core.language import (
    Answered,
    CommandLine,
    Do,
    Halt,
    Misunderstood,
    Resume,
    Use,
    hears_wait,
    kept_of,
)
from rosic.core.language.arguments import unit_needed
from rosic.core.message import ChatKind
from rosic.core.policy.roles import StepRequired
from rosic.errors import Expired, FirstNeeded, NotUnderstood, Refusal, Repeated, Unrecognised
from rosic.gateway.builtin_commands import BuiltinCommands
from rosic.gateway.command_builder import follows_last
from rosic.gateway.commands import CommandContext
from rosic.gateway.confirmation import CommandSource
from rosic.gateway.go_to_location import GoToLocation
from rosic.gateway.message_context import MessageContext
from rosic.gateway.replies import ASK_FIRST, BEHIND, CONFIRMED, LEAVE
from rosic.gateway.reply_context import meant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import LanguageReader, Line
    from rosic.core.message import Inbound
    from rosic.gateway.agreement import Agreements
    from rosic.gateway.busy import BusyRobots
    from rosic.gateway.cancel import CancelLane
    from rosic.gateway.command_builder import CommandBuilder
    from rosic.gateway.commands import Reply
    from rosic.gateway.components import Components
    from rosic.gateway.confirmation import Confirmation
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.hooks import PipelineHooks
    from rosic.gateway.replies import Replies
    from rosic.gateway.reply_context import GroupConversations, RobotFollowers
    from rosic.gateway.resume import ResumeHandler
    from rosic.gateway.urgent_lane import UrgentLane

FOLLOWED_KEPT = 10_000
FAULT = said("Something went wrong here. It is not known what was done; please look.")
NOTHING_DONE = said("Nothing was done.")
DONE_ALREADY = said("This was done already.")
FOR_OTHERS = said("This may be meant for somebody else here. Nothing was done.")

log = logging.getLogger("rosic.pipeline")

_dashed = re.compile("[-\u2013\u2014\u2212]").search  # phones turn a hyphen into a longer line


class ChatParts(NamedTuple):
    """What a chat handler hands lines to.

    Attributes:
        reader: What a text says.
        builder: Asks for what a command lacks.
        confirmation: Asks whether something is meant.
        busy: Lets an order follow another by a tap.
        followers: Who hears what robots say of their own accord.
        resuming: Undoes stops.
        cancels: Ends what people have under way.
        urgent: Stops.
        conversations: Whom people speak to in chats of many.
    """

    reader: LanguageReader
    builder: CommandBuilder
    confirmation: Confirmation
    busy: BusyRobots
    followers: RobotFollowers
    resuming: ResumeHandler
    cancels: CancelLane
    urgent: UrgentLane
    conversations: GroupConversations


class ChatHandler:
    """Reads messages of people who are known, and answers what orders nothing.

    Args:
        rooms: The four of them.
        chat_sender: Knows which robot a message speaks of, and who reads which language.
        replies: Answers.
        hooks: Who receives what is no order.
        agreements: Binds what a tap agrees to.
        parts: Whom lines are handed to.
    """

    def __init__(
        self,
        rooms: Components,
        chat_sender: ChatSender,
        replies: Replies,
        hooks: PipelineHooks,
        agreements: Agreements,
        parts: ChatParts,
    ) -> None:
        self._rooms = rooms
        self._reply_targets = chat_sender.reply_targets
        self._languages = chat_sender.languages
        self._replies = replies
        self._hooks = hooks
        self._agreements = agreements
        self._parts = parts
        self._reader = parts.reader
        self._builtin = BuiltinCommands(rooms, parts.builder, hooks, parts.resuming)
        self._going = GoToLocation(rooms, chat_sender.reply_targets)
        self._met: dict[PrincipalId, tuple[Caller, str]] = {}
        self._followed: OrderedDict[CommandId, None] = OrderedDict()

    # ---- from a message to its lines ----

    def met(
        self, messenger: Messenger, inbound: Inbound, caller: Caller, arrived_ns: int
    ) -> MessageContext:
        """Return a message of somebody known, and take in what came with it.

        Raises:
            Refusal: They are locked out, or what came is not taken; nothing of it is followed.
        """
        message = MessageContext(messenger, inbound, caller, arrived_ns, self._hooks.stepped_up)
        if message.is_sure and inbound.locale:
            self._languages.hear(caller.principal, inbound.locale)
        self._rooms.organiser.check_unlocked(caller)
        if message.is_sure and self._met.get(caller.principal) != (caller, messenger.name):
            self._met[caller.principal] = caller, messenger.name
            self._hooks.met.emit(messenger, inbound, caller.principal)
        if inbound.enclosed is not None or inbound.place is not None:
            self._take_in(message)
        return message

    def _take_in(self, message: MessageContext) -> None:
        """Take in what came that is no words: a file or a place.

        Only in private: in a group, nobody meant it for ROSIC.

        Raises:
            Refusal: It is not taken; what was written beneath is not followed either.
        """
        messenger, inbound, caller = message.messenger, message.inbound, message.caller
        if inbound.chat.kind is not ChatKind.PRIVATE:
            return
        self._rooms.organiser.charge(caller)
        if inbound.enclosed is not None:
            self._hooks.enclosed(messenger, inbound, caller)
        if inbound.place is not None:
            reply = self._going.ask(messenger, inbound, caller)
            self._replies.hand_over(messenger, inbound, caller, reply)

    async def lines(self, message: MessageContext) -> Sequence[Line]:
        """Return what a message says, typed or tapped; nothing where a tap is answered already.

        Raises:
            Refusal: The tap is good for nothing; nothing of it is followed.
        """
        caller, inbound = message.caller, message.inbound
        if inbound.nonce is not None and not await self._tapped(message):
            return ()
        visible = self._rooms.organiser.visible(caller.principal)
        container = self._rooms.container
        selected = (
            meant(message, self._reply_targets, container, visible, self._builtin.members)
            if inbound.answers or inbound.answers_us
            else container.selected(caller.principal, inbound.chat)
        )
        overheard = inbound.chat.kind is not ChatKind.PRIVATE and not (
            inbound.addressed or (self.addressed(inbound) and "\n" not in message.text)
        )
        lines: Sequence[Line] = self._reader.lines(message.text, selected, visible, overheard)
        if inbound.nonce is not None:
            self._agreements.check(caller, lines, message.act, live=inbound.live)
        elif self._hooks.drafting:
            lines = self._drafted(message, lines)
        if len(lines) > 1 and inbound.chat.kind is not ChatKind.PRIVATE:
            message.read_as(lines, self._reader.vocabulary)
        return lines

    def _drafted(self, message: MessageContext, lines: Sequence[Line]) -> Sequence[Line]:
        """Return lines of which no order is done that is a step of a mission put together here."""
        where = message.caller.principal, message.messenger.name, message.inbound.chat.id
        if where not in self._hooks.drafting:
            return lines
        named = self._agreements.named
        return [
            CommandLine("mission", f"add {named(line)}") if isinstance(line, Do) else line
            for line in lines
        ]

    def check_units(self, message: MessageContext, line: Do) -> None:
        """Refuse a number without a unit, typed by somebody who reads feet, with both readings.

        Raises:
            NotUnderstood: There is one.
        """
        if message.inbound.nonce is not None or not line.spoken:
            return
        if isinstance(self._languages.of(message.caller.principal), ImperialCatalogue):
            asked = unit_needed(self._reader.vocabulary, line)
            if asked is not None:
                raise NotUnderstood(asked.sentence, offers=asked.offers)

    # ---- what may be meant for somebody else ----

    def check_meant(self, message: MessageContext, line: Do, cid: CommandId) -> None:
        """Let a line of a chat of many move a robot at once if it is surely meant for that robot.

        People talk to each other there, about robots as well. Surely meant is a tap, what is
        addressed to us, and a line that names its robot, unless it stands among lines that are no
        commands. What names none is meant in a topic of that robot and while whoever wrote it is
        talking to it, but not in reply to what another person wrote.

        Raises:
            FirstNeeded: It may be meant for somebody else: a tap has to confirm it.
            Repeated: The same line was asked about, or followed, before.
        """
        inbound = message.inbound
        if inbound.nonce is not None or not any(skill.actuates for skill in line.skills):
            return
        # Noted of every one: to another bot of ours the same message may not be addressed.
        repeated = self._repeated(cid)
        named = line.named or line.text.startswith("/")
        if inbound.addressed or (named and not message.unclear):
            return
        # Before it is asked: what was asked about once is not done because it comes again later.
        if repeated:
            raise Repeated(DONE_ALREADY)
        if message.unclear or not self._in_conversation(message, line):
            raise FirstNeeded(
                FOR_OTHERS,
                need=StepRequired.CONFIRMATION.value,
                robot=line.robots[0],
                text=line.text,
                overheard=True,
            )

    def _in_conversation(self, message: MessageContext, line: Do) -> bool:
        """Whether a line without a name goes on with what its author says to that robot."""
        inbound, name = message.inbound, line.name
        if inbound.answers or inbound.answers_us:
            return False
        if inbound.chat.topic and self._rooms.container.here(inbound.chat) == name:
            return True
        who = message.caller.principal
        return self._parts.conversations.goes_on(who, inbound.chat, name)

    def spoke_to(self, message: MessageContext, line: Do | Use) -> None:
        """Note in a chat of many whom somebody speaks to, if a line or what it answers says so."""
        inbound = message.inbound
        if inbound.nonce is None and not inbound.addressed:
            named = line.named if isinstance(line, Do) else not inbound.answers
            if message.unclear or not named:
                return
        if line.name:
            who = message.caller.principal
            self._parts.conversations.note(who, inbound.chat, line.name)

    async def _tapped(self, message: MessageContext) -> bool:
        """Take in what a tap says; whether it says a command that is not answered yet."""
        messenger, inbound, caller = message.messenger, message.inbound, message.caller
        try:
            message.tapped(await self._replies.redeem(messenger, inbound, caller))
        except Repeated as void:
            self._outdated(message, void)
            raise
        command = message.text
        if command == LEAVE:
            self._replies.say(messenger, inbound, NOTHING_DONE)
            return False
        if command.startswith(ASK_FIRST):
            visible = self._rooms.organiser.visible(caller.principal)
            reply = self._parts.builder.ask(caller, command[1:], visible)
            self._replies.offer(messenger, inbound, caller, reply)
            return False
        if command.startswith(CONFIRMED):
            confirmation = self._parts.confirmation
            message.confirmed_as(*confirmation.redeem(command[1:], caller, message.act))
        elif command.startswith(BEHIND):
            visible = self._rooms.organiser.visible(caller.principal)
            lines = self._reader.lines(command[1:], "", visible)
            # Before anything is ended for it.
            self._agreements.check(caller, lines, message.act, live=inbound.live)
            message.reads(self._parts.busy.follow(message, command, lines))
        return True

    def _outdated(self, message: MessageContext, void: Repeated) -> None:
        """Show again what still waits for an answer, if that may have been the question."""
        private = message.inbound.chat.kind is ChatKind.PRIVATE
        if isinstance(void.__cause__, Expired) and private:
            self._rooms.organiser.charge(message.caller)
            self._hooks.outdated.emit(message.caller.principal)

    # ---- lines that order nothing ----

    async def answer(self, message: MessageContext, line: Line, cid: CommandId) -> None:
        """Follow one line that gives no order.

        Raises:
            Refusal: Why not; no robot has moved because of this line.
        """
        messenger, inbound = message.messenger, message.inbound
        if isinstance(line, Halt):
            # Obeyed before anything was understood; what only the grammar takes for a stop is one.
            if self._reader.urgent(inbound.text) is None:
                await self._parts.urgent.take(messenger, inbound, line)
            return
        wanted = self._wait(message, line)
        if (
            wanted is None
            and isinstance(line, Misunderstood)
            and await self._said_to_others(message, line)
        ):
            return
        # Before anything may refuse it: what was refused once is not done when it comes again.
        repeated = self._repeated(cid)
        self._rooms.organiser.charge(message.caller)
        if wanted is not None:
            if not repeated:
                self._replies.hand_over(messenger, inbound, message.caller, wanted)
            return
        line = self._goes_on(message, line)
        if isinstance(line, Misunderstood):
            raise NotUnderstood(line.sentence, offers=line.offers)
        if not repeated:
            await self._do(message, line, cid)

    def _goes_on(self, message: MessageContext, line: Line) -> Line:
        """Return a line with what it means after the last order of its author in this chat."""
        if not follows_last(line):
            return line
        caller, chat, rooms = message.caller, message.inbound.chat, self._rooms
        visible = rooms.organiser.visible(caller.principal)
        chosen = rooms.container.selected(caller.principal, chat)
        return self._parts.builder.goes_on(line, message, visible, chosen)

    def _wait(self, message: MessageContext, line: Line) -> Reply | None:
        """Return what ends the motion that somebody watches who writes wait or no; else None.

        They are words of every day, so they stop nothing; but whoever writes one while a robot
        moves for them must not have to look for the word that does.
        """
        if message.inbound.nonce is not None:
            return None
        bare = isinstance(line, CommandLine) and not line.rest
        if not bare and not isinstance(line, Misunderstood | Answered):
            return None
        known = self._rooms.vocabulary.known
        whole = bare or message.inbound.chat.kind is not ChatKind.PRIVATE
        if not hears_wait(message.text, known, whole=whole):
            return None
        chat, who = message.inbound.chat, message.caller.principal
        return self._parts.cancels.goes_on(message.messenger, chat, who)

    async def _do(self, message: MessageContext, line: Line, cid: CommandId) -> None:
        messenger, inbound = message.messenger, message.inbound
        if isinstance(line, Resume):
            text = await self._parts.resuming.resume(message, line, cid)
            self._replies.say(messenger, inbound, text)
        elif isinstance(line, CommandLine):
            self._parts.cancels.check(message.caller, inbound)
            asked = CommandContext(messenger, inbound, message.caller, line.rest, cid, message.act)
            doing = self._hooks.commands.do(line, asked)
            late = self._hooks.changes_late
            reply = await self._replies.while_late(messenger, inbound, late, doing)
            self._replies.hand_over(messenger, inbound, message.caller, reply)
        else:
            self._question(message, line)

    async def _said_to_others(self, message: MessageContext, line: Misunderstood) -> bool:
        """Whether words that make no sense were a code, or not meant for ROSIC: no answer then.

        People talk to each other in groups, and write beneath files what they show. Whoever writes
        a word that stops is answered all the same: with the buttons that do.
        """
        messenger, inbound = message.messenger, message.inbound
        if await self.brought_a_code(messenger, inbound):
            return True
        return not line.about_stop and not self.addressed(inbound)

    def menu(self, principal: PrincipalId) -> Reply:
        """Return what somebody who has just come in may begin with."""
        return self._builtin.menu(principal)

    def _question(self, message: MessageContext, line: Line) -> None:
        messenger, inbound, caller = message.messenger, message.inbound, message.caller
        if isinstance(line, Use):
            for robot in self._builtin.members(line.name):
                self._parts.followers.note(robot, messenger, inbound.chat, caller.principal)
            if inbound.chat.kind is not ChatKind.PRIVATE:
                self.spoke_to(message, line)
        reply = self._builtin.answer(caller, inbound.chat, line)
        self._replies.hand_over(messenger, inbound, caller, reply)

    def _repeated(self, cid: CommandId) -> bool:
        """Whether this line, which moves nothing, was followed before."""
        if cid in self._followed:
            return True
        self._followed[cid] = None
        if len(self._followed) > FOLLOWED_KEPT:
            self._followed.popitem(last=False)
        return False

    # ---- what is not done ----

    async def not_done(
        self, message: MessageContext, line: Line, cid: CommandId, why: BaseException
    ) -> None:
        """Say why a line is not done, or what has to come before it.

        Raises:
            BaseException: What is no fault of the line, as it came.
        """
        messenger, inbound, caller = message.messenger, message.inbound, message.caller
        if isinstance(why, FirstNeeded):
            if not isinstance(line, Do):
                self._replies.reject(messenger, inbound, why)
                return
            try:
                origin = CommandSource(cid, inbound.message)
                reply = self._parts.confirmation.ask(caller, line, why, origin, live=inbound.live)
            except Refusal as instead:  # nothing of it was looked at before it was asked about
                why = instead
            else:
                self._replies.offer(messenger, inbound, caller, reply)
                return
        if isinstance(why, Refusal):
            self._agreements.make_good(why, line, caller, inbound.chat)
            await self._replies.refuse(
                message, cid, why, kept_of(line, message.text, self._rooms.vocabulary.commands)
            )
            self._hooks.refused(caller, why)
            if isinstance(why, NotUnderstood) and isinstance(line, Do | Misunderstood):
                self._hooks.not_understood.emit(message)
        elif not isinstance(why, Exception):
            raise why
        else:
            log.error("a line could not be followed", exc_info=why)
            self._replies.deny(messenger, inbound, FAULT)

    async def not_followed(self, messenger: Messenger, inbound: Inbound, why: Exception) -> None:
        """Say why nothing of a message is followed; whoever is unknown may have brought a code."""
        if isinstance(why, Unrecognised):
            if not await self.brought_a_code(messenger, inbound):
                self._replies.turn_away(messenger, inbound, why.sentence)
        elif isinstance(why, Refusal):
            if not why.silent or inbound.awaits_answer:
                self._replies.reject(messenger, inbound, why)
        else:
            log.error("a message could not be handled", exc_info=why)
            self._replies.deny(messenger, inbound, FAULT)

    async def brought_a_code(self, messenger: Messenger, inbound: Inbound) -> bool:
        """Whether somebody brought an invitation, or showed one in a group; then it is answered."""
        reply = await self._hooks.newcomer(messenger, inbound, inbound.text)
        if reply is None:
            return False
        self._replies.say_with(messenger, inbound, reply)
        return True

    def addressed(self, inbound: Inbound) -> bool:
        """Whether words that make no sense were meant for ROSIC at all."""
        first = inbound.text[:64].split(maxsplit=1)[:1]
        return (
            (
                inbound.chat.kind is ChatKind.PRIVATE
                and inbound.enclosed is None
                and inbound.place is None
            )
            or inbound.addressed
            or inbound.text.startswith("/")
            or (bool(first) and first[0].lower() in self._rooms.vocabulary.callees)
        )


def may_bring_a_code(inbound: Inbound) -> bool:
    """Whether a message is worth a look before anybody is recognised: a tap, a link, a dash.

    In a group every message is, as a code that is shown there is burnt. In private a code without
    its dash is found when nothing else can be made of the line.
    """
    text = inbound.text
    if inbound.nonce is not None or inbound.chat.kind is not ChatKind.PRIVATE:
        return True
    return _dashed(text) is not None or text.startswith("/start ")
