"""Who lets whom read what of one's own shared data, and until when. By name, never as a whole."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.core.i18n import said, said_n
from rosic.core.identity import RECORD_ID_BYTES, PrincipalId
from rosic.core.language.sanitise import quote
from rosic.core.records import Fact, Letter
from rosic.errors import NotUnderstood, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock, Entropy


# ---- sentences ----


def lent_enough(most: int) -> str:
    """Return that sharing has its bounds."""
    return said_n(
        "You can share {n} thing at most, and you do. Nothing has changed. Take one back first.",
        "You can share {n} things at most, and you do. Nothing has changed. Take one back first.",
        most,
    )


def not_lent(name: str) -> str:
    """Return that there is nothing to take back."""
    return said("You share nothing called {name} so. Nothing has changed.", name=quote(name))


LOAN: Final = "shelf-loan"
LOANS_MOST: Final = 64

Reader: TypeAlias = str
"""Who may read: a principal's id, or a robot's, which stands for everybody who sees it."""

log = logging.getLogger("rosic.container")


class SharedDataGrant(msgspec.Struct, frozen=True, gc=False):
    """One name that somebody may read.

    Attributes:
        until_ns: Wall clock; 0: until it is taken back.
    """

    id: str
    owner: PrincipalId
    reader: Reader
    name: str
    until_ns: int


class _Body(msgspec.Struct, frozen=True):
    owner: PrincipalId
    reader: Reader
    until_ns: int


_encode = msgspec.msgpack.Encoder().encode
_read_body = msgspec.msgpack.Decoder(_Body).decode


class SharedDataAccess:
    """Every loan. In the open stand ids and an end; which name it is, its owner's key seals.

    Args:
        clock: Says when a loan is over.
        entropy: Makes ids.
        sees: Whether somebody may read a robot; False for what is no robot.
    """

    def __init__(
        self, clock: Clock, entropy: Entropy, sees: Callable[[PrincipalId, Reader], bool]
    ) -> None:
        self._clock = clock
        self._entropy = entropy
        self._sees = sees
        self._at: dict[str, SharedDataGrant] = {}
        self._by: dict[PrincipalId, dict[str, SharedDataGrant]] = {}
        self._to: dict[Reader, dict[str, SharedDataGrant]] = {}

    # ---- asking ----

    def may_read(self, reader: PrincipalId, owner: PrincipalId, name: str) -> bool:
        """Whether a name was lent to somebody, or to a robot that they see."""
        return any(
            loan.name == name and (loan.reader == reader or self._sees(reader, loan.reader))
            for loan in self.by(owner)
        )

    def by(self, owner: PrincipalId) -> tuple[SharedDataGrant, ...]:
        """Return what somebody lends now, by name."""
        return self._good(self._by.get(owner, {}).values())

    def to(self, readers: Iterable[Reader]) -> tuple[SharedDataGrant, ...]:
        """Return what is lent to any of these now, by name."""
        return self._good(loan for reader in readers for loan in self._to.get(reader, {}).values())

    def _good(self, loans: Iterable[SharedDataGrant]) -> tuple[SharedDataGrant, ...]:
        now_ns = self._clock.wall_ns()
        found = [loan for loan in loans if not loan.until_ns or loan.until_ns > now_ns]
        return tuple(sorted(found, key=lambda loan: (loan.name, loan.owner, loan.reader)))

    # ---- deciding ----

    def lend(
        self, owner: PrincipalId, reader: Reader, name: str, *, until_ns: int = 0
    ) -> tuple[Fact, ...]:
        """Decide that somebody may read a name; what was lent to them of it before ends.

        Raises:
            TooManyRequests: As much is lent as can be. Nothing has changed.
        """
        before = [
            loan
            for loan in self._by.get(owner, {}).values()
            if (loan.reader, loan.name) == (reader, name)
        ]
        over = [loan for loan in self._by.get(owner, {}).values() if loan not in self.by(owner)]
        if len(self.by(owner)) - len(before) >= LOANS_MOST:
            raise TooManyRequests(lent_enough(LOANS_MOST), retry_after_s=0.0)
        fresh = Fact(
            kind=LOAN,
            key=self._entropy.token(RECORD_ID_BYTES).hex(),
            body=_encode(_Body(owner, reader, until_ns)),
            letter=Letter(owner, _encode(name)),
        )
        ended = {loan.id: _no_more(loan) for loan in (*before, *over)}
        return (*ended.values(), fresh)

    def take_back(self, owner: PrincipalId, name: str, reader: Reader = "") -> tuple[Fact, ...]:
        """Decide that a name is lent no longer: to one, or to nobody.

        Raises:
            NotUnderstood: It is not lent.
        """
        found = [loan for loan in self.by(owner) if loan.name == name]
        found = [loan for loan in found if not reader or loan.reader == reader]
        if not found:
            raise NotUnderstood(not_lent(name))
        return tuple(map(_no_more, found))

    def end_name(self, owner: PrincipalId, name: str) -> tuple[Fact, ...]:
        """Return what ends every loan of a name that is removed."""
        loans = self._by.get(owner, {}).values()
        return tuple(_no_more(loan) for loan in loans if loan.name == name)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends everything that somebody lends or was lent."""
        found = {**self._by.get(principal, {}), **self._to.get(principal, {})}
        return tuple(map(_no_more, found.values()))

    # ---- what is so ----

    def apply(self, fact: Fact) -> None:
        """Let a fact be so.

        Raises:
            msgspec.MsgspecError: It cannot be read.
        """
        before = self._at.pop(fact.key, None)
        if before is not None:
            _drop(self._by, before.owner, before)
            _drop(self._to, before.reader, before)
        if not fact.body or fact.letter is None:
            return  # taken back, or its owner was erased
        body = _read_body(fact.body)
        name = msgspec.msgpack.decode(fact.letter.content, type=str)
        loan = SharedDataGrant(fact.key, body.owner, body.reader, name, body.until_ns)
        self._at[loan.id] = loan
        self._by.setdefault(loan.owner, {})[loan.id] = loan
        self._to.setdefault(loan.reader, {})[loan.id] = loan


def _drop(index: dict[str, dict[str, SharedDataGrant]], key: str, loan: SharedDataGrant) -> None:
    del index[key][loan.id]
    if not index[key]:
        del index[key]


def _no_more(loan: SharedDataGrant) -> Fact:
    return Fact(kind=LOAN, key=loan.id, body=b"")
