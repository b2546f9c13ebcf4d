"""A person's phone as a second step: what is kept of it, its set-up, a right code."""

from __future__ import annotations

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.identity import PrincipalId
from rosic.core.message import Chat
from rosic.core.records import Record
from rosic.core.secret import Secret


class TotpDevice(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the principal, its letter the secret.

    Attributes:
        last_step: The newest half minute whose code was used.
        since_ns: When it was set up; wall clock.
    """

    last_step: int
    since_ns: int


class TotpSetup(msgspec.Struct, frozen=True):
    """What a phone needs, once, until the first code has come back.

    Attributes:
        uri: For a QR picture.
        key: The same to be typed.
    """

    uri: Secret
    key: Secret

    @property
    def sentence(self) -> str:
        """Return what stands under the picture; it holds the secret."""
        return words.scan(self.key.reveal())


class TotpProof(msgspec.Struct, frozen=True):
    """A right code. It counts as soon as the records are written and applied, by `admit`.

    Attributes:
        sentence: For the person, once it counts.
    """

    principal: PrincipalId
    chat: Chat
    step: int
    records: tuple[Record, ...]
    sentence: str
