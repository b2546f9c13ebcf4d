"""One message per chat that always shows how robots are, and one that shows the fleet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.message import Outbound
from rosic.features.dashboard.commands import DashboardCommands
from rosic.features.dashboard.dashboard import KIND, RobotSnapshots
from rosic.features.dashboard.dashboards import Dashboards
from rosic.features.dashboard.fleet_dashboard import FLEET_CARD, FleetDashboards
from rosic.features.dashboard.rendering import DashboardQueries
from rosic.gateway.delivery.sender import OutgoingMessage
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel

__all__ = ["DashboardFeature", "setup"]

NEEDS: Final = ("camera", "fleet")
PROVIDES: Final = ("dashboards",)


class DashboardFeature(Feature):
    """The dashboards of all chats.

    Attributes:
        robots: Those that show robots.
        fleet: Those that show the fleet.
    """

    def __init__(self, robots: Dashboards, fleet: Dashboards) -> None:
        self.robots, self.fleet = robots, fleet

    async def run(self) -> None:
        """Look from now on, as long as there are dashboards."""
        self.robots.run()
        self.fleet.run()

    async def close(self) -> None:
        """Look no more. What is shown says by when it should have changed."""
        await self.fleet.close()
        await self.robots.close()

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends every dashboard of somebody."""
        return (*self.robots.end_all(principal), *self.fleet.end_all(principal))


def setup(kernel: Kernel) -> DashboardFeature:
    """Show in chats how robots are, and go on with the dashboards of earlier runs."""
    rooms, pipeline, chat_sender = kernel.rooms, kernel.pipeline, kernel.orders.chat_sender
    organiser = rooms.organiser

    def sees(principal: PrincipalId) -> frozenset[RobotId]:
        """Return what somebody may see now who is not asking: they must be able to ask."""
        if principal in organiser.locked or kernel.access.keys.current(principal) is None:
            return frozenset()
        return organiser.visible(principal)

    def tell(messenger: Messenger, chat: Chat, text: str) -> None:
        chat_sender.say(OutgoingMessage(messenger, Outbound(chat=chat, text=text)))

    sides = DashboardQueries(
        sees=sees,
        reads=kernel.reach.may_read,
        name_of=organiser.name_of,
        shown=lambda robot: rooms.profiles[robot].shown,
        face=pipeline.face,
        tell=tell,
        catalogue=chat_sender.languages.of,
        issue=rooms.authoriser.buttons.issue,
    )
    line = kernel.assessment.line
    snapshots = RobotSnapshots(rooms, pipeline.executor, pipeline.face, line)
    messengers, camera = kernel.messengers, kernel.shared.camera.find()
    robots = Dashboards(snapshots, kernel.changes, messengers, kernel.clock, sides, camera)
    robots.restore(kernel.memory.facts.get(KIND, ()))
    overview = kernel.shared.fleet.get()
    fleet = FleetDashboards(overview, kernel.changes, messengers, kernel.clock, sides)
    fleet.restore(kernel.memory.facts.get(FLEET_CARD, ()))
    for verb, shown, seen in (("card", robots, snapshots), ("fleet", fleet, fleet.snapshots)):
        handler = DashboardCommands(shown, seen, rooms.vocabularies, sides, verb=verb)
        kernel.commands.register(verb, handler.card)
    feature = DashboardFeature(robots, fleet)
    kernel.shared.dashboards.provide(robots)
    kernel.erasure.join(records=feature.end_all)
    return feature
