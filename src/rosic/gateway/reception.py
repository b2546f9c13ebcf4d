"""Who receives what is no order: errands, newcomers, questions before something dangerous.

Made empty; the composition root says who does what.
"""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import said
from rosic.core.identity import Caller, PrincipalId
from rosic.core.message import Button, Chat, ChatKind
from rosic.core.robot.profile import RobotId
from rosic.errors import Expired, Refusal
from rosic.gateway.office import CommandRegistry

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Inbound
    from rosic.gateway.builtin_commands import Reply
    from rosic.gateway.confirmation import Confirmation
    from rosic.gateway.message_context import MessageContext

_dashed = re.compile("[-\u2013\u2014\u2212]").search  # phones turn a hyphen into a longer line

SteppedUp: TypeAlias = Callable[[PrincipalId, Chat], bool]
ProofUsed: TypeAlias = Callable[[PrincipalId, Chat], None]
Newcomer: TypeAlias = "Callable[[Messenger, Inbound, str], Awaitable[Reply | None]]"
Enclosed: TypeAlias = "Callable[[Messenger, Inbound, Caller], None]"
Sights: TypeAlias = Callable[[RobotId], list[Button]]
Refused: TypeAlias = Callable[[Caller, Refusal], None]
Outdated: TypeAlias = Callable[[PrincipalId], None]


class PipelineHooks:
    """The doors beside the way of an order.

    Attributes:
        office: Who does which errand.
        consent: Asks for confirmations; None: nothing here wants any.
        stepped_up: Whether somebody has shown a second factor lately, in a chat.
        proof_used: Hears that this has let something dangerous pass.
        newcomer: Answers somebody unknown who may have brought a code; None: it was no code.
        refused: Hears of every refusal, for rules about misuse.
        enclosed: Takes in files that people send; None: none are taken.
        placed: Asks about places that people send; None: they mean nothing.
        outdated: Hears, in private, of a tap on a button that is no good any more.
        sights: Buttons for what can be seen of a robot, for its menu.
    """

    def __init__(self) -> None:
        self.office = CommandRegistry()
        self.consent: Confirmation | None = None
        self.stepped_up: SteppedUp = _never
        self.proof_used: ProofUsed = _unused
        self.newcomer: Newcomer | None = None
        self.refused: Refused = _ignore
        self.enclosed: Enclosed | None = None
        self.placed: Enclosed | None = None
        self.outdated: Outdated = _nothing
        self.sights: Sights = _unseen

    def take_in(self, said: MessageContext, charge: Callable[[Caller], object]) -> None:
        """Take in what came that is no words: a file or a place.

        Only in private: in a group, nobody meant it for ROSIC.

        Raises:
            Refusal: It is not taken; what was written beneath is not followed either.
        """
        inbound = said.inbound
        if inbound.chat.kind is not ChatKind.PRIVATE:
            return
        charge(said.caller)
        if inbound.enclosed is not None and self.enclosed is not None:
            self.enclosed(said.messenger, inbound, said.caller)
        if inbound.place is not None and self.placed is not None:
            self.placed(said.messenger, inbound, said.caller)

    def redeem(self, command: str, caller: Caller, act: bytes) -> tuple[str, PrincipalId | None]:
        """Return what a button that confirms says, and who has agreed to it.

        Raises:
            Expired: It was agreed to too long ago, or nobody was ever asked to agree.
        """
        if self.consent is None:
            raise Expired(said("That question is settled already. Nothing was done."))
        return self.consent.redeem(command, caller, act)


def may_bring_a_code(inbound: Inbound) -> bool:
    """Whether a message is worth a look before anybody is recognised: a tap, a link, a dash.

    In a group every message is, as a code that is shown there is burnt. In private a code without
    its dash is found when nothing else can be made of the line.
    """
    text = inbound.text
    if inbound.nonce is not None or inbound.chat.kind is not ChatKind.PRIVATE:
        return True
    return _dashed(text) is not None or text.startswith("/start ")


def _never(_principal: PrincipalId, _chat: Chat) -> bool:
    return False


def _unused(_principal: PrincipalId, _chat: Chat) -> None:
    return None


def _nothing(_principal: PrincipalId) -> None:
    return None


def _unseen(_robot: RobotId) -> list[Button]:
    return []


def _ignore(_caller: Caller, _refusal: Refusal) -> None:
    return None
