"""How often somebody was turned away, by kind. Kinds are fixed words, so the table is small."""

from __future__ import annotations

import logging
from collections import Counter
from typing import Final, TypeVar

import msgspec

from rosic.core.records import Fact
from rosic.errors import Refusal

KIND: Final = "tally"
KEY: Final = "attempts"

R = TypeVar("R", bound=Refusal)

_log = logging.getLogger(__name__)
_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(dict[str, int]).decode


class Counters:
    """Counts of unauthorised attempts.

    Counted at once, in memory; written now and then, so that a restart loses little.
    """

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._written = 0

    def count(self, kind: str) -> None:
        """Count one attempt of a kind: ``code-used``, ``totp-replayed``."""
        self._counts[kind] += 1

    def refuse(self, kind: str, refusal: R) -> R:
        """Count an attempt and return its refusal, so that nobody counts it again."""
        self.count(kind)
        return refusal.reported()

    def __getitem__(self, kind: str) -> int:
        return self._counts[kind]

    def by_kind(self) -> dict[str, int]:
        """Return the counts, the most frequent first."""
        return dict(self._counts.most_common())

    def due(self) -> tuple[Fact, ...]:
        """Return the fact to write, if anything was counted since the last."""
        if self._counts.total() == self._written:
            return ()
        return (Fact(kind=KIND, key=KEY, body=_encode(dict(self._counts))),)

    def apply(self, fact: Fact) -> None:
        """Take over what was written, now or in an earlier run; no count ever falls."""
        try:
            counts = _decode(fact.body)
        except msgspec.MsgspecError:
            _log.warning("the count of attempts cannot be read and begins anew")
            return
        for kind, count in counts.items():
            self._counts[kind] = max(self._counts[kind], count)
        self._written = sum(counts.values())
