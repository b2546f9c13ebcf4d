"""What the doctor finds of a gateway that runs: for whoever looks after it, from elsewhere."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.app.maintenance import lost
from rosic.app.setup.diagnostics import ABOUT, examine_memory
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict, examine_disk
from rosic.contracts.messenger import catching_up
from rosic.contracts.traffic import is_connected
from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.gateway.observed_state import HealthFinding

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock

KEPT_NS: Final = 30 * SECOND_NS
"""What was measured is told again for so long: writing to the disk costs every order a little."""
GOOD, LOOK, NOT_MEASURED = "good", "look", "not-measured"
_VERDICTS: Final = {
    FindingVerdict.GOOD: GOOD,
    FindingVerdict.LOOK: LOOK,
    FindingVerdict.NOT_MEASURED: NOT_MEASURED,
}
IS_THERE: Final = said("All files of the record are there, and it answers in time.")
IS_LATE: Final = said("The record does not answer in time. Nothing that moves is taken on.")
IS_BEHIND: Final = said("It still brings what was sent while nobody listened.")
IS_AWAY: Final = said("Its platform does not answer: nobody is heard by it, and no stop either.")
LISTENS: Final = said("It listens.")


class GatewayHealth:
    """Looks at a running gateway; what takes time is done in a thread, and told for a while.

    Args:
        gateway: Open.
        data: Folder of its record; None: it keeps none.
        clock: The machine's.
    """

    def __init__(self, gateway: Gateway, data: Path | None, clock: Clock) -> None:
        self._gateway, self._data, self._clock = gateway, data, clock
        self._measuring = asyncio.Lock()
        self._measured: tuple[HealthFinding, ...] = ()
        self._measured_ns: int | None = None

    async def findings(self) -> Sequence[HealthFinding]:
        """Return what is found now; of the machine, of half a minute ago at most."""
        async with self._measuring:
            now_ns = self._clock.monotonic_ns()
            if self._measured_ns is None or now_ns - self._measured_ns > KEPT_NS:
                found = await asyncio.to_thread(self._measure)
                self._measured, self._measured_ns = tuple(map(_found, found)), now_ns
        return (*self._record(), *self._measured, *self._messengers(), *self._robots())

    def _measure(self) -> tuple[DiagnosticFinding, ...]:
        disk = () if self._data is None else tuple(examine_disk(self._data))
        return (*disk, examine_memory())

    def _record(self) -> Iterator[HealthFinding]:
        file = self._gateway.record_watch.lost_file()
        late = self._gateway.kernel.changes.late
        text = lost(file) if file else IS_LATE if late else IS_THERE
        yield HealthFinding(ABOUT, LOOK if file or late else GOOD, text)

    def _messengers(self) -> Iterator[HealthFinding]:
        for messenger in self._gateway.kernel.messengers:
            away, behind = is_connected(messenger) is False, catching_up(messenger)
            text = IS_AWAY if away else IS_BEHIND if behind else LISTENS
            yield HealthFinding(messenger.name, LOOK if away or behind else GOOD, text)

    def _robots(self) -> Iterator[HealthFinding]:
        rooms = self._gateway.kernel.rooms
        for robot in rooms.profiles:
            found = rooms.linker.presence(robot)
            if found.online is None:
                yield HealthFinding(robot, NOT_MEASURED, said("Its link cannot tell."))
            elif not found.online:
                yield HealthFinding(robot, LOOK, said("It is not heard."))
            elif rooms.stops[robot].latched:
                yield HealthFinding(robot, GOOD, said("It is heard, and stopped."))
            else:
                yield HealthFinding(robot, GOOD, said("It is heard."))


def _found(finding: DiagnosticFinding) -> HealthFinding:
    return HealthFinding(finding.about, _VERDICTS[finding.verdict], finding.text)
