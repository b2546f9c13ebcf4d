"""What must come before something dangerous: a tap that confirms it, a second person who agrees."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

import msgspec

from rosic.core.asking import Ask, Code, Denied
from rosic.core.decision import may_agree
from rosic.core.identity import Caller, PrincipalId
from rosic.core.language.suggestions import OR
from rosic.core.message import Button
from rosic.core.roles import ASSURANCES, Assurance, Need
from rosic.core.saying import joined, said
from rosic.errors import Expired, FirstNeeded, NotPermitted
from rosic.organiser.grounds import Grounds
from rosic.organiser.refusing import ANY_CHANNEL, bound_of
from rosic.pipeline.desk import Reply
from rosic.pipeline.replies import CONFIRMED, DO_IT, LEAVE, LEAVE_IT

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy
    from rosic.organiser.organiser import Organiser
    from rosic.pipeline.office import Asked
    from rosic.pipeline.reach import Reach

ASKED_FOR_S = 300.0
ASKED_AT_MOST = 1_000
PEOPLE_ASKED = 5
ID_BYTES = 6
SECONDED = "@"
# What keeps somebody from having a robot now, and not from agreeing that another moves it.
_NOT_THEIRS_NOW = frozenset(
    {Code.ROBOT_STOPPED, Code.SLOT_NEEDED, Code.SLOT_TAKEN, Code.ROBOT_TAKEN}
)


class Request(msgspec.Struct):
    """One thing that wants a second person.

    Attributes:
        ask: What it is, with its arguments.
        second: Who agreed.
    """

    caller: Caller
    ask: Ask
    text: str
    until_ns: int
    second: PrincipalId | None = None


class Consent:
    """Asks for what a skill wants besides the right to it; remembers who agreed, for minutes.

    Attributes:
        has_phone: Whether somebody has set up an authenticator that could show a code.
    """

    def __init__(self, organiser: Organiser, reach: Reach, clock: Clock, entropy: Entropy) -> None:
        self._organiser = organiser
        self._reach = reach
        self._clock = clock
        self._entropy = entropy
        self._requests: OrderedDict[str, Request] = OrderedDict()
        self.has_phone: Callable[[PrincipalId], bool] = lambda _: True

    def ask(self, caller: Caller, skill: str, needed: FirstNeeded) -> Reply:
        """Return what to say to somebody who may, once something else has happened."""
        if needed.need == Need.CONFIRMATION.value:
            return Reply(needed.sentence, _do_it(f"{CONFIRMED}{needed.text}"))
        if needed.need == Need.SECOND_PERSON.value:
            return Reply(self._ask_others(caller, skill, needed))
        if needed.need == Need.STEP_UP.value and not self.has_phone(caller.principal):
            return Reply(
                said(
                    "{needed} You have not set one up yet: send /authenticator in a private chat "
                    "with me.",
                    needed=needed.sentence,
                )
            )
        return Reply(needed.sentence)

    def _ask_others(self, caller: Caller, skill: str, needed: FirstNeeded) -> str:
        ask = Ask(
            principal=caller.principal, key=caller.key, robot=needed.robot, skill=skill,
            arguments=needed.arguments,
        )  # fmt: skip
        others = self._others(ask)
        if not others:
            return said(
                "{needed} Nobody else here may do exactly that, so nobody can agree.",
                needed=needed.sentence,
            )
        number = f"s{self._entropy.token(ID_BYTES).hex()}"
        until_ns = self._clock.monotonic_ns() + int(ASKED_FOR_S * 1e9)
        self._requests[number] = Request(caller, ask, needed.text, until_ns)
        if len(self._requests) > ASKED_AT_MOST:
            self._requests.popitem(last=False)
        told = self._reach.tell(
            others,
            said(
                "{name} wants: {text}. It needs a second person. Do you agree?",
                name=caller.name,
                text=needed.text,
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
            return said("{needed} I could not reach {names}.", needed=needed.sentence, names=names)
        return said(
            "{needed} I have asked {names}; you will hear from me.",
            needed=needed.sentence,
            names=names,
        )

    def _others(self, ask: Ask) -> tuple[PrincipalId, ...]:
        organiser = self._organiser
        rights, now_ns = organiser.rights, organiser.wall_ns()
        able = [
            who
            for who in rights.people()
            if who != ask.principal
            and who not in organiser.locked
            and may_agree(rights, who, ask, now_ns)
        ]
        return tuple(able[:PEOPLE_ASKED])

    def is_one(self, number: str) -> bool:
        """Whether an answer is about a request here."""
        return number in self._requests

    async def approve(self, asked: Asked) -> Reply:
        """Somebody agrees.

        Raises:
            Expired: It was settled, or waited too long.
            NotPermitted: They asked for it themselves, or may not do exactly that.
        """
        request = self._open(asked.rest.strip())
        who = asked.caller.principal
        if who == request.caller.principal:
            raise NotPermitted(said("Somebody else has to agree."))
        self._check_may(asked, request)
        request.second = who
        command = f"{CONFIRMED}{SECONDED}{asked.rest.strip()} {request.text}"
        name = self._organiser.name_of(who)
        self._reach.tell(
            (request.caller.principal,),
            said("{name} agrees: {text}.", name=name, text=request.text),
            _do_it(command),
        )
        return Reply(said("{name} is told that you agree.", name=request.caller.name))

    def _check_may(self, asked: Asked, request: Request) -> None:
        """See that somebody may do themselves what they agree to, by their key and in this chat.

        Raises:
            NotPermitted: They may not; says what is in the way.
        """
        ask = request.ask
        worth = ASSURANCES.get(asked.messenger.assurance, Assurance.PROVIDER_READABLE)
        grounds = Grounds(channel=worth)
        decision = self._organiser.decision(
            asked.caller, ask.robot, ask.skill, ask.arguments, grounds
        )
        if isinstance(decision, Denied) and decision.code not in _NOT_THEIRS_NOW:
            raise NotPermitted(_why_not(decision, request.text))

    async def decline(self, asked: Asked) -> Reply:
        """Somebody does not agree.

        Raises:
            Expired: It was settled, or waited too long.
        """
        number = asked.rest.strip()
        request = self._open(number)
        del self._requests[number]
        name = self._organiser.name_of(asked.caller.principal)
        self._reach.tell(
            (request.caller.principal,),
            said("{name} does not agree: {text}. Nothing was done.", name=name, text=request.text),
        )
        return Reply(said("Nothing is done."))

    def _open(self, number: str) -> Request:
        request = self._requests.get(number)
        if request is None or self._clock.monotonic_ns() > request.until_ns:
            self._requests.pop(number, None)
            raise Expired(said("That question is settled already. Nothing was done."))
        return request

    def redeem(self, command: str, caller: Caller) -> tuple[str, PrincipalId | None]:
        """Return a confirmed command, and who agreed to it. Each agreement counts once.

        Raises:
            Expired: It was agreed to too long ago, or for somebody else.
        """
        if not command.startswith(SECONDED):
            return command, None
        number, _, text = command[1:].partition(" ")
        request = self._open(number)
        if request.caller.principal != caller.principal or request.text != text:
            raise Expired(said("That was agreed to for something else. Nothing was done."))
        del self._requests[number]
        return text, request.second


def _why_not(denied: Denied, text: str) -> str:
    """Return why somebody cannot agree to a command."""
    if denied.limit is not None:
        return said(
            "You cannot agree to {text}: for you it is allowed with {within}.",
            text=text,
            within=bound_of(denied.limit.said),
        )
    if denied.channel is not None:
        return said(
            "You cannot agree to {text} in this chat: it needs {wanted}.",
            text=text,
            wanted=ANY_CHANNEL.get(denied.channel, said("a better protected chat")),
        )
    return said("Only somebody who may do that can agree to it.")


def _do_it(command: str) -> tuple[tuple[Button, ...], ...]:
    return ((Button(DO_IT, command), Button(LEAVE_IT, LEAVE)),)
