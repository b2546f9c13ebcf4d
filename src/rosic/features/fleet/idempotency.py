"""Which messages have had their effect on tasks: the same message never has it twice (I1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.records import Fact
from rosic.core.time_units import DAY_NS
from rosic.errors import Repeated

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.core.identity import CommandId

KIND: Final = "task-origin"
KEPT_NS: Final = 31 * DAY_NS
FORGOTTEN_AT_ONCE: Final = 100

_encode = msgspec.msgpack.Encoder().encode
_at_ns = msgspec.msgpack.Decoder(int).decode


class IdempotencyKeys:
    """Ids of lines, and when they were followed; wall clock."""

    def __init__(self) -> None:
        self._seen: dict[str, int] = {}

    def check(self, cid: CommandId) -> None:
        """See that a line was not followed before.

        Raises:
            Repeated: It was.
        """
        if cid.hex() in self._seen:
            raise Repeated(said("This was done already."))

    def facts(self, cid: CommandId, now_ns: int) -> Iterator[Fact]:
        """Yield what remembers a line, and lets some go that cannot come again."""
        yield Fact(kind=KIND, key=cid.hex(), body=_encode(now_ns))
        over: list[str] = []
        for key, at_ns in self._seen.items():  # the oldest first
            if at_ns > now_ns - KEPT_NS or len(over) >= FORGOTTEN_AT_ONCE:
                break
            over.append(key)
        yield from (Fact(kind=KIND, key=key, body=b"") for key in over)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read was followed all the same."""
        self._seen.pop(fact.key, None)
        if fact.body:
            try:
                self._seen[fact.key] = _at_ns(fact.body)
            except msgspec.MsgspecError:
                self._seen[fact.key] = 0
