"""How a change of times is written down: who decided it, and what was decided."""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING

from rosic.core.records import Decided, Fact

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Record

_DIGEST_BYTES = 16


def decided(act: str, by: PrincipalId, at_ns: int, facts: tuple[Fact, ...]) -> tuple[Record, ...]:
    """Return facts with who decided them before them; the first fact is what it is about."""
    digest = blake2b(digest_size=_DIGEST_BYTES)
    for fact in facts:
        digest.update(ascii((fact.kind, fact.key)).encode())
        digest.update(fact.body)
    about = facts[0].key
    return (Decided(act=act, by=by, about=about, at_ns=at_ns, digest=digest.digest()), *facts)
