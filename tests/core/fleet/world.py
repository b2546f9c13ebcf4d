"""A few robots, people and tasks in a world that fails in every way that a gateway may meet.

Everything that the fleet decides is written down before it is done, and everything that robots
answer may come late, twice, or never. After each step the world checks what was promised.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.candidates import CandidateRobot, by_priority, nearest_idle
from rosic.core.fleet.state import FleetState
from rosic.core.fleet.task import HELD, FleetMembership, Task, TaskReason, TaskState
from rosic.core.fleet.transitions import react

if TYPE_CHECKING:
    from rosic.core.records import Fact

ROBOTS = ("r1", "r2", "r3")
PEOPLE = ("ann", "ben")
TASKS_AT_MOST = 6
SECOND_NS = 1_000_000_000


class Machine:
    """One robot as it really is.

    Attributes:
        doing: Task, attempt and step that it carries out.
        fence: Orders of older attempts do not count any more.
        latched: Stopped until somebody resumes it.
        heard: Its answers arrive.
        holder: Who has it: a person, or the author of what the fleet asked last.
        by_hand: Somebody lets it do something that is no task.
        moving: Its order is over, and it has not come to rest.
    """

    def __init__(self) -> None:
        self.doing: tuple[str, int, int] | None = None
        self.cut_off: tuple[str, int] | None = None
        self.latched = False
        self.heard = True
        self.holder: str | None = None
        self.by_hand = False
        self.moving = False


class World:
    """The fleet, its record, its robots, and everything on the way between them."""

    def __init__(self) -> None:
        self.fleet = FleetState()
        self.record: dict[tuple[str, str], Fact] = {}
        self.robots = {robot: Machine() for robot in ROBOTS}
        self.now_ns = SECOND_NS
        self.inbox: list[e.Event] = []
        self.todo: list[e.Doing] = []
        self.given: dict[str, Task] = {}
        self.claims: dict[tuple[str, int], e.AttemptEnd | None] = {}
        self.begun: set[tuple[str, int]] = set()
        self.recalled: set[tuple[str, int]] = set()
        self.steps_done: dict[str, set[int]] = {}
        self.moved_from: set[tuple[str, int]] = set()
        self.doubted: dict[str, int] = {}
        self.steps_told: list[str] = []

    def feed(self, event: e.Event) -> None:
        """Let an event happen: decided, written, so; what is to be done comes later."""
        self.now_ns += SECOND_NS
        self.steps_told.append(repr(event))
        before = dict(self.fleet.tasks)
        step = react(self.fleet, event, self.now_ns)
        facts = self.fleet.facts(step)
        for fact in facts:
            self.record[fact.kind, fact.key] = fact
            self.fleet.apply(fact)
        self.todo += step.doings
        if isinstance(event, e.AttemptEnded) and event.end is e.AttemptEnd.DONE:
            self._check_counted(before[event.task], event)
        for task in step.tasks:
            if task.id in before:
                self._check_change(before[task.id], task, event)

    def _check_counted(self, before: Task, event: e.AttemptEnded) -> None:
        newest = before.state in HELD and before.attempt == event.attempt
        if newest and before.done == before.asked:
            assert self.fleet.tasks[event.task].done == before.done + 1, "done in time counts"

    def _check_change(self, before: Task, after: Task, event: e.Event) -> None:
        assert after.done >= before.done, "what is done stays done"
        assert after.attempt - before.attempt in {0, 1}
        assert after.moves - before.moves in {0, 1} or isinstance(event, e.TaskReleased)
        if after.moves > before.moves:
            key = (before.id, before.attempt)
            assert before.state in HELD, "only what has a robot moves"
            assert key not in self.moved_from, f"{key} moved twice"
            self.moved_from.add(key)
        if isinstance(event, e.TaskReleased):
            self.doubted.pop(after.id, None)
        if after.done > before.done and not isinstance(event, e.TaskReleased):
            done = self.steps_done.setdefault(after.id, set())
            assert before.done not in done, f"step {before.done} of {after.id} counted twice"
            done.add(before.done)

    def candidates(self) -> dict[str, CandidateRobot]:
        """Return what a look shows now."""
        return {
            name: CandidateRobot(
                robot=name,
                free=robot.heard
                and not robot.latched
                and not robot.by_hand
                and robot.doing is None
                and not robot.moving,
                holder=robot.holder,
            )
            for name, robot in self.robots.items()
        }

    # ---- what may happen ----

    def give(self, a: int) -> None:
        if len(self.given) >= TASKS_AT_MOST:
            return
        key = self.fleet.next_id()
        open_tasks = [task.id for task in self.fleet.open()]
        task = Task(
            id=key,
            author=PEOPLE[a % 2],
            among=ROBOTS if a & 4 else (ROBOTS[a % 3], ROBOTS[(a + 1) % 3]),
            steps=1 + a % 3,
            priority=a % 4,
            given_ns=self.now_ns,
            once=bool(a & 8),
            after=tuple(open_tasks[:1]) if a & 16 else (),
        )
        self.given[key] = task
        self.feed(e.TaskGiven(task))

    def plan(self, _a: int) -> None:
        candidates = self.candidates()
        for tasks in by_priority(self.fleet, candidates, self.now_ns):
            pairs = nearest_idle(self.fleet, tasks, candidates, self.now_ns)
            for key, name in pairs:
                task, machine = self.fleet.tasks[key], self.robots[name]
                assert machine.holder in {None, task.author}, "somebody else's robot was chosen"
                assert not machine.latched
                assert machine.heard
                assert machine.doing is None
                del candidates[name]
                self.feed(e.RobotChosen(key, name))

    def guess(self, a: int) -> None:
        """A choice that was right a moment ago comes now."""
        if self.fleet.tasks:
            keys = list(self.fleet.tasks)
            self.feed(e.RobotChosen(keys[a % len(keys)], ROBOTS[a % 3]))

    def act(self, a: int) -> None:
        """One of the things that are to be done is done; those of one attempt in order."""
        if self.todo:
            doing = self.todo.pop(a % len(self.todo) if a & 1 else 0)
            if isinstance(doing, e.BeginAttempt):
                self._begin(doing)
            elif isinstance(doing, e.RecallAttempt):
                self._recall(doing)

    def _begin(self, doing: e.BeginAttempt) -> None:
        """Admit, claim, relay: as the organiser, the container and the linker would."""
        key = (doing.task, doing.attempt)
        task, machine = self.fleet.tasks[doing.task], self.robots[doing.robot]
        assert key not in self.begun, f"{key} was begun twice"
        self.begun.add(key)
        if task.attempt != doing.attempt or task.state not in HELD or task.leaving:
            self.inbox.append(
                e.AttemptEnded(*key, e.AttemptEnd.BUSY)
            )  # called back before it began
            return
        assert doing.step not in self.steps_done.get(doing.task, ()), "a step is done again"
        if machine.holder not in {None, task.author} or machine.latched or machine.by_hand:
            self.inbox.append(e.AttemptEnded(*key, e.AttemptEnd.BUSY))
            return
        assert self.doubted.get(task.id) != doing.step, "nobody knows whether it was done"
        if task.once:
            self.doubted[task.id] = doing.step
        assert not machine.moving, f"{doing.robot} is asked before it is at rest"
        assert machine.doing is None, f"{doing.robot} has two tasks: {machine.doing}, {key}"
        machine.holder = task.author
        machine.doing = (doing.task, doing.attempt, doing.step)
        self.claims[key] = None
        self.inbox.append(e.AttemptBegun(*key))

    def _recall(self, doing: e.RecallAttempt) -> None:
        key = (doing.task, doing.attempt)
        assert key not in self.recalled, f"{key} was called back twice"
        self.recalled.add(key)
        machine = self.robots[doing.robot]
        mine = machine.doing is not None and machine.doing[:2] == key
        if mine and not machine.heard:
            machine.cut_off = key  # it may go on, and nothing of it counts any more
            machine.latched = True
        elif mine:
            machine.doing = None
            self.claims[key] = e.AttemptEnd.STOPPED
        machine.moving = False
        if mine:
            machine.holder = None
        self.inbox.append(e.RobotRested(*key))

    def finish(self, a: int) -> None:
        """A robot ends what it does, well or badly; cut off, it is not believed."""
        machine = self.robots[ROBOTS[a % 3]]
        if machine.doing is None or not machine.heard:
            return
        task, attempt, _ = machine.doing
        end = (e.AttemptEnd.DONE, e.AttemptEnd.DONE, e.AttemptEnd.FAILED, e.AttemptEnd.UNKNOWN)[
            (a >> 2) % 4
        ]
        fenced = machine.cut_off == (task, attempt)
        machine.doing = machine.cut_off = None
        machine.moving = end is not e.AttemptEnd.DONE and not fenced
        if not fenced:
            self.claims[task, attempt] = end
        self.inbox.append(e.AttemptEnded(task, attempt, end))

    def hear(self, a: int) -> None:
        """One answer arrives, in any order, perhaps to arrive again."""
        if self.inbox:
            at = (a >> 1) % len(self.inbox)
            self.feed(self.inbox[at] if a & 1 else self.inbox.pop(at))

    def lose(self, a: int) -> None:
        self.robots[ROBOTS[a % 3]].heard = False

    def regain(self, a: int) -> None:
        self.robots[ROBOTS[a % 3]].heard = True

    def deviate(self, a: int) -> None:
        key = self.fleet.holds.get(ROBOTS[a % 3])
        if key is not None:
            why = TaskReason.LATE if self.robots[ROBOTS[a % 3]].heard else TaskReason.LOST
            self.feed(e.RobotDeviated(key, self.fleet.tasks[key].attempt, why))

    def stop(self, a: int) -> None:
        """A person stops a robot."""
        machine = self.robots[ROBOTS[a % 3]]
        machine.latched, machine.by_hand = True, False
        if machine.doing is not None and machine.heard:
            task, attempt, _ = machine.doing
            if machine.cut_off != (task, attempt):
                self.claims[task, attempt] = e.AttemptEnd.STOPPED
                machine.moving = True
            machine.doing = machine.cut_off = None
            self.inbox.append(e.AttemptEnded(task, attempt, e.AttemptEnd.STOPPED))

    def resume(self, a: int) -> None:
        """A person has looked: it is there, at rest, and may move again."""
        machine = self.robots[ROBOTS[a % 3]]
        if machine.heard and machine.doing is None and not machine.moving:
            machine.latched = False

    def take(self, a: int) -> None:
        """A person takes a robot for themselves, from its author if need be."""
        machine = self.robots[ROBOTS[a % 3]]
        if machine.latched or machine.moving or not machine.heard:
            return
        if machine.doing is not None:
            task, attempt, _ = machine.doing
            machine.doing = None
            self.claims[task, attempt] = e.AttemptEnd.TAKEN
            self.inbox.append(e.AttemptEnded(task, attempt, e.AttemptEnd.TAKEN))
        machine.holder, machine.by_hand = "eve", True

    def give_back(self, a: int) -> None:
        machine = self.robots[ROBOTS[a % 3]]
        if machine.doing is None:
            machine.holder, machine.by_hand = None, False

    def hold(self, a: int) -> None:
        if self.fleet.tasks:
            keys = list(self.fleet.tasks)
            why = TaskReason.CANCELLED if a & 8 else TaskReason.PAUSED
            self.feed(e.TaskHeld(keys[a % len(keys)], why))

    def release(self, a: int) -> None:
        if self.fleet.tasks:
            keys = list(self.fleet.tasks)
            self.feed(e.TaskReleased(keys[a % len(keys)], skip=bool(a & 8)))

    def stand(self, a: int) -> None:
        standing = (FleetMembership.ACTIVE, FleetMembership.DISABLED, FleetMembership.RETIRED)[
            (a >> 2) % 3
        ]
        self.feed(e.MembershipSet(ROBOTS[a % 3], standing))

    def hand(self, a: int) -> None:
        if self.fleet.tasks:
            keys = list(self.fleet.tasks)
            self.feed(e.TaskHanded(keys[a % len(keys)], PEOPLE[a % 2]))

    def crash(self, _a: int) -> None:
        """The gateway dies and comes back: what it had not written never was."""
        self.inbox.clear()
        self.todo.clear()
        before = self.fleet
        for machine in self.robots.values():
            if machine.doing is not None:
                machine.doing = machine.cut_off = None  # with its adapter gone it comes to rest
                machine.latched = True
            machine.by_hand = machine.moving = False
            machine.holder = None
        self.fleet = FleetState()
        self.fleet.restore(self.record.values())
        assert self.fleet.tasks == before.tasks, "what was so is what was written"
        assert self.fleet.holds == before.holds
        for key in list(self.fleet.holds.values()):
            task = self.fleet.tasks[key]
            attempt = (key, task.attempt)
            end = self.claims.get(attempt, e.AttemptEnd.BUSY)
            if end is None:
                self.doubted[key] = task.asked
            self.feed(e.TaskFound(key, end))
        assert not self.fleet.holds, "after a restart no robot has a task"
        assert not [doing for doing in self.todo if isinstance(doing, e.BeginAttempt)]

    # ---- what must be so ----

    def check(self) -> None:
        """Compare the fleet with its record, with itself and with the robots."""
        fleet = self.fleet
        held = [task for task in fleet.tasks.values() if task.state in HELD]
        assert len({task.robot for task in held}) == len(held), "a robot has two tasks"
        assert set(fleet.tasks) == set(self.given), "a task is lost"
        for task in fleet.tasks.values():
            places = (task.state in HELD) + (task.id in fleet.waiting)
            assert places == (task.state in HELD or task.state is TaskState.QUEUED)
            assert task.state is not TaskState.DONE or task.done == task.steps
        working: dict[str, str] = {}
        for name, machine in self.robots.items():
            assert not machine.moving or name in fleet.holds, f"{name} is idle and not at rest"
            if machine.doing is None or machine.cut_off == machine.doing[:2]:
                continue
            key, attempt, _ = machine.doing
            assert key not in working, f"task {key} is on {working[key]} and on {name}"
            working[key] = name
            assert fleet.holds.get(name) == key, f"{name} counts as idle and is at work"
            assert fleet.tasks[key].attempt == attempt

    def settle(self) -> None:
        """Nothing fails any more, and people see to what waits for them: it all comes to an end."""
        for number in range(len(ROBOTS)):
            self.regain(number)
            self.feed(e.MembershipSet(ROBOTS[number], FleetMembership.ACTIVE))
        for _ in range(60):
            for number in range(len(ROBOTS)):
                self.finish(number)  # well
                self.give_back(number)
                self.resume(number)
            while self.todo or self.inbox:
                self.act(0)
                self.hear(0)
            self._see_to()
            self.plan(0)
            self.check()
            if all(task.over for task in self.fleet.tasks.values()):
                break
        left = [task for task in self.fleet.tasks.values() if not task.over]
        assert not left, f"never comes to an end: {left}"

    def _see_to(self) -> None:
        for task in list(self.fleet.tasks.values()):
            if task.state in {TaskState.PAUSED, TaskState.FAILED, TaskState.UNKNOWN}:
                self.feed(e.TaskReleased(task.id))
            elif task.state is TaskState.QUEUED and self._in_vain(task):
                self.feed(e.TaskHeld(task.id, TaskReason.CANCELLED))

    def _in_vain(self, task: Task) -> bool:
        return any(self.fleet.tasks[key].state is TaskState.CANCELLED for key in task.after)


OPS = (
    "give",
    "give",
    "give",
    "plan",
    "plan",
    "plan",
    "plan",
    "act",
    "act",
    "act",
    "act",
    "act",
    "finish",
    "finish",
    "finish",
    "hear",
    "hear",
    "hear",
    "hear",
    "guess",
    "lose",
    "regain",
    "deviate",
    "deviate",
    "stop",
    "resume",
    "resume",
    "take",
    "give_back",
    "give_back",
    "hold",
    "release",
    "release",
    "stand",
    "hand",
    "crash",
)


def possible(world: World) -> list[str]:
    """Return what could make a difference now, so that no step of a history is wasted."""
    robots, tasks = world.robots.values(), world.fleet.tasks
    held = bool(world.fleet.holds)
    resting = any(not t.over and t.state not in HELD for t in tasks.values())
    useless = {
        "give": len(world.given) >= TASKS_AT_MOST,
        "plan": not world.fleet.waiting,
        "act": not world.todo,
        "hear": not world.inbox,
        "finish": not any(m.doing and m.heard for m in robots),
        "deviate": not held,
        "resume": not any(m.latched for m in robots),
        "regain": all(m.heard for m in robots),
        "give_back": not any(m.by_hand for m in robots),
        "release": not resting,
        "crash": not held,
    }
    return [op for op in OPS if not useless.get(op)]
