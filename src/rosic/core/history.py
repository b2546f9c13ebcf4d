"""What was asked for before, as it is read back from the record."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import msgspec

from rosic.core.identity import CommandId, PrincipalId
from rosic.core.robot.profile import RobotId

if TYPE_CHECKING:
    from collections.abc import Iterable

REFUSED, RESUMED, STOPPED = "refused", "resumed", "stopped"


class HistoryQuery(msgspec.Struct, frozen=True, kw_only=True):
    """Which commands are asked about; an empty word asks about all.

    Attributes:
        cid: That command alone.
        since_ns: Wall clock; nothing older.
        limit: At most so many, the newest.
    """

    principal: PrincipalId = ""
    robot: RobotId = ""
    cid: CommandId = b""
    since_ns: int = 0
    limit: int = 20


class HistoryEntry(msgspec.Struct, frozen=True, kw_only=True):
    """One command of one person, or one robot that they stopped.

    Attributes:
        kind: ``claimed``, ``refused``, ``resumed`` or ``stopped``.
        robot: Empty for a refusal: what was refused was no order to a robot yet.
        n: The robot's order number; 0: it was no order.
        outcome: How it ended, or why it was refused, as a word for programs; empty while it runs.
        letter: The sealed words of the claim or the refusal, unsealed; None once they are erased.
        words: How the end was told.
    """

    principal: PrincipalId
    kind: str
    at_ns: int
    robot: RobotId = ""
    skill: str = ""
    n: int = 0
    outcome: str = ""
    ended_ns: int | None = None
    letter: bytes | None = None
    words: bytes | None = None


def with_stops(
    commands: Iterable[HistoryEntry], stops: Iterable[HistoryEntry], limit: int
) -> tuple[HistoryEntry, ...]:
    """Return commands and stops, each the newest first, as one row of at most so many.

    Commands keep their order among each other, whatever a clock that was set back made of it.
    """
    waiting, row = deque(stops), list[HistoryEntry]()
    for command in commands:
        while waiting and waiting[0].at_ns > command.at_ns:
            row.append(waiting.popleft())
        row.append(command)
    return tuple([*row, *waiting][:limit])
