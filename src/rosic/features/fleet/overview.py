"""``/fleet``: the bird's-eye view: every robot, every task, and where it does not go on."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import RESTING, FleetMembership, TaskState
from rosic.core.fleet.template import bounds
from rosic.core.time_units import SECOND_NS
from rosic.features.fleet import messages
from rosic.features.fleet import robot_messages as words
from rosic.gateway.pending_work import MissionRun, OfferedMission, TimeAtWork

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Sequence

    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.features.fleet.integration import TaskNotifications
    from rosic.features.fleet.mission_book import MissionBook
    from rosic.features.fleet.mission_commands import MissionCommands
    from rosic.features.fleet.monitor import FleetMonitor
    from rosic.features.fleet.task_commands import TaskCommands
    from rosic.features.fleet.work_time import WorkTime
    from rosic.gateway.components import Components
    from rosic.gateway.pending_work import TaskEntry


# ---- ``/fleet`` ----

SHOWN_AT_MOST: Final = 25
"""More robots do not fit into one message; those that need a look come first."""
LOW: Final = 20.0


class FleetOverview:
    """Looks at what somebody may see of the fleet."""

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        watching: FleetMonitor,
        telling: TaskNotifications,
        usage: FleetUsage,
    ) -> None:
        self._rooms = rooms
        self._dispatching = dispatching
        self._watching = watching
        self._telling = telling
        self._usage = usage

    def settled(self, robots: Sequence[RobotId]) -> tuple[object, ...]:
        """Return what does not change all the time: while it is the same, so is the fleet."""
        fleet = self._dispatching.fleet
        whose = self._rooms.organiser.whose
        tasks = [(task.id, task.state, task.leaving, task.done) for task in fleet.open()]
        return (
            tuple(tasks),
            tuple(
                (*self._states(r)[0], fleet.holds.get(r), whose(r), self._usage.works(r))
                for r in robots
            ),
        )

    def lines(self, robots: Sequence[RobotId], wall_ns: int, who: PrincipalId) -> Iterator[str]:
        """Yield what there is to say about some robots and their tasks, for somebody to read."""
        fleet = self._dispatching.fleet
        states = {robot: self._states(robot, who) for robot in robots}
        unready = [robot for robot in robots if states[robot][0]]
        at_work = [robot for robot in robots if self._usage.works(robot)]
        free = len([r for r in robots if not states[r][0] and self._is_free(r)])
        yield words.robots_altogether(len(at_work), free, len(unready))
        open_tasks = [task for task in fleet.open() if not set(task.among).isdisjoint(robots)]
        yield self._tasks(open_tasks, wall_ns)
        if robots:
            idle_s = sum(self._usage.idle_s(robot) for robot in robots) // len(robots)
            yield words.use(self._usage.share(robots), idle_s)
        yield from self._bottlenecks(open_tasks, states)
        # What needs a look first, then what works, then what waits.
        order = sorted(robots, key=lambda r: (not states[r][0], not self._usage.works(r), r))
        for robot in order[:SHOWN_AT_MOST]:
            yield words.one(self._telling.shown(robot), [*states[robot][0], *states[robot][1]])
        if len(order) > SHOWN_AT_MOST:
            yield messages.and_more(len(order) - SHOWN_AT_MOST)

    def _is_free(self, robot: RobotId) -> bool:
        nobodys = self._rooms.organiser.whose(robot) is None
        return nobodys and robot not in self._dispatching.fleet.holds

    def _tasks(self, tasks: Sequence[Task], wall_ns: int) -> str:
        fleet = self._dispatching.fleet
        waiting = [task for task in tasks if task.id in fleet.waiting]
        longest_s = max((wall_ns - task.since_ns for task in waiting), default=0) // SECOND_NS
        resting = sum(task.state in RESTING for task in tasks)
        held = sum(bool(task.robot) for task in tasks)
        return words.tasks_altogether(len(waiting), held, resting, max(0, longest_s))

    def _bottlenecks(
        self, tasks: Sequence[Task], states: dict[RobotId, tuple[list[str], list[str]]]
    ) -> Iterator[str]:
        """Yield the groups for which more tasks wait than robots are free."""
        fleet = self._dispatching.fleet
        waiting = [task for task in tasks if task.state is TaskState.QUEUED and fleet.ready(task)]
        counts = Counter(task.wanted for task in waiting)
        for wanted, count in counts.most_common(3):
            able = {r for task in waiting if task.wanted == wanted for r in task.left}
            ready = [r for r in able if r in states and not states[r][0]]
            free = [r for r in ready if r not in fleet.holds]
            if count > len(free):
                yield words.bottleneck(wanted or words.for_any(), count, len(free), len(ready))

    def _states(self, robot: RobotId, who: PrincipalId = "") -> tuple[list[str], list[str]]:
        """Return what is not as it should be with a robot, and everything else."""
        rooms, fleet = self._rooms, self._dispatching.fleet
        presence = rooms.linker.presence(robot)
        wrong: list[str] = []
        standing = fleet.standing(robot)
        if standing is not FleetMembership.ACTIVE:
            wrong.append(words.out_of_fleet(standing))
        elif rooms.stops[robot].latched:
            wrong.append(words.stopped())
        if presence.online is False:
            wrong.append(words.not_there())
        idle = robot not in fleet.holds and not presence.doing
        if idle and presence.moves:
            wrong.append(words.moves())
        candidate = self._watching.candidate(robot)
        if candidate.battery is not None and candidate.battery < LOW:
            wrong.append(words.battery(candidate.battery, low=True))
        rest = self._rest(robot, who, candidate.battery, presence.age_s, ready=not wrong)
        return wrong, list(rest)

    def _rest(
        self,
        robot: RobotId,
        who: PrincipalId,
        battery: float | None,
        age_s: float | None,
        *,
        ready: bool,
    ) -> Iterator[str]:
        task = self._dispatching.fleet.tasks.get(self._dispatching.fleet.holds.get(robot, ""))
        holder: PrincipalId | None = self._rooms.organiser.whose(robot)
        if task is not None:
            yield words.at_task(task.id, self._telling.what(task, who))
            yield messages.state(task)
        elif holder is not None:
            yield words.theirs(self._rooms.organiser.name_of(holder))
        else:
            yield words.free() if ready else words.not_ready()
        if battery is not None and battery >= LOW:
            yield words.battery(battery, low=False)
        if age_s is not None:
            yield words.link_of(age_s * 1e3)


# ---- time at work ----


class FleetUsage:
    """Counts time at work; a `Watcher` of orders.

    A robot is at work from the moment it gets a task until it has none, and from when an order that
    needs it for itself is handed to it until its end is known, whoever gave it. Where both are so,
    the time counts once. To be asked something is no work.

    Args:
        monotonic_ns: Returns the moment, on the monotonic clock.
        worked: Told of work since it was told last: of which robot, and how long it was, ns.
    """

    def __init__(
        self, monotonic_ns: Callable[[], int], worked: Callable[[RobotId, int], None]
    ) -> None:
        self._now_ns, self._worked = monotonic_ns, worked
        self._begun_ns = monotonic_ns()
        self._held: set[RobotId] = set()
        self._ordered: set[RobotId] = set()  # an order that needs it for itself is with it
        # Since when each has been at work, or has not, or since what was added up; and what was.
        self._since_ns: dict[RobotId, int] = {}
        self._worked_ns: Counter[RobotId] = Counter()
        self._untold_ns: Counter[RobotId] = Counter()

    # ---- what is heard ----

    def note(self, held: Collection[RobotId]) -> None:
        """Hear who has a task now."""
        now_ns, before = self._now_ns(), self._held
        self._held = set(held)
        for robot in self._held - before:
            if robot not in self._ordered:
                self._since_ns[robot] = now_ns
        for robot in before - self._held:
            self._add(robot, now_ns)

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot."""
        if order.skill.actuates:
            robot = order.robot
            if robot not in self._held and robot not in self._ordered:
                self._since_ns[robot] = self._now_ns()
            self._ordered.add(robot)

    def ended(self, order: Order, outcome: Outcome) -> None:  # noqa: ARG002 - however it ended
        """Hear that it is over."""
        robot = order.robot
        if robot in self._ordered:
            self._ordered.discard(robot)
            now_ns = self._now_ns()  # as in `_add`: each order passes here
            past_ns, self._since_ns[robot] = now_ns - self._since_ns[robot], now_ns
            self._worked_ns[robot] += past_ns
            self._untold_ns[robot] += past_ns

    def settle(self) -> None:
        """Tell how long each robot has been at work since the last time, up to now."""
        for robot in self._held | self._ordered | self._untold_ns.keys():
            self.tell(robot)

    def tell(self, robot: RobotId) -> None:
        """Tell how long one robot has been at work since the last time, up to now."""
        if self.works(robot):
            self._add(robot, self._now_ns())
        if worked_ns := self._untold_ns.pop(robot, 0):
            self._worked(robot, worked_ns)

    def _add(self, robot: RobotId, now_ns: int) -> None:
        past_ns, self._since_ns[robot] = now_ns - self._since_ns[robot], now_ns
        self._worked_ns[robot] += past_ns
        self._untold_ns[robot] += past_ns

    # ---- what is asked ----

    def works(self, robot: RobotId) -> bool:
        """Return whether a robot is at work now."""
        return robot in self._held or robot in self._ordered

    def share(self, robots: Collection[RobotId]) -> float:
        """Return which share of their time some robots were at work, 0 to 1."""
        now_ns = self._now_ns()
        whole_ns = (now_ns - self._begun_ns) * len(robots)
        worked_ns = sum(self._worked_until_ns(robot, now_ns) for robot in robots)
        return worked_ns / whole_ns if whole_ns > 0 else 0.0

    def _worked_until_ns(self, robot: RobotId, now_ns: int) -> int:
        going_on_ns = now_ns - self._since_ns[robot] if self.works(robot) else 0
        return self._worked_ns[robot] + going_on_ns

    def idle_s(self, robot: RobotId) -> int:
        """Return for how long a robot has not been at work; 0 while it is."""
        if self.works(robot):
            return 0
        return (self._now_ns() - self._since_ns.get(robot, self._begun_ns)) // SECOND_NS


# ---- elsewhere than in a chat ----


class FleetWorkList:
    """Lists tasks and missions by the rules of the commands that list them; see `FleetWork`."""

    def __init__(
        self,
        tasks: TaskCommands,
        missions: MissionCommands,
        book: MissionBook,
        usage: FleetUsage,
        hours: WorkTime,
    ) -> None:
        self._tasks, self._missions, self._book = tasks, missions, book
        self._usage, self._hours = usage, hours

    def work_of(self, robot: RobotId, since_ns: int, now_ns: int) -> TimeAtWork:
        """Return for how long a robot was at work since then."""
        self._usage.tell(robot)
        return TimeAtWork(
            self._usage.works(robot),
            self._hours.worked_s(robot, since_ns, now_ns),
            self._hours.counted_s(since_ns, now_ns),
        )

    def tasks_for(self, who: PrincipalId) -> tuple[TaskEntry, ...]:
        """Return the open tasks that somebody may see."""
        return tuple(self._tasks.entry(task, who) for task in self._tasks.open_for(who))

    def missions_for(self, who: PrincipalId) -> tuple[OfferedMission, ...]:
        """Return the missions that somebody may start."""
        return tuple(
            OfferedMission(
                mission.name,
                mission.title,
                tuple(bounds(*quantity) for quantity in mission.parameters.items()),
            )
            for mission in self._book.of(who).values()
        )

    def runs_for(self, who: PrincipalId) -> tuple[MissionRun, ...]:
        """Return the missions that run, as far as somebody may see."""
        fleet = self._tasks.dispatching.fleet
        return tuple(
            MissionRun(run, tuple(fleet.mission(run))) for run in self._missions.open_runs(who)
        )
