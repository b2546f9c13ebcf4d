"""What must come before something dangerous: a tap that confirms it, a second person who agrees."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

import msgspec

from rosic.core.identity import Caller, PrincipalId
from rosic.core.language.suggestions import OR
from rosic.core.message import Button
from rosic.core.roles import Need
from rosic.core.saying import joined, said
from rosic.errors import Expired, FirstNeeded, NotPermitted
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


class Request(msgspec.Struct):
    """One thing that wants a second person.

    Attributes:
        second: Who agreed.
    """

    caller: Caller
    robot: str
    skill: str
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
        others = self._others(caller.principal, needed.robot, skill)
        if not others:
            return said(
                "{needed} Nobody else here may do that, so nobody can agree.",
                needed=needed.sentence,
            )
        number = f"s{self._entropy.token(ID_BYTES).hex()}"
        until_ns = self._clock.monotonic_ns() + int(ASKED_FOR_S * 1e9)
        self._requests[number] = Request(caller, needed.robot, skill, needed.text, until_ns)
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

    def _others(self, principal: PrincipalId, robot: str, skill: str) -> tuple[PrincipalId, ...]:
        organiser = self._organiser
        able = [
            who
            for who in organiser.rights.people()
            if who != principal
            and who not in organiser.locked
            and organiser.allows(who, robot, skill)
        ]
        return tuple(able[:PEOPLE_ASKED])

    def is_one(self, number: str) -> bool:
        """Whether an answer is about a request here."""
        return number in self._requests

    async def approve(self, asked: Asked) -> Reply:
        """Somebody agrees.

        Raises:
            Expired: It was settled, or waited too long.
            NotPermitted: They asked for it themselves, or may not do it.
        """
        request = self._open(asked.rest.strip())
        who = asked.caller.principal
        if who == request.caller.principal:
            raise NotPermitted(said("Somebody else has to agree."))
        if not self._organiser.allows(who, request.robot, request.skill):
            raise NotPermitted(said("Only somebody who may do that can agree to it."))
        request.second = who
        command = f"{CONFIRMED}{SECONDED}{asked.rest.strip()} {request.text}"
        name = self._organiser.name_of(who)
        self._reach.tell(
            (request.caller.principal,),
            said("{name} agrees: {text}.", name=name, text=request.text),
            _do_it(command),
        )
        return Reply(said("{name} is told that you agree.", name=request.caller.name))

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


def _do_it(command: str) -> tuple[tuple[Button, ...], ...]:
    return ((Button(DO_IT, command), Button(LEAVE_IT, LEAVE)),)
