"""What the record says happened: counted from what was written, not from what was meant."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from rosic.core.records import Claimed, Concluded, Refused, Stopped
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from typing import Any

    from rosic.core.identity import CommandId
    from rosic.core.records import Record
    from rosic.core.robot.profile import RobotId


# By the code of the refusal (`rosic.errors`): what a play's script can meet, in words.
WHY: Final = {
    "expired": "it came too late",
    "not-permitted": "that person has no right to it",
    "not-understood": "the robot or command is not known to that person",
    "out-of-bounds": "a value was out of its bounds",
    "robot-busy": "the robot was busy",
    "robot-offline": "the robot was not there",
    "robot-stopped": "the robot was stopped",
    "robot-taken": "the robot was somebody else's at that time",
    "take-over": "taking it over from somebody had to be said",
    "too-many-requests": "there were too many at once",
}
ELSE: Final = "of something else"


class RecordingStore(MemoryStore):
    """A record in memory that can be read again as it was written.

    Attributes:
        claims, endings: Orders, by command.
        refusals: Code of the reason, by command.
        stops: By robot and generation.
    """

    def __init__(self) -> None:
        super().__init__()
        self.claims: dict[CommandId, Claimed] = {}
        self.endings: dict[CommandId, str] = {}
        self.refusals: dict[CommandId, str] = {}
        self.stops: dict[tuple[RobotId, int], Stopped] = {}

    async def write(self, *records: Record) -> None:
        """Write, then note what it was."""
        await super().write(*records)
        self._look(records)

    def keep(self, record: Record, then: Any) -> None:  # noqa: ANN401 - as the store has it
        """Write at once, then note what it was."""
        super().keep(record, then)
        self._look((record,))

    def note(self, *records: Record) -> None:
        """Write some time, and note what it was."""
        super().note(*records)
        self._look(records)

    def _look(self, records: tuple[Record, ...]) -> None:
        for record in records:
            if isinstance(record, Claimed):
                self.claims[record.cid] = record
            elif isinstance(record, Concluded):
                self.endings[record.cid] = record.ending
            elif isinstance(record, Refused):
                self.refusals[record.cid] = record.code
            elif isinstance(record, Stopped):
                self.stops[record.robot, record.generation] = record

    def lines(self, names: Mapping[str, str], robots: Mapping[str, str]) -> Iterator[str]:
        """Yield what happened.

        Args:
            names: Of people, by principal.
            robots: How each is shown.
        """
        ends = Counter(self.endings.get(cid, "not ended") for cid in self.claims)
        told = ", ".join(f"{count} {ending}" for ending, count in sorted(ends.items()))
        yield f"{counted(len(self.claims), 'order')} accepted: {told or 'none'}."
        yield self._told_refusals()
        stopped = dict.fromkeys(robots.get(stop.robot, stop.robot) for stop in self.stops.values())
        yield f"Stopped: {', '.join(stopped)}." if stopped else "Nobody said stop."
        for robot, shown in robots.items():
            had = Counter(
                names.get(claim.principal, "?")
                for claim in self.claims.values()
                if claim.robot == robot
            )
            if had:
                whose = ", ".join(f"{name} ({counted(n, 'order')})" for name, n in had.items())
                yield f"{shown} worked for {whose}."

    def _told_refusals(self) -> str:
        if not self.refusals:
            return "Nobody was refused anything."
        reasons = Counter(WHY.get(code, ELSE) for code in self.refusals.values())
        told = ", ".join(f"{count} because {why}" for why, count in reasons.most_common())
        return f"{counted(len(self.refusals), 'request')} refused: {told}."


def counted(number: int, what: str) -> str:
    """Return a number with its noun: ``1 order``, ``3 orders``."""
    return f"{number} {what}{'s' * (number != 1)}"
