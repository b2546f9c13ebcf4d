"""Puts the fleet in its place: tasks of earlier runs, who looks after them, who is asked."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.contracts.messenger import catching_up
from rosic.core.fleet import events as e
from rosic.core.fleet.state import STANDING, TASK
from rosic.core.order import OrderEnding
from rosic.core.records import Refused, Told
from rosic.errors import Repeated, StoreFault
from rosic.features.dashboard.commands import DashboardCommands
from rosic.features.dashboard.fleet_dashboard import FLEET_CARD, FleetDashboards
from rosic.features.fleet.attempt import TaskAttempts, TaskRecall, attempt_id
from rosic.features.fleet.dispatch_state import KIND as LETTER
from rosic.features.fleet.dispatcher import TaskDispatcher
from rosic.features.fleet.idempotency import KIND as ORIGIN
from rosic.features.fleet.integration import TaskNotifications
from rosic.features.fleet.mission_commands import MissionCommands
from rosic.features.fleet.mission_schedule import KIND as TIMES
from rosic.features.fleet.mission_schedule import MissionSchedule
from rosic.features.fleet.monitor import FleetMonitor
from rosic.features.fleet.multi_robot import MultiRobotCommands
from rosic.features.fleet.overview import FleetOverview, FleetUsage
from rosic.features.fleet.pause import PauseCommands
from rosic.features.fleet.robot_commands import RobotCommands
from rosic.features.fleet.shift_handover import ShiftHandoverCommands
from rosic.features.fleet.task_commands import TaskCommands
from rosic.features.robot_to_robot.help_requests import HelpRequests
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from rosic.app.settings import GatewaySettings
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact, Memory
    from rosic.features.dashboard.dashboards import Dashboards
    from rosic.features.dashboard.rendering import DashboardQueries as CardSides
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.order_services import OrderServices
    from rosic.gateway.transactions import Transactions


# ---- the fleet ----

_ENDS = {
    OrderEnding.DONE.value: e.AttemptEnd.DONE,
    OrderEnding.FAILED.value: e.AttemptEnd.FAILED,
    OrderEnding.CANCELLED.value: e.AttemptEnd.SHUT_DOWN,
    OrderEnding.REFUSED.value: e.AttemptEnd.BUSY,
    OrderEnding.SENT.value: e.AttemptEnd.SENT,
}


class FleetFeature:
    """The fleet of one gateway.

    Attributes:
        dispatching: Where it changes.
        watching: Looks after it.
        telling: Tells people.
        overview: Looks at all of it.
        robots: Asked who takes part.
        help_book: Which robots help each other; meanwhile they are given nothing else.
    """

    def __init__(
        self, rooms: Components, changes: Transactions, clock: Clock, hands: OrderServices
    ) -> None:
        self._rooms = rooms
        self._changes = changes
        self._clock = clock
        attempting = TaskAttempts(rooms, hands, clock)
        recalling = TaskRecall(rooms, hands, clock)
        self.dispatching = TaskDispatcher(
            rooms,
            changes,
            clock,
            attempting,
            recalling,
            lambda: any(map(catching_up, hands.reach.messengers)),
        )
        self.help_book = HelpRequests(clock.wall_ns)
        self.watching = FleetMonitor(rooms, self.dispatching, clock, self.help_book.engages)
        self.telling = TaskNotifications(rooms, hands.reach, self.dispatching, hands.ends)
        self.dispatching.tell.connect(self.telling.tell)
        self.dispatching.changed.connect(self._changed)
        self._usage = FleetUsage(clock.monotonic_ns)
        self._hands = hands
        self.overview = FleetOverview(
            rooms, self.dispatching, self.watching, self.telling, self._usage
        )
        self._planning: asyncio.Task[None] | None = None

    def set_up(self, pipeline: Pipeline, memory: Memory, settings: GatewaySettings) -> None:
        """Take over what earlier runs wrote, and take the commands."""
        fleet, letters = self.dispatching.fleet, self.dispatching.letters
        origins = self.dispatching.origins
        kept = ((TASK, fleet), (STANDING, fleet), (LETTER, letters), (ORIGIN, origins))
        for kind, scheduler in kept:
            scheduler.restore(memory.facts.get(kind, ()))
            self._changes.keep(kind, scheduler.apply)
        pipeline.executor.watch_orders(self._usage)
        commands, rooms, dispatching = pipeline.hooks.commands, self._rooms, self.dispatching
        tasks = TaskCommands(rooms, dispatching, self.telling)
        tasks.register(commands)
        self._set_up_missions(tasks, memory, settings, pipeline)
        robots = self.robots = RobotCommands(rooms, dispatching, self._hands.stop_lane)
        robots.register(commands)
        pipeline.resuming.begins.bind(robots.begins)
        rooms.board.barred.bind(robots.barred)  # from here on robots are resumed
        pausing = PauseCommands(
            rooms, dispatching, pipeline.executor, pipeline.resuming, pipeline.hooks
        )
        pausing.register(commands)
        pipeline.cancels.also(pausing.cancel)
        ShiftHandoverCommands(rooms, dispatching, self._hands.reach, self._clock).register(commands)
        MultiRobotCommands(rooms, dispatching, self._hands, self._clock, pipeline.hooks).register(
            commands
        )

    def show_on_cards(
        self, robots: Dashboards, sides: CardSides, pipeline: Pipeline, memory: Memory
    ) -> None:
        """Let the fleet be shown like robots are, in cards of its own."""
        messengers = self._hands.reach.messengers
        cards = FleetDashboards(self.overview, self._changes, messengers, self._clock, sides)
        cards.restore(memory.facts.get(FLEET_CARD, ()))
        robots.others = cards
        handler = DashboardCommands(
            cards, cards.snapshots, self._rooms.vocabularies, sides, verb="fleet"
        )
        pipeline.hooks.commands.register("fleet", handler.card)

    def _set_up_missions(
        self, tasks: TaskCommands, memory: Memory, settings: GatewaySettings, pipeline: Pipeline
    ) -> None:
        zone, changes = zone_named(settings.zone), self._changes
        self._timetable = timetable = MissionSchedule(changes, self._hands.reach, self._clock, zone)
        timetable.restore(memory.facts.get(TIMES, ()))
        missions = MissionCommands(self._rooms, changes, tasks, settings.missions, timetable, zone)
        missions.register(pipeline.hooks.commands)
        timetable.starter = missions.at_its_time

    # ---- after an interruption ----

    async def settle(self, memory: Memory, store: Store) -> None:
        """Say what became of the tasks that had a robot when the last run ended."""
        known = {life.cid: life.ending for life in memory.unfinished}
        held = [self.dispatching.fleet.tasks[key] for key in self.dispatching.fleet.holds.values()]
        ends = {task.id: await self._end(task, known, store) for task in held}
        await self.dispatching.settle(lambda task: ends[task.id])

    async def _end(
        self, task: Task, known: dict[bytes, str | None], store: Store
    ) -> e.AttemptEnd | None:
        """Return what is known of the order of a task's newest attempt.

        What is not among the unfinished lives was told already, or never claimed. A refusal in its
        place finds out which, and sees to it that it never will be.
        """
        cid = attempt_id(task, task.attempt)
        if cid in known:
            ending = known[cid]
            return None if ending is None else _ENDS.get(ending)
        refused = Refused(
            cid=cid, principal=task.author, code="restarted", at_ns=self._clock.wall_ns()
        )
        try:
            await store.write(refused)
        except (Repeated, StoreFault):
            return None
        store.note(Told(cid, self._clock.wall_ns()))
        return e.AttemptEnd.BUSY

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what lets go everything that somebody has said; nobody carries it out then."""
        return (
            *self.dispatching.letters.end_all(principal),
            *self._timetable.end_all(principal),
        )

    # ---- while it runs ----

    def _changed(self) -> None:
        self._usage.note(self.dispatching.fleet.holds)
        self.watching.begin()
        if self._planning is None:
            self._planning = asyncio.create_task(self._plan())

    async def _plan(self) -> None:
        """Choose once for all that has changed in one turn of the event loop."""
        try:
            await self.watching.plan()
        finally:
            self._planning = None

    def run(self) -> None:
        """Let robots begin from now on."""
        self.watching.run()
        self._timetable.run()
        self._changed()

    async def close(self) -> None:
        """Nothing begins any more; what ends is noted until the record is closed."""
        self.dispatching.shut()
        await self._timetable.close()
        await self.watching.close()
        if self._planning is not None:
            self._planning.cancel()
            await asyncio.gather(self._planning, return_exceptions=True)
        await self.dispatching.close()
