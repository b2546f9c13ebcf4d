"""Everything that is so in a fleet, kept so that nothing has to be searched."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.fleet.task import HELD, OVER, FleetMembership, Task, TaskId, TaskState
from rosic.core.records import Fact

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator

    from rosic.core.fleet.events import Transition
    from rosic.core.robot.profile import RobotId

TASK: Final = "task"
STANDING: Final = "robot-standing"
KEPT_OVER: Final = 200
"""So many tasks that are over are still known."""

_encode = msgspec.msgpack.Encoder().encode
_task = msgspec.msgpack.Decoder(Task).decode
_standing = msgspec.msgpack.Decoder(FleetMembership).decode


class FleetState:
    """The tasks, who has which, and which robots take part. Changed by `apply` alone.

    Attributes:
        tasks: Every task that is known, in the order in which they were given.
        holds: Robot to the task that it has.
        waiting: Tasks that wait for a robot or for other tasks.
        due: Tasks that are not over and are to be done by a time.
        unreadable: Facts that could not be read, by key; they are left out.
    """

    def __init__(self) -> None:
        self.tasks: dict[TaskId, Task] = {}
        self.holds: dict[RobotId, TaskId] = {}
        self.waiting: dict[TaskId, None] = {}
        self.due: dict[TaskId, None] = {}
        self.unreadable: list[str] = []
        self._standings: dict[RobotId, FleetMembership] = {}
        self._over: dict[TaskId, None] = {}
        self._missions: dict[str, dict[TaskId, None]] = {}
        self._newest = 0

    # ---- what is so ----

    def standing(self, robot: RobotId) -> FleetMembership:
        """Return whether a robot takes part; whoever was never spoken of does."""
        return self._standings.get(robot, FleetMembership.ACTIVE)

    def mission(self, mission: str) -> tuple[Task, ...]:
        """Return the tasks of a mission, in the order in which they were given."""
        return tuple(self.tasks[task] for task in self._missions.get(mission, ()))

    @property
    def missions(self) -> tuple[str, ...]:
        """Return every mission that is known."""
        return tuple(self._missions)

    def open(self) -> Iterator[Task]:
        """Go through the tasks that are not over."""
        return (task for task in self.tasks.values() if not task.over)

    def ready(self, task: Task) -> bool:
        """Whether everything that has to be done before a task is done; what is unknown is not."""
        return all(
            other in self.tasks and self.tasks[other].state is TaskState.DONE
            for other in task.after
        )

    def beginning(self, robots: Collection[RobotId]) -> list[TaskId]:
        """Return the tasks that wait and that some robots may be given as soon as they are free."""
        waiting = (self.tasks[key] for key in self.waiting)
        among = set(robots)
        return [t.id for t in waiting if not among.isdisjoint(t.left) and self.ready(t)]

    def next_id(self) -> TaskId:
        """Return a number that no task has had."""
        return str(self._newest + 1)

    # ---- what is written ----

    def facts(self, step: Transition) -> tuple[Fact, ...]:
        """Return what makes a step so."""
        return (
            *(Fact(kind=TASK, key=task.id, body=_encode(task)) for task in step.tasks),
            *(
                Fact(kind=STANDING, key=robot, body=_encode(standing))
                for robot, standing in step.standings
            ),
        )

    def stale(self) -> tuple[TaskId, ...]:
        """Return the tasks that need not be known any more: over, and nobody waits for them."""
        beyond = len(self._over) - KEPT_OVER
        if beyond <= 0:
            return ()
        found = (task for task in self._over if self._settled(self.tasks[task].mission))
        return tuple(task for task, _ in zip(found, range(beyond), strict=False))

    def _settled(self, mission: str) -> bool:
        return all(task.over for task in self.mission(mission)) if mission else True

    def forgotten(self, tasks: Iterable[TaskId]) -> tuple[Fact, ...]:
        """Return what lets tasks go."""
        return tuple(Fact(kind=TASK, key=task, body=b"") for task in tasks)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so, now or at the start."""
        try:
            if fact.kind == STANDING:
                self._standings[fact.key] = _standing(fact.body)
            else:
                self._put(fact.key, _task(fact.body) if fact.body else None)
        except msgspec.MsgspecError:
            self.unreadable.append(fact.key)

    def _put(self, key: TaskId, task: Task | None) -> None:
        old = self.tasks.get(key)
        if old is not None and self.holds.get(old.robot) == key:
            del self.holds[old.robot]
        for shelf in (self.waiting, self._over, self.due):
            shelf.pop(key, None)
        if key.isdecimal():
            self._newest = max(self._newest, int(key))
        if task is None:
            self._drop(key, old)
            return
        self.tasks[key] = task
        self._list(key, task)
        if task.state in HELD:
            self.holds[task.robot] = key
        elif task.state is TaskState.QUEUED:
            self.waiting[key] = None
        elif task.state in OVER:
            self._over[key] = None

    def _list(self, key: TaskId, task: Task) -> None:
        if task.mission:
            self._missions.setdefault(task.mission, {})[key] = None
        if (task.due.lasts_ns or task.due.at_ns) and not task.over:
            self.due[key] = None

    def _drop(self, key: TaskId, old: Task | None) -> None:
        self.tasks.pop(key, None)
        if old is not None and old.mission:
            siblings = self._missions[old.mission]
            siblings.pop(key, None)
            if not siblings:
                del self._missions[old.mission]
