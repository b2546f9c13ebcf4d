"""Who has a good code and waits for an admin's tap."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, ClassVar

import msgspec

from rosic.authoriser.admission import Applicant, PendingApplicant
from rosic.core.records import Fact, Letter, PersonRecord

if TYPE_CHECKING:
    from rosic.core.identity import Address

_log = logging.getLogger(__name__)
_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(PendingApplicant).decode
_decode_card = msgspec.msgpack.Decoder(PersonRecord).decode


class Applicants:
    """Everybody who waits, by the id of the question and by address. One question an address."""

    KIND: ClassVar[str] = "pending"

    def __init__(self) -> None:
        self._waiting: dict[str, Applicant] = {}
        self._at: dict[tuple[str, str], str] = {}

    def get(self, pending: str) -> Applicant | None:
        """Return who waits under an id."""
        return self._waiting.get(pending)

    def at(self, address: Address) -> Applicant | None:
        """Return who waits at an address."""
        pending = self._at.get((address.platform, address.account))
        return None if pending is None else self._waiting.get(pending)

    def all(self) -> tuple[Applicant, ...]:
        """Return everybody who waits."""
        return tuple(self._waiting.values())

    def words(self) -> frozenset[str]:
        """Return the words shown now, so that no two questions show the same."""
        return frozenset(applicant.words for applicant in self._waiting.values())

    def fact(self, applicant: Applicant) -> Fact:
        """Return what makes somebody wait."""
        asked = applicant.pending
        card = _encode(PersonRecord(applicant.name, (applicant.address,)))
        letter = Letter(asked.principal, card)
        return Fact(kind=self.KIND, key=asked.id, body=_encode(asked), letter=letter)

    def gone(self, pending: str) -> Fact:
        """Return what settles a question."""
        return Fact(kind=self.KIND, key=pending, body=b"")

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. Whoever cannot be read has to come with a new code."""
        before = self._waiting.pop(fact.key, None)
        if before is not None:
            self._at.pop((before.address.platform, before.address.account), None)
        if not fact.body:
            return
        applicant = _read(fact)
        if applicant is None:
            _log.warning("somebody who waits for an admin cannot be read; they need a new code")
            return
        self._waiting[fact.key] = applicant
        self._at[applicant.address.platform, applicant.address.account] = fact.key


def _read(fact: Fact) -> Applicant | None:
    try:
        asked = _decode(fact.body)
        if fact.letter is None or asked.id != fact.key:
            return None
        card = _decode_card(fact.letter.content)
    except msgspec.MsgspecError:
        return None
    return Applicant(asked, card.name, card.addresses[0]) if card.addresses else None
