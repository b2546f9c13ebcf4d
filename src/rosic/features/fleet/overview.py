"""``/fleet``: the bird's-eye view: every robot, every task, and where it does not go on."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import RESTING, FleetMembership, TaskState
from rosic.core.time_units import SECOND_NS
from rosic.features.fleet import messages
from rosic.features.fleet import robot_messages as words

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Sequence

    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.features.fleet.integration import TaskNotifications
    from rosic.features.fleet.monitor import FleetMonitor
    from rosic.gateway.components import Components


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
        elif rooms.board[robot].latched:
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


class _Robot:
    """What is known of one robot.

    Attributes:
        held: It has a task.
        ordered: An order that needs it for itself is with it.
        since_ns: Since when it has been at work, or has not, or since what was added up.
        worked_ns: For how long it had been at work before.
    """

    __slots__ = ("held", "ordered", "since_ns", "worked_ns")

    def __init__(self, since_ns: int) -> None:
        self.held = self.ordered = False
        self.since_ns = since_ns
        self.worked_ns = 0

    @property
    def works(self) -> bool:
        """Whether it is at work now."""
        return self.held or self.ordered

    def count(self, now_ns: int) -> None:
        """Add up what it has worked so far; it may go on."""
        self.worked_ns += now_ns - self.since_ns
        self.since_ns = now_ns


class FleetUsage:
    """Counts time at work; a `Watcher` of orders.

    A robot is at work from the moment it gets a task until it has none, and from when an order that
    needs it for itself is handed to it until its end is known, whoever gave it. Where both are so,
    the time counts once. To be asked something is no work.

    Args:
        monotonic_ns: Returns the moment, on the monotonic clock.
    """

    def __init__(self, monotonic_ns: Callable[[], int]) -> None:
        self._now_ns = monotonic_ns
        self._begun_ns = monotonic_ns()
        self._held: set[RobotId] = set()
        self._robots: dict[RobotId, _Robot] = {}

    # ---- what is heard ----

    def note(self, held: Collection[RobotId]) -> None:
        """Hear who has a task now."""
        now_ns, before = self._now_ns(), self._held
        self._held = set(held)
        for name in self._held - before:
            robot = self._known(name)
            if not robot.works:
                robot.since_ns = now_ns
            robot.held = True
        for name in before - self._held:
            robot = self._robots[name]
            robot.held = False
            robot.count(now_ns)

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot."""
        if order.skill.actuates:
            robot = self._robots.get(order.robot) or self._known(order.robot)
            if not (robot.held or robot.ordered):
                robot.since_ns = self._now_ns()
            robot.ordered = True

    def ended(self, order: Order, outcome: Outcome) -> None:  # noqa: ARG002 - however it ended
        """Hear that it is over."""
        robot = self._robots.get(order.robot)
        if robot is not None and robot.ordered:
            robot.ordered, now_ns = False, self._now_ns()
            robot.worked_ns += now_ns - robot.since_ns
            robot.since_ns = now_ns

    def _known(self, name: RobotId) -> _Robot:
        robot = self._robots.get(name)
        if robot is None:
            robot = self._robots[name] = _Robot(self._begun_ns)
        return robot

    # ---- what is asked ----

    def works(self, name: RobotId) -> bool:
        """Return whether a robot is at work now."""
        robot = self._robots.get(name)
        return robot is not None and robot.works

    def share(self, names: Collection[RobotId]) -> float:
        """Return which share of their time some robots were at work, 0 to 1."""
        now_ns = self._now_ns()
        whole_ns = (now_ns - self._begun_ns) * len(names)
        worked_ns = sum(self._worked_ns(name, now_ns) for name in names)
        return worked_ns / whole_ns if whole_ns > 0 else 0.0

    def _worked_ns(self, name: RobotId, now_ns: int) -> int:
        robot = self._robots.get(name)
        if robot is None:
            return 0
        return robot.worked_ns + (now_ns - robot.since_ns if robot.works else 0)

    def idle_s(self, name: RobotId) -> int:
        """Return for how long a robot has not been at work; 0 while it is."""
        robot = self._robots.get(name) or _Robot(self._begun_ns)
        return 0 if robot.works else (self._now_ns() - robot.since_ns) // SECOND_NS
