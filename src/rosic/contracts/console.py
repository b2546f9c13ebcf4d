"""What a messenger may offer besides to whoever starts a gateway, and to whoever sits before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Iterable

    from rosic.core.identity import Address
    from rosic.core.language.command import Command
    from rosic.core.robot.profile import Profile


@runtime_checkable
class AccountProbe(Protocol):
    """A messenger whose account can be looked at without listening."""

    async def check(self) -> str:
        """Return whose account it is, in a few words.

        Raises:
            ConfigurationError: The account cannot be used (a wrong token).
            MessengerFault: The platform did not answer; it may work later.
        """
        ...


@runtime_checkable
class SupportsCompletion(Protocol):
    """A messenger that helps people type, and wants to know the fleet for it."""

    def know(self, profiles: Iterable[Profile], commands: Iterable[Command]) -> None:
        """Take them over."""
        ...


@runtime_checkable
class Console(Protocol):
    """A messenger that reads what somebody types at a terminal.

    Attributes:
        interrupted: Set by each Ctrl-C.
        ended: Set when nothing more is read.
        locale: What the terminal is set to; only the default for whoever has not chosen.
    """

    interrupted: asyncio.Event
    ended: asyncio.Event
    locale: str

    @property
    def address(self) -> Address:
        """Whose keys are pressed there."""
        ...

    @property
    def at_hand(self) -> bool:
        """Whether a person sits there, and not a pipe."""
        ...

    def interrupt(self) -> None:
        """Take a Ctrl-C that came as a signal."""
        ...

    def take_interrupts(self) -> int:
        """Return how many Ctrl-C came since something was typed, and wait for the next anew."""
        ...

    def show(self, text: str) -> None:
        """Show something that need not be part of a conversation."""
        ...
