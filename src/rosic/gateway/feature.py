"""What a capability is to the gateway: made from the kernel, run, told of robots, closed.

Each package of `rosic.features` offers ``setup(kernel) -> Feature``. It takes its commands and
says which facts it keeps while it is made; from then on the gateway only meets it as a `Feature`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from rosic.core.signal import Deferred, Signal
from rosic.gateway.access_registry import admins_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping, Sequence

    from rosic.container.archive import Archive
    from rosic.container.files import StoredFile
    from rosic.container.preferences import PreferenceBook
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.interpreter import Interpreter
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.recording import Recorder
    from rosic.contracts.renderer import Renderer
    from rosic.contracts.robot import FileFolders, Robot, RobotTasks
    from rosic.contracts.store import Store
    from rosic.core.fleet.mission import Mission
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Button
    from rosic.core.policy.roles import Grant
    from rosic.core.records import Fact, Memory, Record, Unfinished
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.gateway.access_registry import AccessRegistry
    from rosic.gateway.chat_dashboards import CameraPreview, ChatDashboards, FleetStatus
    from rosic.gateway.commands import CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.observed_state import (
        HealthFindings,
        HistoryReader,
        OpenAlerts,
        RightsChecker,
        RobotViews,
        TelemetryHistory,
    )
    from rosic.gateway.order_services import AlertTasks, OrderServices
    from rosic.gateway.pending_work import FleetWork, PendingAnswers
    from rosic.gateway.pipeline import Pipeline
    from rosic.gateway.policy_service import PolicyEnforcer
    from rosic.gateway.robot_argument import RobotArgument
    from rosic.gateway.robot_registry import AddedRobot, RobotAdder
    from rosic.gateway.transactions import Transactions

T = TypeVar("T")


class Feature:
    """One capability of a gateway. What it does not need of this it leaves as it is here."""

    @property
    def quiet(self) -> bool:
        """Whether nothing that somebody asked for is under way."""
        return True

    async def restore(self) -> None:
        """Finish what an earlier run has left, before any robot is open."""

    async def recover(self) -> None:
        """Go on after an interruption: robots are open, and interrupted orders are settled."""

    async def run(self) -> None:
        """Do what it does on its own, until cancelled; return if there is nothing."""

    async def each_minute(self) -> None:
        """Do what is due.

        Raises:
            RecordUnavailable: Not all could be written; the rest is tried the next time.
        """

    async def each_day(self) -> None:
        """Forget what was kept as long as was said.

        Raises:
            RecordUnavailable, StoreFault: Not all was forgotten; the rest is tried again soon.
        """

    async def close(self) -> None:
        """Follow nothing any more, and write down what is open. Nobody is heard any more."""

    async def leave(self) -> None:
        """Break off what is under way and keep what was counted. The record is open still."""

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Hear of one more robot, which every room knows by now."""


class RobotAssessment:
    """How robots do, for whoever watches or shows them; the feature that measures it is bound.

    Attributes:
        presence: Returns what a robot reports, with how it does.
        line: Returns what a dashboard says of it; empty for nothing.
    """

    def __init__(self) -> None:
        self.presence: Deferred[[RobotId, Presence], Presence] = Deferred(_as_reported)
        self.line: Deferred[[RobotId], str] = Deferred(_nothing_measured)


class Provided(Generic[T]):
    """A part of one feature that others ask, by a protocol that the kernel holds.

    Args:
        name: What it is, for whoever has put features together in the wrong order.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._part: T | None = None

    def provide(self, part: T) -> None:
        """Say who does it.

        Raises:
            RuntimeError: Somebody does already.
        """
        if self._part is not None:
            raise RuntimeError(f"two features provide {self._name}")
        self._part = part

    def find(self) -> T | None:
        """Return who does it; None while no feature does."""
        return self._part

    def get(self) -> T:
        """Return who does it.

        Raises:
            RuntimeError: No feature that was set up before provides it.
        """
        if self._part is None:
            raise RuntimeError(f"no feature provides {self._name} yet")
        return self._part


class SharedParts:
    """What features ask of one another without knowing each other.

    Attributes:
        camera: Looks at robots for dashboards.
        dashboards: The dashboards that chats have.
        fleet: What is known of robots and their tasks together.
        alert_tasks: What a rule about alarms does with the task of its robot.
        robot_tasks: What robots that help each other do with their tasks.
        engaged: Whether a robot has something else to do than tasks.
        robot_adder: Adds robots while the gateway runs.
        alarm_news: Tells what an alarm says: of which robot, in which words, and whether it begins.
        page_url: Where the page is, if there is one.
        telemetry: What robots reported in the last minutes.
        alerts: Which alarms are open.
        pending: Who waits for an answer about people and rights.
        work: What robots are given to do.
        history: What was asked before, in words.
        views: Makes pictures of what robots show.
        health: Looks at the gateway and its machine.
        explainer: Says what somebody may, and why.
        not_ready: Tells what of this process speaks against leading anybody here, a line each.
        in_doubt: Orders of the last run that ended unseen, settled as this one began; whoever tells
            of orders is made later, and tells of these first.
        grants_ended: Tells of the rights that have just ended by the clock.
        file_offers: Return what may be done with a file that somebody has sent, as buttons.
    """

    def __init__(self) -> None:
        self.camera: Provided[CameraPreview] = Provided("pictures for dashboards")
        self.dashboards: Provided[ChatDashboards] = Provided("dashboards")
        self.fleet: Provided[FleetStatus] = Provided("the state of the fleet")
        self.alert_tasks: Provided[AlertTasks] = Provided("tasks for rules")
        self.robot_tasks: Provided[RobotTasks] = Provided("tasks for robots")
        self.engaged: Provided[Callable[[RobotId], bool]] = Provided("who helps whom")
        self.page_url: Provided[str] = Provided("a page")
        self.telemetry: Provided[TelemetryHistory] = Provided("what robots reported")
        self.alerts: Provided[OpenAlerts] = Provided("open alarms")
        self.pending: Provided[PendingAnswers] = Provided("who waits for an answer")
        self.work: Provided[FleetWork] = Provided("tasks and missions")
        self.history: Provided[HistoryReader] = Provided("what was asked before")
        self.health: Provided[HealthFindings] = Provided("what the doctor finds")
        self.explainer: Provided[RightsChecker] = Provided("what somebody may, and why")
        self.not_ready: Provided[Callable[[], Iterable[str]]] = Provided("whether it is ready")
        self.views: Provided[RobotViews] = Provided("pictures of what robots show")
        self.robot_adder: Provided[RobotAdder] = Provided("adding robots")
        self.alarm_news: Signal[[RobotId, str, bool]] = Signal()
        self.in_doubt: Provided[Sequence[Unfinished]] = Provided("what the last run left")
        self.grants_ended: Signal[[Sequence[tuple[PrincipalId, Grant]]]] = Signal()
        self.file_offers: list[Callable[[PrincipalId, StoredFile], list[Button]]] = []


class ErasureParticipants:
    """What features keep for a person, and end when that person is erased."""

    def __init__(self) -> None:
        self._records: list[Callable[[PrincipalId], Iterable[Record]]] = []
        self._endings: list[Callable[[PrincipalId], Awaitable[object]]] = []

    def join(
        self,
        *,
        records: Callable[[PrincipalId], Iterable[Record]] | None = None,
        end: Callable[[PrincipalId], Awaitable[object]] | None = None,
    ) -> None:
        """Take part.

        Args:
            records: Returns what ends what is kept for somebody; it changes nothing.
            end: Ends what they have in hand, once the records are in force.
        """
        if records is not None:
            self._records.append(records)
        if end is not None:
            self._endings.append(end)

    def records(self, principal: PrincipalId) -> Iterator[Record]:
        """Return what ends everything that features keep for somebody."""
        for records in self._records:
            yield from records(principal)

    async def end(self, principal: PrincipalId) -> None:
        """End everything that somebody has in hand."""
        for end in self._endings:
            await end(principal)


class Site(NamedTuple):
    """What the configuration says of the place.

    Attributes:
        name: As people see it.
        zone: In which times are said to whoever has set no other.
        missions: What several robots do when somebody says so.
        named: Whom each name of the configuration means, by the name without its case.
    """

    name: str
    zone: str
    missions: tuple[Mission, ...]
    named: Mapping[str, PrincipalId]


class Kernel(NamedTuple):
    """What features are made from.

    Attributes:
        orders: What orders are given with that are no line of a chat.
        access: Who is let in, and how that changes.
        enforcer: Takes robots from whoever may not have them any more, and knows the policy.
        preferences: What people set for themselves.
        robots: Their adapters.
        containers: What is kept in containers; None: the record cannot look into them.
        archive: Which chats are kept.
        folders: Inboxes and outboxes of robots.
        clock: That never goes back; what ends by the clock ends by this one.
        machine_clock: The machine's own.
        memory: What earlier runs left.
        renderer: Draws; None: nobody here can.
        interpreter: May be shown what is not understood; None: nobody is.
        recorder: Makes files of what is seen of robots; None: nobody here can.
        naming: Finds the robot that is meant at the beginning of a line.
        assessment: Says how robots do.
        shared: What features ask of one another.
        erasure: Who ends what when somebody is erased.
    """

    rooms: Components
    pipeline: Pipeline
    orders: OrderServices
    access: AccessRegistry
    enforcer: PolicyEnforcer
    preferences: PreferenceBook
    robots: Mapping[RobotId, Robot]
    containers: ContainerContext | None
    archive: Archive
    folders: FileFolders
    clock: Clock
    machine_clock: Clock
    entropy: Entropy
    store: Store
    memory: Memory
    renderer: Renderer | None
    interpreter: Interpreter | None
    recorder: Recorder | None
    site: Site
    naming: RobotArgument
    assessment: RobotAssessment
    shared: SharedParts
    erasure: ErasureParticipants

    @property
    def changes(self) -> Transactions:
        """Writes facts, and tells who keeps them."""
        return self.access.changes

    @property
    def commands(self) -> CommandRegistry:
        """Who does which command."""
        return self.pipeline.hooks.commands

    @property
    def reach(self) -> Notifier:
        """Speaks to people who have not just asked."""
        return self.orders.reach

    @property
    def messengers(self) -> tuple[Messenger, ...]:
        """Through which people are reached."""
        return self.orders.reach.messengers

    def admins(self) -> tuple[PrincipalId, ...]:
        """Return who looks after people here."""
        return admins_of(self.rooms.organiser)

    def keep(
        self,
        kind: str,
        restore: Callable[[Iterable[Fact]], object],
        apply: Callable[[Fact], object],
    ) -> None:
        """Give a feature the facts of a kind: those of earlier runs now, each new one later."""
        restore(self.memory.facts.get(kind, ()))
        self.changes.keep(kind, apply)


def _as_reported(_robot: RobotId, presence: Presence) -> Presence:
    return presence


def _nothing_measured(_robot: RobotId) -> str:
    return ""
