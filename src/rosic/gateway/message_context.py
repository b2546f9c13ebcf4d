"""One message on its way through the rooms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeAlias

from rosic.contracts.chats import assurance_of
from rosic.core.language.skill_values import is_understood
from rosic.core.message import MessageValidity
from rosic.core.policy.query import AuthContext

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from rosic.authoriser.button_tokens import RedeemedButton
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.language import Line, Vocabulary
    from rosic.core.message import Chat, Inbound
    from rosic.core.robot.profile import RobotId


SteppedUp: TypeAlias = "Callable[[PrincipalId, Chat], bool]"
"""Whether somebody has shown a second factor lately, in a chat."""


class Requester(Protocol):
    """Who is behind an order: somebody who said it, or whose rule asks for it."""

    caller: Caller

    def auth_context(self) -> AuthContext:
        """Return what counts besides who they are."""


class MessageContext:
    """One message on its way: who said it, where, and which robots its lines asked so far.

    Attributes:
        act: Digest of what the tap that said it agrees to; empty: it was typed, or agrees to
            nothing.
        agreed: Identity of the command that the tap confirms: what it does is that command.
        confirmed: A button said it that asked whether it is meant.
        second: Who else has agreed to it.
        shown_ns: When the button was shown that said it, wall clock; 0: it was typed.
        text: What is read: as it was typed, or what the button says.
        proven: It was asked whether they have shown a second factor lately, and they have.
        is_sure: It is from whoever it names; else nothing is learnt from it of them.
        unclear: In a chat of many: one of its lines is no command, and was said to others.
    """

    __slots__ = (
        "act",
        "agreed",
        "arrived_ns",
        "asked",
        "caller",
        "confirmed",
        "inbound",
        "is_sure",
        "messenger",
        "proven",
        "second",
        "shown_ns",
        "stepped_up",
        "text",
        "unclear",
    )

    def __init__(
        self,
        messenger: Messenger,
        inbound: Inbound,
        caller: Caller,
        arrived_ns: int,
        stepped_up: SteppedUp,
    ) -> None:
        self.act = self.agreed = b""
        self.text = inbound.text
        self.confirmed = self.proven = self.unclear = False
        self.second: PrincipalId | None = None
        self.shown_ns = 0
        self.stepped_up = stepped_up
        self.messenger = messenger
        self.inbound = inbound
        self.caller = caller
        self.arrived_ns = arrived_ns
        self.is_sure = inbound.standing is not MessageValidity.UNVERIFIED
        self.asked: tuple[RobotId, ...] = ()

    def tapped(self, button: RedeemedButton) -> None:
        """Take in what a button says, what it agrees to, and when it was shown."""
        self.text, self.act, self.shown_ns, self.agreed = button

    def reads(self, command: str) -> None:
        """Take in what is left of what a button says once its sign was followed."""
        self.text = command

    def asks(self, robots: Iterable[RobotId]) -> None:
        """Take in which robots a line of it asks."""
        self.asked += tuple(robots)

    def read_as(self, lines: Sequence[Line], vocabulary: Vocabulary) -> None:
        """Take in what its several lines were read as."""
        self.unclear = not all(is_understood(line, vocabulary) for line in lines)

    def confirmed_as(self, command: str, second: PrincipalId | None) -> None:
        """Take in what was confirmed, and who else has agreed to it."""
        self.confirmed, self.text, self.second = True, command, second

    def auth_context(self) -> AuthContext:
        """Return what counts besides who they are; asked only where it matters."""
        self.proven = self.stepped_up(self.caller.principal, self.inbound.chat)
        return AuthContext(
            channel=assurance_of(self.messenger, self.inbound),
            stepped_up=self.proven,
            confirmed=self.confirmed,
            second=self.second,
        )
