"""Who: principals, their addresses, their keys, and the identity of a command.

Identity is the platform's immutable id. A username or a display name is never compared.
"""

from __future__ import annotations

from hashlib import blake2b
from typing import Final, TypeAlias

import msgspec

PrincipalId: TypeAlias = str
KeyId: TypeAlias = str
CommandId: TypeAlias = bytes

COMMAND_ID_BYTES: Final = 16
DIGEST_BYTES: Final = 16
"""Of whatever is told apart, or compared with what was shown, by a digest."""
RECORD_ID_BYTES: Final = 8
"""Of what is on record for long: people, keys, rights, invitations, bookings, shared data."""
REQUEST_ID_BYTES: Final = 6
"""Of what waits for an answer: a confirmation, a request for access, a wish, a notice."""
TYPED_ID_BYTES: Final = 4
"""Of a robot's request for help, which people type."""
OUTBOX_KEY_BYTES: Final = 12
"""Of what is still to be said, or to be taken out of a chat: the names under which it is stored."""

OPERATOR: PrincipalId = "operator"
"""Whoever owns the machine: seeds people, uses the control socket. No chat speaks for them."""


ROBOT = "robot"
"""Platform of a robot's address: ``robot:omni``. No messenger is called so."""
PROGRAM = "program"
"""Platform of a program's address. What is said there, nobody reads: nobody confirms there."""
PAGE = "page"
"""Platform of everybody's address on the page; the account is their own id. No other messenger is
called so: only a session that was begun by their own chat, or by their passkey, speaks from it."""


class Address(msgspec.Struct, frozen=True, gc=False):
    """A principal's account on a messenger.

    Attributes:
        platform: ``terminal``, ...; the messenger's adapter gives it
        account: The platform's immutable id, as text.
    """

    platform: str
    account: str

    def __str__(self) -> str:
        return f"{self.platform}:{self.account}"


class AuthorisationKey(msgspec.Struct, frozen=True, kw_only=True):
    """The paper's authorisation key: a record, never something typed into a chat.

    Attributes:
        id: Appears on every request and in every decision.
        scopes: Narrow the principal's roles to these scopes; empty means no narrowing.
        expires_ns: Wall clock; None means until revoked.
        issuer: Who gave it.
    """

    id: KeyId
    principal: PrincipalId
    issuer: PrincipalId
    issued_ns: int
    scopes: tuple[str, ...] = ()
    expires_ns: int | None = None
    revoked_ns: int | None = None


class Principal(msgspec.Struct, frozen=True, kw_only=True):
    """A person, a robot or a program that ROSIC knows; one id for ever.

    Attributes:
        name: For showing only.
        roles: Names of roles; unknown ones give nothing.
    """

    id: PrincipalId
    name: str
    roles: tuple[str, ...] = ()
    addresses: tuple[Address, ...] = ()

    @property
    def is_robot(self) -> bool:
        """Whether it is a robot, whom nobody can tell anything in a chat."""
        return any(address.platform == ROBOT for address in self.addresses)

    @property
    def is_program(self) -> bool:
        """Whether it is a program, which asks for what it may and agrees to nothing."""
        return any(address.platform == PROGRAM for address in self.addresses)


class Caller(msgspec.Struct, frozen=True, gc=False):
    """Somebody the authoriser recognised, in one conversation.

    Attributes:
        key: Id of the authorisation key under which they act.
        session: Id of the session key of this conversation (Algorithm 1, GENERATEKEY).
        counted_as: By what they are counted against limits; empty: as themselves. What somebody
            else may have written in their name is counted apart.
    """

    principal: PrincipalId
    name: str
    address: Address
    key: KeyId
    session: str
    counted_as: str = ""

    @property
    def is_program(self) -> bool:
        """Whether no person speaks here."""
        return self.address.platform == PROGRAM


def command_id(*parts: str) -> CommandId:
    """Return the identity of a command: the same message gives the same id, for ever.

    For a text: platform, account, chat, message id, line number. For a button: its nonce.
    The parts go in quoted and escaped, so that no two lists of parts collide by joining.
    """
    return blake2b(ascii(parts).encode(), digest_size=COMMAND_ID_BYTES).digest()


def robot_command_id(cid: CommandId, robot: str) -> CommandId:
    """Return the identity of one robot's share in a command given to a group."""
    return blake2b(cid + robot.encode(), digest_size=COMMAND_ID_BYTES).digest()
