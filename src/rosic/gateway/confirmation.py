"""What must come before something dangerous: a tap that confirms it, a second person who agrees."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple, Protocol

import msgspec

from rosic.contracts.chats import assurance_of
from rosic.contracts.clock import ClockReading, passed_ns, reading
from rosic.core.i18n import joined, said
from rosic.core.identity import REQUEST_ID_BYTES, Address, Caller, CommandId, PrincipalId
from rosic.core.language import Do
from rosic.core.language.suggestions import OR
from rosic.core.message import AnswerState, Button
from rosic.core.policy.evaluate import may_agree
from rosic.core.policy.limits import limit_in_words
from rosic.core.policy.query import AuthContext, Deny, PolicyCode, Query
from rosic.core.policy.roles import StepRequired
from rosic.errors import Expired, FirstNeeded, NotPermitted
from rosic.gateway import cancel_messages as words
from rosic.gateway.agreement import ResolvedAct
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.delivery.notifier import Notification
from rosic.gateway.replies import CONFIRMED, DO_IT, LEAVE, LEAVE_IT
from rosic.organiser.refusals import ANY_CHANNEL, bound_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.contracts.clock import Clock, Entropy
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.organiser.organiser import Organiser

ASKED_FOR_S = 300.0
ASKED_AT_MOST = 1_000
PEOPLE_ASKED = 5
SECONDED = "@"
# What keeps somebody from having a robot now, and not from agreeing that another moves it.
_NOT_THEIRS_NOW = frozenset(
    {
        PolicyCode.ROBOT_STOPPED,
        PolicyCode.SLOT_NEEDED,
        PolicyCode.SLOT_TAKEN,
        PolicyCode.ROBOT_TAKEN,
    }
)


class CommandSource(NamedTuple):
    """What is asked about: what is done once it is confirmed is that very command (I1).

    Attributes:
        cid: Identity of the line.
        message: Id of the message that said it.
    """

    cid: CommandId = b""
    message: str = ""


NOWHERE = CommandSource()


class PendingConfirmation(msgspec.Struct, kw_only=True):
    """One thing that wants a second person.

    Attributes:
        line: What was said.
        act: What it came to when it was asked, for every robot; whoever agrees, agrees to this.
        asks: What wants the second person, with its arguments.
        second: Who agreed.
        seconded_from: By which account.
        origin: What said it.
    """

    caller: Caller
    line: Do
    act: ResolvedAct
    asks: tuple[Query, ...]
    asked: ClockReading
    second: PrincipalId | None = None
    seconded_from: Address | None = None
    origin: CommandSource


class Resolver(Protocol):
    """Says what words come to; see `rosic.gateway.agreement.Agreements`."""

    def of(self, line: Do, caller: Caller, *, live: bool = False) -> ResolvedAct:
        """Return what a line comes to now for somebody.

        Raises:
            NotUnderstood, OutOfBounds: It cannot be carried out as it was said.
        """

    def is_current(self, act: ResolvedAct, line: Do, caller: Caller) -> bool:
        """Whether a line comes to the same as before, under the same rules."""


class Confirmation:
    """Asks for what a skill wants besides the right to it; remembers who agreed, for minutes.

    Args:
        has_phone: Whether somebody has set up an authenticator that could show a code.
    """

    def __init__(
        self,
        organiser: Organiser,
        reach: Notifier,
        agreements: Resolver,
        clock: Clock,
        entropy: Entropy,
        has_phone: Callable[[PrincipalId], bool],
    ) -> None:
        self._organiser = organiser
        self._agreements = agreements
        self._reach = reach
        self._clock = clock
        self._entropy = entropy
        self._requests: OrderedDict[str, PendingConfirmation] = OrderedDict()
        self._has_phone = has_phone

    def ask(
        self,
        caller: Caller,
        line: Do,
        needed: FirstNeeded,
        origin: CommandSource = NOWHERE,
        *,
        live: bool = False,
    ) -> Reply:
        """Return what to say to somebody who may, once something else has happened.

        A program confirms nothing: a person is asked, as a second person would be.

        Args:
            caller: Who said it.
            line: What they said.
            needed: What has to come first.
            origin: What said it.
            live: What was said is to be steered.

        Raises:
            NotUnderstood, OutOfBounds: What was said cannot be carried out.
        """
        if caller.is_program:
            return self._ask_for_program(caller, line, needed, origin, live=live)
        if needed.need == StepRequired.CONFIRMATION.value:
            act = self._agreements.of(line, caller, live=live)
            question = (
                said("{act}? People talk here, so it moves only if you confirm it.", act=act.shown)
                if needed.overheard
                else said("{act}? It moves only if you confirm it.", act=act.shown)
            )
            return asks_first(question, _do_it(f"{CONFIRMED}{act.command}", act, origin))
        if needed.need == StepRequired.SECOND_PERSON.value:
            return self._ask_others(caller, line, needed, origin, live=live)
        if needed.need == StepRequired.STEP_UP.value and not self._has_phone(caller.principal):
            return Reply(
                said(
                    "{needed} You have not set one up yet: send /authenticator in a private chat "
                    "with me.",
                    needed=needed.sentence,
                )
            )
        return Reply(needed.sentence)

    def _ask_for_program(
        self, caller: Caller, line: Do, needed: FirstNeeded, origin: CommandSource, *, live: bool
    ) -> Reply:
        if needed.need == StepRequired.STEP_UP.value:
            sentence = said(
                "A second factor is asked for first, and a program has none. Ask a person."
            )
            return Reply(sentence, state=AnswerState.NOT_DONE)
        if needed.need == StepRequired.CONFIRMATION.value:
            sentence = said("A person has to confirm that first.")
            needed = FirstNeeded(sentence, need=needed.need, robot=needed.robot, text=needed.text)
        return self._ask_others(caller, line, needed, origin, live=live)

    def _ask_others(
        self, caller: Caller, line: Do, needed: FirstNeeded, origin: CommandSource, *, live: bool
    ) -> Reply:
        act = self._agreements.of(line, caller, live=live)
        asks = self._wanting(caller, act, needed)
        others = self._others(caller, asks)
        if not others:
            sentence = said(
                "{needed} Nobody else here may do exactly that, so nobody can agree.",
                needed=needed.sentence,
            )
            return Reply(sentence, state=AnswerState.NOT_DONE)
        number = f"s{self._entropy.token(REQUEST_ID_BYTES).hex()}"
        self._requests[number] = PendingConfirmation(
            caller=caller,
            line=line,
            act=act,
            asks=asks,
            asked=reading(self._clock),
            origin=origin,
        )
        if len(self._requests) > ASKED_AT_MOST:
            self._requests.popitem(last=False)
        told = self._reach.tell(
            others,
            said(
                "{name} wants: {act}. It needs a second person. Do you agree?",
                name=caller.name,
                act=act.shown,
            ),
            (
                (
                    Button(said("I agree"), f"/approve {number}"),
                    Button(said("No"), f"/decline {number}"),
                ),
            ),
            lifetime_s=ASKED_FOR_S,
        )
        names = joined(OR, map(self._organiser.name_of, others))
        if not told:
            sentence = said(
                "{needed} I could not reach {names}.", needed=needed.sentence, names=names
            )
            return Reply(sentence, state=AnswerState.NOT_DONE)
        sentence = said(
            "{needed} I have asked {names}; you will hear from me.",
            needed=needed.sentence,
            names=names,
        )
        return Reply(sentence, state=AnswerState.ASKED)

    def _wanting(self, caller: Caller, act: ResolvedAct, needed: FirstNeeded) -> tuple[Query, ...]:
        """Return everything in an act that wants a second person."""
        rights = self._organiser.rights
        return tuple(
            Query(
                principal=caller.principal,
                key=caller.key,
                robot=part.robot,
                skill=part.skill,
                arguments=part.arguments,
            )
            for part in act.parts
            if part.robot == needed.robot
            or StepRequired.SECOND_PERSON in rights.caution(part.robot, part.skill).needs
        )

    def _others(self, caller: Caller, asks: tuple[Query, ...]) -> tuple[PrincipalId, ...]:
        organiser = self._organiser
        rights, now_ns = organiser.rights, organiser.wall_ns()
        able = [
            who
            for who in rights.people()
            if who != caller.principal
            and who not in organiser.locked
            and not self._reach.is_program(who)
            and all(may_agree(rights, who, ask, now_ns) for ask in asks)
        ]
        return tuple(able[:PEOPLE_ASKED])

    async def withdraw(self, principal: PrincipalId, robots: Collection[RobotId]) -> str:
        """Ask nobody any more about what somebody wanted: they have cancelled it.

        Args:
            principal: Who wanted it.
            robots: What is about none of these stays asked; none: all of it goes.
        """
        theirs = [
            number
            for number, one in self._requests.items()
            if one.caller.principal == principal
            and (not robots or not set(one.line.robots).isdisjoint(robots))
        ]
        for number in theirs:
            del self._requests[number]
        return words.withdrawn(len(theirs)) if theirs else ""

    def forget_account(self, principal: PrincipalId, address: Address) -> None:
        """Let nothing come of what was asked, or agreed to, by an account that somebody lost."""
        for number, one in tuple(self._requests.items()):
            asked = one.caller.principal == principal and one.caller.address == address
            agreed = one.second == principal and one.seconded_from == address
            if asked or agreed:
                del self._requests[number]

    def is_one(self, number: str) -> bool:
        """Whether an answer is about a request here."""
        return number in self._requests

    async def approve(self, asked: CommandContext) -> Reply:
        """Somebody agrees.

        Raises:
            Expired: It was settled, waited too long, or would be something else by now.
            NotPermitted: They asked for it themselves, or may not do exactly that.
        """
        number = asked.rest.strip()
        request = self._open(number)
        who = asked.caller.principal
        if who == request.caller.principal:
            raise NotPermitted(said("Somebody else has to agree."))
        self._check_current(number, request)
        self._check_may(asked, request)
        request.second, request.seconded_from = who, asked.caller.address
        command = f"{CONFIRMED}{SECONDED}{number} {request.act.command}"
        name = self._organiser.name_of(who)
        agrees = said("{name} agrees: {act}.", name=name, act=request.act.shown)
        self._tell(
            request, agrees, AnswerState.AGREED, _do_it(command, request.act, request.origin)
        )
        return Reply(said("{name} is told that you agree.", name=request.caller.name))

    def _check_current(self, number: str, request: PendingConfirmation) -> None:
        """See that what was asked for is still what it was.

        Raises:
            Expired: It is not; whoever asked is told.
        """
        if self._agreements.is_current(request.act, request.line, request.caller):
            return
        del self._requests[number]
        act = request.act.shown
        changed = said(
            "The rules here have changed since you asked for this: {act}. Nothing was done. "
            "Say it again.",
            act=act,
        )
        self._tell(request, changed, AnswerState.NOT_DONE)
        raise Expired(
            said(
                "The rules here have changed since {name} asked for this: {act}. Nothing was done, "
                "and {name} can ask again.",
                name=request.caller.name,
                act=act,
            )
        )

    def _check_may(self, asked: CommandContext, request: PendingConfirmation) -> None:
        """See that somebody may do themselves what they agree to, by their key and in this chat.

        Raises:
            NotPermitted: They may not; says what is in the way.
        """
        if asked.caller.is_program:
            raise NotPermitted(said("Only a person can agree to it."))
        auth_context = AuthContext(channel=assurance_of(asked.messenger, asked.inbound))
        for ask in request.asks:
            decision = self._organiser.decision(
                asked.caller, ask.robot, ask.skill, ask.arguments, auth_context
            )
            if isinstance(decision, Deny) and decision.code not in _NOT_THEIRS_NOW:
                raise NotPermitted(_why_not(decision, request.act.shown))

    async def decline(self, asked: CommandContext) -> Reply:
        """Somebody does not agree.

        Raises:
            Expired: It was settled, or waited too long.
        """
        number = asked.rest.strip()
        request = self._open(number)
        del self._requests[number]
        name = self._organiser.name_of(asked.caller.principal)
        refused = said(
            "{name} does not agree: {act}. Nothing was done.", name=name, act=request.act.shown
        )
        self._tell(request, refused, AnswerState.NOT_DONE)
        return Reply(said("Nothing is done."))

    def _tell(
        self,
        request: PendingConfirmation,
        text: str,
        state: AnswerState,
        buttons: tuple[tuple[Button, ...], ...] = (),
    ) -> None:
        """Tell whoever asked what became of it."""
        notice = Notification(text=text, buttons=buttons, cause=request.origin.message, state=state)
        self._reach.give((request.caller.principal,), notice)

    def _open(self, number: str) -> PendingConfirmation:
        request = self._requests.get(number)
        if request is None or passed_ns(self._clock, request.asked) > int(ASKED_FOR_S * 1e9):
            self._requests.pop(number, None)
            raise Expired(said("That question is settled already. Nothing was done."))
        return request

    def redeem(self, command: str, caller: Caller, act: bytes) -> tuple[str, PrincipalId | None]:
        """Return a confirmed command, and who agreed to it. Each agreement counts once.

        Args:
            command: What the button says.
            caller: Who tapped it.
            act: Digest of what the button was bound to.

        Raises:
            Expired: It was agreed to too long ago, for somebody else, or to something else.
            NotPermitted: A program would agree to what it asked for itself.
        """
        if not command.startswith(SECONDED):
            if caller.is_program:
                raise NotPermitted(said("Only a person can agree to it."))
            return command, None
        number, _, text = command[1:].partition(" ")
        request = self._open(number)
        theirs = request.caller.principal == caller.principal
        if not theirs or request.act.command != text or request.act.digest != act:
            raise Expired(said("That was agreed to for something else. Nothing was done."))
        del self._requests[number]
        return text, request.second


def _why_not(denied: Deny, act: str) -> str:
    """Return why somebody cannot agree to something."""
    if denied.limit is not None:
        return said(
            "You cannot agree to this: {act}. For you it is allowed with {within}.",
            act=act,
            within=limit_in_words(bound_of(denied.limit.said)),
        )
    if denied.channel is not None:
        return said(
            "You cannot agree to this in this chat: {act}. It needs {wanted}.",
            act=act,
            wanted=ANY_CHANNEL.get(denied.channel, said("a better protected chat")),
        )
    return said("Only somebody who may do that can agree to it.")


def _do_it(command: str, act: ResolvedAct, origin: CommandSource) -> tuple[tuple[Button, ...], ...]:
    yes = Button(DO_IT, command, act=act.digest, asked=origin.cid)
    return ((yes, Button(LEAVE_IT, LEAVE)),)
