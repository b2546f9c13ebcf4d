"""What was asked for before, as it is read back from the record."""

from __future__ import annotations

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.robot import RobotId

REFUSED, RESUMED = "refused", "resumed"


class HistoryQuery(msgspec.Struct, frozen=True, kw_only=True):
    """Which commands are asked about; an empty word asks about all.

    Attributes:
        since_ns: Wall clock; nothing older.
        limit: At most so many, the newest.
    """

    principal: PrincipalId = ""
    robot: RobotId = ""
    since_ns: int = 0
    limit: int = 20


class HistoryEntry(msgspec.Struct, frozen=True, kw_only=True):
    """One command of one person.

    Attributes:
        kind: ``claimed``, ``refused`` or ``resumed``.
        robot: Empty for a refusal: what was refused was no order to a robot yet.
        outcome: How it ended, or why it was refused, as a word for programs; empty while it runs.
        letter: The sealed words of the claim or the refusal, unsealed; None once they are erased.
        words: How the end was told.
    """

    principal: PrincipalId
    kind: str
    at_ns: int
    robot: RobotId = ""
    skill: str = ""
    outcome: str = ""
    ended_ns: int | None = None
    letter: bytes | None = None
    words: bytes | None = None
