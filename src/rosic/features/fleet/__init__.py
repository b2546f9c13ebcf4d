"""Tasks and missions of many robots: who is given what, who looks after it, who takes part."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import catching_up
from rosic.core.fleet import events as e
from rosic.core.fleet.state import STANDING, TASK
from rosic.core.order import OrderEnding
from rosic.core.records import Refused, Told
from rosic.errors import Repeated, StoreFault
from rosic.features.fleet.add_robot import AddRobotFromChat
from rosic.features.fleet.agreement_steps import AgreementSteps
from rosic.features.fleet.attempt import TaskAttempts, TaskRecall, attempt_id
from rosic.features.fleet.dispatch_state import KIND as LETTER
from rosic.features.fleet.dispatcher import TaskDispatcher
from rosic.features.fleet.idempotency import KIND as ORIGIN
from rosic.features.fleet.integration import AssistCommands, RuleTasks, TaskNotifications
from rosic.features.fleet.mission_book import DRAFT, SAVED, MissionBook
from rosic.features.fleet.mission_builder import MissionBuilder
from rosic.features.fleet.mission_commands import MissionCommands
from rosic.features.fleet.mission_schedule import KIND as TIMES
from rosic.features.fleet.mission_schedule import MissionSchedule
from rosic.features.fleet.monitor import FleetMonitor
from rosic.features.fleet.multi_robot import MultiRobotCommands
from rosic.features.fleet.overview import FleetOverview, FleetUsage, FleetWorkList
from rosic.features.fleet.pause import PauseCommands
from rosic.features.fleet.robot_commands import RobotCommands
from rosic.features.fleet.shift_handover import ShiftHandoverCommands
from rosic.features.fleet.task_commands import TaskCommands
from rosic.features.fleet.work_time import KIND as WORK_TIME
from rosic.features.fleet.work_time import WorkTime, WorkTimeStore
from rosic.gateway.feature import Feature
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from rosic.contracts.store import Store
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel

__all__ = ["FleetFeature", "setup"]

NEEDS: Final = ("engaged",)
PROVIDES: Final = ("fleet", "alert_tasks", "robot_tasks", "file_offers", "work")

_ENDS = {
    OrderEnding.DONE.value: e.AttemptEnd.DONE,
    OrderEnding.FAILED.value: e.AttemptEnd.FAILED,
    OrderEnding.CANCELLED.value: e.AttemptEnd.SHUT_DOWN,
    OrderEnding.REFUSED.value: e.AttemptEnd.BUSY,
    OrderEnding.SENT.value: e.AttemptEnd.SENT,
}


class FleetFeature(Feature):
    """The fleet of one gateway.

    Attributes:
        dispatching: Where it changes.
        watching: Looks after it.
        telling: Tells people.
        overview: Looks at all of it.
        book: Every mission by name.
    """

    def __init__(self, kernel: Kernel) -> None:
        rooms, orders, clock = kernel.rooms, kernel.orders, kernel.clock
        messengers = kernel.messengers
        self._kernel = kernel
        self.dispatching = TaskDispatcher(
            rooms,
            kernel.changes,
            clock,
            TaskAttempts(rooms, orders, clock),
            TaskRecall(rooms, orders, clock),
            lambda: any(map(catching_up, messengers)),
        )
        self.watching = FleetMonitor(rooms, self.dispatching, clock, kernel.shared.engaged.get())
        self.telling = TaskNotifications(rooms, kernel.reach, self.dispatching, orders.ends)
        self.dispatching.tell.connect(self.telling.tell)
        self.dispatching.changed.connect(self._changed)
        self._hours = WorkTime(clock.wall_ns())
        kernel.keep(WORK_TIME, self._hours.restore, self._hours.apply)
        self._usage = FleetUsage(clock.monotonic_ns, self._worked)
        self._keeping = WorkTimeStore(self._hours, clock, self._usage.settle, kernel.changes.note)
        kernel.pipeline.executor.watching.watch_orders(self._usage)
        self.overview = FleetOverview(
            rooms, self.dispatching, self.watching, self.telling, self._usage
        )
        self._planning: asyncio.Task[None] | None = None
        self._take_over()
        tasks = TaskCommands(rooms, self.dispatching, self.telling, orders.chat_sender.languages)
        tasks.register(kernel.commands)
        zone = zone_named(kernel.site.zone)
        self._timetable = MissionSchedule(kernel.changes, kernel.reach, clock, zone)
        self._timetable.restore(kernel.memory.facts.get(TIMES, ()))
        self.book = MissionBook(kernel.site.missions, kernel.pipeline.hooks.drafting)
        for kind in (SAVED, DRAFT):
            kernel.keep(kind, self.book.restore, self.book.apply)
        builder = MissionBuilder(rooms, kernel.changes, self.book, kernel.pipeline.agreements)
        self._missions = MissionCommands(
            rooms, kernel.changes, tasks, builder, self._timetable, zone
        )
        self._missions.register(kernel.commands)
        kernel.shared.work.provide(
            FleetWorkList(tasks, self._missions, self.book, self._usage, self._hours)
        )
        steps = AgreementSteps(rooms, self.dispatching.fleet, tasks, self._missions)
        kernel.pipeline.hooks.task_steps.bind(steps.of)

    def _take_over(self) -> None:
        """Go on with what earlier runs wrote."""
        dispatching = self.dispatching
        fleet, letters, origins = dispatching.fleet, dispatching.letters, dispatching.origins
        for kind, kept in ((TASK, fleet), (STANDING, fleet), (LETTER, letters), (ORIGIN, origins)):
            self._kernel.keep(kind, kept.restore, kept.apply)

    # ---- after an interruption ----

    async def recover(self) -> None:
        """Say what became of the tasks that had a robot when the last run ended."""
        memory, store = self._kernel.memory, self._kernel.store
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
            cid=cid, principal=task.author, code="restarted", at_ns=self._kernel.clock.wall_ns()
        )
        try:
            await store.write(refused)
        except (Repeated, StoreFault):
            return None
        store.note(Told(cid, self._kernel.clock.wall_ns()))
        return e.AttemptEnd.BUSY

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what lets go everything that somebody has said; nobody carries it out then."""
        return (
            *self.dispatching.letters.end_all(principal),
            *self._timetable.end_all(principal),
            *self.book.end_all(principal),
        )

    # ---- while it runs ----

    def _worked(self, robot: RobotId, past_ns: int) -> None:
        now_ns = self._kernel.clock.wall_ns()
        self._hours.add(robot, now_ns - past_ns, now_ns)

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

    async def run(self) -> None:
        """Let robots begin from now on."""
        self._keeping.run()
        self.watching.run()
        self._timetable.run(self._missions.at_its_time)
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
        await self._keeping.close()


def setup(kernel: Kernel) -> FleetFeature:
    """Bring tasks to robots, and take the commands about them."""
    feature = FleetFeature(kernel)
    rooms, pipeline, orders, shared = kernel.rooms, kernel.pipeline, kernel.orders, kernel.shared
    commands, dispatching = kernel.commands, feature.dispatching
    newcomers = None
    if kernel.containers is not None:
        newcomers = AddRobotFromChat(shared.robot_adder.get, kernel.containers, rooms.organiser)
        shared.file_offers.append(newcomers.offer)
    robots = RobotCommands(
        rooms, dispatching, orders.stop_lane, None if newcomers is None else newcomers.add
    )
    robots.register(commands)
    pipeline.resuming.begins.bind(robots.begins)
    rooms.stops.barred.bind(robots.barred)  # from here on robots are resumed
    pausing = PauseCommands(
        rooms, dispatching, pipeline.executor, pipeline.resuming, pipeline.hooks
    )
    pausing.register(commands)
    pipeline.cancels.also(pausing.cancel)
    ShiftHandoverCommands(rooms, dispatching, kernel.reach, kernel.clock).register(commands)
    MultiRobotCommands(rooms, dispatching, orders, kernel.clock, pipeline.hooks).register(commands)
    shared.fleet.provide(feature.overview)
    shared.alert_tasks.provide(RuleTasks(rooms, dispatching))
    shared.robot_tasks.provide(AssistCommands(rooms, dispatching, feature.watching))
    kernel.erasure.join(records=feature.end_all, end=dispatching.ended)
    return feature
