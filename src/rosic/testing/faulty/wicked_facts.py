"""Stores that break the rules of facts, one each."""
# ruff: noqa: D102 - a sinner's sin is its own

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.records import Fact
from rosic.testing.faulty.wicked import FaultyStore

if TYPE_CHECKING:
    from rosic.core.records import Memory, Record

replace = msgspec.structs.replace


class ForgetsFacts(FaultyStore):
    """Knows only what was said today."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, facts={})


class KeepsTheFirstFact(FaultyStore):
    """Is not to be convinced of anything else."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if not isinstance(record, Fact):
            return (record,)
        first = self.diary.setdefault((record.kind, record.key), record)
        return (record,) if first is record else ()


class KeepsFactsThatWereTakenBack(FaultyStore):
    """Does not hear that something is not so any more."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        return () if isinstance(record, Fact) and not record.body else (record,)


class PutsTheLatestLast(FaultyStore):
    """Takes whatever is said again for something new."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if not isinstance(record, Fact) or not record.body:
            return (record,)
        return (replace(record, body=b"", letter=None), record)
