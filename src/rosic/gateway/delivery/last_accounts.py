"""By which of their accounts people spoke last.

In memory, and looked up only. What a restart would not know by itself is a fact in the person's own
container: somebody with one account, whom one messenger of ours reaches, has none.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import Address, PrincipalId
from rosic.core.records import Fact, Letter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.authoriser.directory import Directory
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Inbound

KIND: Final = "last-accounts"
ACCOUNTS_AT_MOST: Final = 16
"""Of one person, by each of our own accounts on their messenger."""

log = logging.getLogger("rosic.delivery")


class HeardAccount(msgspec.Struct, frozen=True, array_like=True):
    """An account of somebody, and by which messenger of ours it was heard."""

    messenger: str
    address: Address


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(tuple[HeardAccount, ...]).decode


class LastAccounts:
    """Of everybody, the accounts by which they were heard, the newest first.

    Args:
        directory: Knows whose an account is.
        note: Writes down what is so already, and waits for no disk.
    """

    def __init__(self, directory: Directory, note: Callable[[Fact], None]) -> None:
        self._directory, self._note = directory, note
        self._heard: dict[PrincipalId, tuple[HeardAccount, ...]] = {}
        self._kept: set[PrincipalId] = set()

    def of(self, principal: PrincipalId) -> tuple[HeardAccount, ...]:
        """Return by which accounts somebody was heard, the newest first."""
        return self._heard.get(principal, ())

    def heard(self, messenger: Messenger, inbound: Inbound, principal: PrincipalId) -> None:
        """Note by which account somebody speaks. A page, where nobody is found again, is none."""
        person = self._directory.person(principal)
        if person is None or inbound.sender not in person.addresses:
            return
        here = HeardAccount(messenger.name, inbound.sender)
        others = [one for one in self.of(principal) if one != here]
        self._set(principal, (here, *others)[:ACCOUNTS_AT_MOST])

    def forget_account(self, principal: PrincipalId, address: Address) -> None:
        """Let go of an account that somebody has lost."""
        self._set(principal, tuple(one for one in self.of(principal) if one.address != address))

    def _set(self, principal: PrincipalId, accounts: tuple[HeardAccount, ...]) -> None:
        if accounts == self.of(principal):
            return
        self._heard[principal] = accounts
        person = self._directory.person(principal)
        if len(accounts) > 1 or (accounts and person is not None and len(person.addresses) > 1):
            self._kept.add(principal)
            letter = Letter(principal, _encode(accounts))
            self._note(Fact(kind=KIND, key=principal, body=b"\x01", letter=letter))
        elif principal in self._kept:
            self._kept.discard(principal)
            self._note(Fact(kind=KIND, key=principal, body=b""))

    # ---- the record ----

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what lets go of all of it, for somebody who is erased."""
        there = principal in self._kept
        return (Fact(kind=KIND, key=principal, body=b""),) if there else ()

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. What cannot be read is learnt anew."""
        self._heard.pop(fact.key, None)
        self._kept.discard(fact.key)
        if not fact.body or fact.letter is None:
            return
        try:
            self._heard[fact.key] = _decode(fact.letter.content)
        except msgspec.MsgspecError:
            log.warning("where somebody was last cannot be read; they are told everywhere")
            return
        self._kept.add(fact.key)
