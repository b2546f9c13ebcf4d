"""The record: what happened, in order, each entry with a sequence number and the server's time.

The token of the bot is never part of it.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.testing.telegram.settings import ServerClock
    from rosic.testing.telegram.state import JsonObject


class Journal:
    """Grows only, until a test clears it.

    Attributes:
        changes: Every entry: `seq`, `time_s`, `kind`, and what belongs to the kind.
        calls: The entries of kind "call", completed when the answer is known.
        violations: The entries of kind "violation".
    """

    def __init__(self, clock: ServerClock, report: Callable[[str], None]) -> None:
        self._clock = clock
        self._report = report
        self._more = asyncio.Event()
        self._seq = 0
        self.changes: list[JsonObject] = []
        self.calls: list[JsonObject] = []
        self.violations: list[JsonObject] = []

    @property
    def seq(self) -> int:
        """The number of the newest entry; 0 before the first."""
        return self._seq

    def add(self, kind: str, **fields: object) -> JsonObject:
        """Write one entry and wake who waits for it."""
        self._seq += 1
        entry: JsonObject = {"seq": self._seq, "time_s": self._clock.now_s(), "kind": kind}
        entry.update(fields)
        self.changes.append(entry)
        self._more.set()
        self._more = asyncio.Event()
        return entry

    def call(self, method: str, parameters: JsonObject) -> JsonObject:
        """Write down a call as it arrives; the caller completes the entry when it is answered."""
        entry = self.add("call", method=method, parameters=parameters, code=None)
        self.calls.append(entry)
        return entry

    def violation(self, method: str, reason: str) -> None:
        """Write down, and report, something a correct client does not do."""
        self.violations.append(self.add("violation", method=method, reason=reason))
        self._report(f"violation: {method}: {reason}")

    def since(self, after: int, kinds: Collection[str] = ()) -> list[JsonObject]:
        """Return the entries numbered above `after`, of these kinds or of all."""
        first = next((i for i, c in enumerate(reversed(self.changes)) if c["seq"] <= after), None)
        tail = self.changes if first is None else self.changes[len(self.changes) - first :]
        return [c for c in tail if not kinds or c["kind"] in kinds]

    async def wait(
        self, after: int, timeout_s: float, kinds: Collection[str] = ()
    ) -> list[JsonObject]:
        """Return the entries above `after`, waiting for the first of them.

        Returns:
            An empty list when none came within `timeout_s`.
        """
        deadline_s = asyncio.get_running_loop().time() + timeout_s
        while not (found := self.since(after, kinds)):
            more = self._more
            left_s = deadline_s - asyncio.get_running_loop().time()
            if left_s <= 0:
                return []
            try:
                await asyncio.wait_for(more.wait(), left_s)
            except TimeoutError:
                return self.since(after, kinds)
        return found

    def clear(self) -> None:
        """Forget the entries; the numbering goes on."""
        self.changes.clear()
        self.calls.clear()
        self.violations.clear()
