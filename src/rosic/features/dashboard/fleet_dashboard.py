"""The bird's-eye view as a live card: one message that is edited in place, beside `/card`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.message import ChatKind
from rosic.features.dashboard import messages as words
from rosic.features.dashboard.dashboard import RobotSnapshots
from rosic.features.dashboard.dashboards import Dashboards
from rosic.features.dashboard.rendering import ROBOTS_AT_MOST, DashboardRendering

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId
    from rosic.features.dashboard.rendering import DashboardQueries
    from rosic.gateway.chat_dashboards import FleetStatus
    from rosic.gateway.transactions import Transactions

FLEET_CARD: Final = "fleet-card"


class FleetSnapshots(RobotSnapshots):
    """Looks at robots and tasks together; its number grows when either is not as it was."""

    def __init__(self, overview: FleetStatus) -> None:
        self._overview = overview
        self._settled: tuple[object, ...] = ()
        self._number = 0

    def begin(self) -> None:
        """Nothing is followed: what robots do for tasks is known."""

    def end(self) -> None:
        """Nothing is followed."""

    def look(self, robots: Iterable[RobotId]) -> None:
        """Look at these robots, and at every task."""
        settled = self._overview.settled(sorted(robots))
        if settled != self._settled:
            self._settled = settled
            self._number += 1

    def number(self, robot: RobotId) -> int:  # noqa: ARG002 - the same for all of them
        """Return how often there was something new to see."""
        return self._number


class FleetRendering(DashboardRendering):
    """Makes the fleet into a message."""

    def __init__(
        self,
        snapshots: FleetSnapshots,
        sides: DashboardQueries,
        clock: Clock,
        overview: FleetStatus,
    ) -> None:
        super().__init__(snapshots, sides, clock, None)  # nobody looks through a fleet
        self._overview = overview

    def text(
        self,
        chat: Chat,
        owner: PrincipalId,
        robots: tuple[RobotId, ...],
        most: int = ROBOTS_AT_MOST,
    ) -> str:
        """Return how the fleet is."""
        del most
        alone = chat.kind is ChatKind.PRIVATE
        who = owner if alone else ""  # others read along: nobody's own words
        lines = list(self._overview.lines(robots, self._clock.wall_ns(), who))
        if chat.kind is ChatKind.GROUP:
            lines.insert(0, words.as_they_see(self._sides.name_of(owner)))
        return joined("\n", lines)


class FleetDashboards(Dashboards):
    """All cards of the fleet; at most one a chat."""

    kind = FLEET_CARD

    def __init__(
        self,
        overview: FleetStatus,
        changes: Transactions,
        messengers: Iterable[Messenger],
        clock: Clock,
        sides: DashboardQueries,
    ) -> None:
        self.snapshots = FleetSnapshots(overview)
        super().__init__(self.snapshots, changes, messengers, clock, sides, None)
        self.drawing = FleetRendering(self.snapshots, sides, clock, overview)
