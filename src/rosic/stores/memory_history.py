"""What a record in memory says of commands that are over."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core.history import STOPPED, HistoryEntry, HistoryQuery, with_stops
from rosic.core.records import Claimed, Concluded, Refused, Resumed, Stopped

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.identity import CommandId
    from rosic.core.records import Letter

COMMANDS_KEPT: Final = 10_000


class MemoryHistory:
    """Keeps the newest commands, also those whose author has heard how they ended."""

    def __init__(self) -> None:
        self._asked: deque[Claimed | Refused | Resumed] = deque(maxlen=COMMANDS_KEPT)
        self._came: dict[CommandId, Concluded] = {}
        self._stops: deque[Stopped] = deque(maxlen=COMMANDS_KEPT)

    def _keep_past(self, record: Claimed | Refused | Resumed | Concluded) -> None:
        if isinstance(record, Concluded):
            self._came.setdefault(record.cid, record)
            return
        if len(self._asked) == COMMANDS_KEPT:
            self._came.pop(self._asked[0].cid, None)
        self._asked.append(record)

    def _forget_words(self, container: str) -> None:
        """Read no more what one person's commands said, up to now."""
        kept = (_without(record, container) for record in self._asked)
        self._asked = deque(kept, maxlen=COMMANDS_KEPT)
        self._came = {cid: _ended_without(c, container) for cid, c in self._came.items()}

    async def history(self, query: HistoryQuery) -> tuple[HistoryEntry, ...]:
        """Return commands, the newest first, at most as many as are asked for."""
        found: list[HistoryEntry] = []
        for record in reversed(self._asked):
            if len(found) >= query.limit:
                break
            entry = self._entry(record)
            ours = query.principal in {"", entry.principal} and query.robot in {"", entry.robot}
            if ours and entry.at_ns >= query.since_ns:
                found.append(entry)
        return with_stops(found, islice(self._stopped_by(query), query.limit), query.limit)

    def _stopped_by(self, query: HistoryQuery) -> Iterator[HistoryEntry]:
        for stop in reversed(self._stops):
            ours = query.principal in {"", stop.principal} and query.robot in {"", stop.robot}
            if ours and stop.at_ns >= query.since_ns:
                yield HistoryEntry(
                    principal=stop.principal, kind=STOPPED, at_ns=stop.at_ns, robot=stop.robot
                )

    def _entry(self, record: Claimed | Refused | Resumed) -> HistoryEntry:
        came = self._came.get(record.cid)
        ended = "" if came is None else came.ending
        return HistoryEntry(
            principal=record.principal,
            kind=type(record).__name__.lower(),
            at_ns=record.accepted_ns if isinstance(record, Claimed) else record.at_ns,
            robot="" if isinstance(record, Refused) else record.robot,
            skill=record.skill if isinstance(record, Claimed) else "",
            outcome=record.code if isinstance(record, Refused) else ended,
            ended_ns=None if came is None else came.at_ns,
            letter=None if isinstance(record, Resumed) else _content(record.letter),
            words=None if came is None else _content(came.letter),
        )


def _content(letter: Letter | None) -> bytes | None:
    return None if letter is None else letter.content


def _without(record: Claimed | Refused | Resumed, container: str) -> Claimed | Refused | Resumed:
    if isinstance(record, Resumed) or record.letter is None:
        return record
    return replace(record, letter=None) if record.letter.container == container else record


def _ended_without(record: Concluded, container: str) -> Concluded:
    if record.letter is None or record.letter.container != container:
        return record
    return replace(record, letter=None)
