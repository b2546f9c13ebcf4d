"""What is written down. A record is a fact that happened; none is ever changed.

Ids and digests stand in the open; what can name a person or repeat their words is in ``letter``,
which the store seals with the container's own key.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import msgspec

from rosic.core.identity import Address, AuthorisationKey, CommandId, KeyId, PrincipalId
from rosic.core.robot.profile import RobotId

APART: Final = frozenset({"file-part"})
"""Kinds of facts that are too large to be handed over with the others: asked for by key alone."""


class Letter(msgspec.Struct, frozen=True, gc=False):
    """Personal content, and the container it belongs to.

    Attributes:
        container: Whose key seals it: a principal's or a robot's id.
    """

    container: str
    content: bytes


class Claimed(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """An order was decided. Durable before the robot hears of it (I1, I9).

    Attributes:
        digest: Of skill and arguments.
        letter: Where and how to answer, if this process does not live to do it.
    """

    cid: CommandId
    principal: PrincipalId
    key: KeyId
    robot: RobotId
    skill: str
    n: int
    fence: int
    new_fence: bool
    stop_generation: int
    epoch: int
    digest: bytes
    accepted_ns: int
    expires_ns: int
    letter: Letter | None = None


class Refused(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """A request was refused. Durable before it is told, so that a resend finds the same answer."""

    cid: CommandId
    principal: PrincipalId
    code: str
    at_ns: int
    letter: Letter | None = None


class Concluded(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """An order ended, or a resume had no effect. Durable before it is told."""

    cid: CommandId
    ending: str
    at_ns: int
    letter: Letter | None = None


class Placed(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """The message that shows a life exists; later words about it are edits of that message."""

    cid: CommandId
    letter: Letter


class Told(msgspec.Struct, frozen=True, gc=False, tag=True):
    """The end of a life was told to its author."""

    cid: CommandId
    at_ns: int


class Stopped(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """A stop was applied. Written after its effect (I10).

    Attributes:
        gap: The record was not writable when the stop was applied.
        repeated: They had stopped it within a minute, and it was stopped still: the record keeps
            its generation, and no row. How many there were is how far the generations of two rows
            are apart.
    """

    robot: RobotId
    generation: int
    principal: PrincipalId
    at_ns: int
    gap: bool = False
    repeated: bool = False


class Resumed(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """A stop is undone, by somebody who may. Durable before its effect.

    One that had none, as it was too late or the robot could not be let go, is ``Concluded``.
    """

    cid: CommandId
    robot: RobotId
    generation: int
    principal: PrincipalId
    at_ns: int


class Enrolled(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """A person or a robot became known. The letter holds the name and the addresses."""

    principal: PrincipalId
    roles: tuple[str, ...]
    at_ns: int
    letter: Letter


class KeyIssued(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """An authorisation key was given."""

    key: AuthorisationKey


class KeyRevoked(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """An authorisation key was taken back; for ever."""

    key: KeyId
    by: PrincipalId
    at_ns: int


class Selected(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """A person chose a robot for a chat; an empty robot undoes the choice.

    ``chat`` is a digest, so that the open part names nobody.
    """

    principal: PrincipalId
    chat: bytes
    robot: str


class Seeded(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """A person of the configuration file was taken over once; the file has no say in it again."""

    name_digest: bytes
    principal: PrincipalId


class Fact(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """Something that is so from now on, until another fact of the same kind and key replaces it.

    What the rooms know besides commands: slots, invitations, grants, preferences. The store keeps
    the newest of each kind and key and asks nothing about what it says.

    Attributes:
        kind: Which room keeps it, and how ``body`` is read: ``slot``, ``invitation``.
        key: Unique among its kind.
        body: In the open: ids, numbers and digests only. Empty: it is not so any more.
        letter: What can name a person or repeat their words.
    """

    kind: str
    key: str
    body: bytes
    letter: Letter | None = None


class Decided(msgspec.Struct, frozen=True, gc=False, kw_only=True, tag=True):
    """An administrative act: who let it happen, and about whom. Durable before its effect.

    Attributes:
        act: ``invite``, ``enrol``, ``lock``, ``book``.
        about: Id of the principal, robot, key or fact that it is about.
        digest: Of what was decided.
    """

    act: str
    by: PrincipalId
    about: str
    at_ns: int
    digest: bytes = b""


Record: TypeAlias = (
    Claimed
    | Refused
    | Concluded
    | Placed
    | Told
    | Stopped
    | Resumed
    | Enrolled
    | KeyIssued
    | KeyRevoked
    | Selected
    | Seeded
    | Fact
    | Decided
)


class PersonRecord(msgspec.Struct, frozen=True):
    """What the letter of ``Enrolled`` holds."""

    name: str
    addresses: tuple[Address, ...]


class Unfinished(msgspec.Struct, frozen=True, kw_only=True):
    """A life that the last run did not finish.

    Attributes:
        ending: None for a claim without an outcome: unknown, never repeated.
        claim: The letter of the claim or the refusal: where to answer.
        words: The letter of the outcome, if there is one.
        placed: The letter of the message that shows the life, if there is one.
    """

    cid: CommandId
    principal: PrincipalId
    robot: RobotId
    skill: str
    ending: str | None
    claim: bytes | None
    words: bytes | None
    placed: bytes | None


class Memory(msgspec.Struct, frozen=True, kw_only=True):
    """What a gateway has to know before it takes the first message.

    Attributes:
        numbers: Robot to its highest order number and its fence (I13).
        generations: Robot to its highest recorded stop generation.
        facts: Kind to what is so, in the order in which it was first written.
    """

    enrolled: tuple[Enrolled, ...] = ()
    keys: tuple[AuthorisationKey, ...] = ()
    seeded: tuple[Seeded, ...] = ()
    selected: tuple[Selected, ...] = ()
    numbers: dict[RobotId, tuple[int, int]] = {}
    generations: dict[RobotId, int] = {}
    unfinished: tuple[Unfinished, ...] = ()
    facts: dict[str, tuple[Fact, ...]] = {}
