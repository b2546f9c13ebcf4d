"""What people read about tasks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import TaskReason, TaskState
from rosic.core.i18n import filled, joined, said, said_n
from rosic.core.language.sanitise import echo
from rosic.core.message import Button
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotPermitted
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.fleet.task import Task, TaskId
    from rosic.core.robot.skill import Skill


BETWEEN: Final = " · "
GO_ON: Final = said("Go on")
AGAIN: Final = said("Do it again")
WAS_DONE: Final = said("It was done")
CANCEL: Final = said("Cancel it")

_STATES: Final = {
    TaskState.QUEUED: said("waiting"),
    TaskState.ASSIGNED: said("being given to it"),
    TaskState.RUNNING: said("running"),
    TaskState.PAUSED: said("paused"),
    TaskState.DONE: said("done"),
    TaskState.FAILED: said("failed"),
    TaskState.CANCELLED: said("cancelled"),
    TaskState.UNKNOWN: said("not known whether it was done"),
}
_LEFT: Final = {
    TaskReason.FAILED: said("{robot} has failed at it"),
    TaskReason.LATE: said("{robot} takes too long"),
    TaskReason.LOST: said("{robot} is not heard of any more"),
    TaskReason.TAKEN: said("{robot} was needed for something else"),
    TaskReason.STOPPED: said("{robot} was stopped"),
    TaskReason.REFUSED: said("{robot} does not take it"),
    TaskReason.PAUSED: said("it was paused"),
    TaskReason.CANCELLED: said("it was cancelled"),
    TaskReason.WITHDRAWN: said("{robot} is not to be used now"),
    TaskReason.RESTARTED: said("ROSIC was restarted"),
    TaskReason.INTERRUPTED: said("ROSIC itself stood still"),
    TaskReason.EXPIRED: said("it was not begun in time"),
}
_REASONS: Final = {
    TaskReason.LATE: said("it took too long for task {task}"),
    TaskReason.TAKEN: said("it was needed for something else"),
    TaskReason.PAUSED: said("task {task} was paused"),
    TaskReason.CANCELLED: said("task {task} was cancelled"),
    TaskReason.WITHDRAWN: said("it is not to be used now"),
}

HOW_TO: Final = said(
    "Give a task like this: /task omni wave, or /task warehouse move 1 m then wave priority 2. "
    "It may end in: priority 0 to 9, by 15:00, within 5 min (a step), battery 30, localised, once."
)
NONE_OPEN: Final = said("No task is open.")
NO_STEPS: Final = said("Say what is to be done: /task omni wave.")
NOT_WANTED: Final = said("Its task left the robot before this could begin. Nothing was done.")
TOO_LATE: Final = said("That time is over. Nothing was done.")
ERASED: Final = said("what was said for it is erased")


# ---- giving ----


def given(task: Task, what: str, who: str, by: str) -> str:
    """Return that a task is taken in, and all that was understood of it.

    Args:
        task: The task.
        what: What is to be done.
        who: Who could.
        by: When it is too late to begin; empty: never.
    """
    conditions = _conditions(task, by)
    return joined(BETWEEN, [said("Task {task}: {what}", task=task.id, what=what), who, *conditions])


def _conditions(task: Task, by: str) -> list[str]:
    found: list[str] = []
    if by:
        found.append(said("begun by {time}, or not at all", time=by))
    if task.expected_ns:
        seconds = max(1, task.expected_ns // SECOND_NS)
        long = said("{seconds} s", seconds=seconds) if seconds % 60 else length(seconds)
        found.append(said("a step takes {length} at most", length=long))
    if task.priority != 1:
        found.append(said("priority {number}", number=task.priority))
    if task.need.battery:
        found.append(said("battery at least {share:g} %", share=task.need.battery))
    if task.need.localised:
        found.append(said("only a robot that knows where it is"))
    if task.once:
        found.append(said("never twice"))
    return found


def one_of(names: Sequence[str]) -> str:
    """Return who could carry a task out."""
    if len(names) == 1:
        return names[0]
    return said_n("one robot could", "one of {n} robots", len(names))


def no_command(shown: str, line: str) -> str:
    """Return that a line is nothing that a robot can do."""
    return said("{robot} cannot do this: {line}", robot=shown, line=line)


def nobody_can(name: str, why: str) -> str:
    """Return that no robot of a group can carry a task out."""
    if not name:
        return said("No robot that you see can do that. {why}", why=why)
    return said("Nobody of {name} can do that. {why}", name=name, why=why)


def for_example(why: str, line: str) -> str:
    """Return why a line cannot be taken as it stands, and one that could."""
    return joined(" ", (why, said("For example: {line}", line=line)))


def not_permitted(shown: str, skill: Skill) -> NotPermitted:
    """Return the refusal of whoever lacks the right."""
    return NotPermitted(
        said("You may not let {robot} do this: {skill}.", robot=shown, skill=_called(skill))
    )


def wants_a_person(shown: str, skill: Skill) -> NotPermitted:
    """Return the refusal of what somebody has to confirm each time."""
    return NotPermitted(
        said(
            "{robot} does this only when somebody confirms it: {skill}. Say it as a command.",
            robot=shown,
            skill=_called(skill),
        )
    )


def _called(skill: Skill) -> str:
    return skill.shown


def too_many(most: int) -> str:
    """Return that no more tasks are taken in."""
    return said(
        "{most} tasks are open already. Cancel some, or wait until they are done.", most=most
    )


def begins(tasks: Sequence[str], more: int) -> str:
    """Return what a robot that was resumed may begin by itself; at least one task."""
    named = ", ".join(tasks)
    first = said(
        "It moves by itself as soon as it is given a task that waits: {tasks}.", tasks=named
    )
    return joined(" ", (first, and_more(more))) if more else first


def too_many_of_one(most: int) -> str:
    """Return that somebody has as many tasks open as one person may have."""
    return said(
        "You have {most} tasks open already. Cancel some, or wait until they are done.", most=most
    )


def no_chat(name: str) -> str:
    """Return that nobody could be told what came of a task."""
    return said("{name} cannot be reached, so nothing is done for them.", name=name)


# ---- what becomes of it ----


def order_title(text: str, task: Task) -> str:
    """Return the first line of an order that belongs to a task."""
    if task.steps == 1:
        return said("{order} · task {task}", order=text, task=task.id)
    return said(
        "{order} · task {task}, step {step} of {steps}",
        order=text,
        task=task.id,
        step=task.done + 1,
        steps=task.steps,
    )


def reason(task: str, why: TaskReason) -> str:
    """Return why an order is cut short, as it stands in its outcome."""
    return filled(_REASONS.get(why, _REASONS[TaskReason.WITHDRAWN]), task=task)


def why_left(why: TaskReason, shown: str) -> str:
    """Return why a task left its robot."""
    return filled(_LEFT[why], robot=shown)


def state(task: Task) -> str:
    """Return where a task is in its life."""
    return said("leaving it") if task.leaving else _STATES[task.state]


def line(task: Task, what: str, shown: str, why: str = "") -> str:
    """Return one task in a list."""
    parts: list[str] = [said("{task}: {what}", task=task.id, what=what)]
    if shown:
        parts.append(shown)
    parts.append(state(task))
    if task.steps > 1:
        parts.append(said("{done} of {steps} steps done", done=task.done, steps=task.steps))
    if task.priority != 1:
        parts.append(said("priority {number}", number=task.priority))
    if why:
        parts.append(why)
    return joined(BETWEEN, parts)


def leaves(task: Task, what: str, shown: str) -> str:
    """Return that a task leaves its robot."""
    if task.why is TaskReason.LOST:
        ends = said("Nothing that it does for the task counts from now on.")
    else:
        ends = said("It is brought to rest first.")
    return joined(" ", [_headed(task, what, why_left(task.why, shown)), ends])


def waits(task: Task, what: str, *, rested: bool, shown: str) -> str:
    """Return that a task waits for another robot, or for the same, if there is no other."""
    parts: list[str] = [_headed(task, what, why_left(task.why, shown))]
    if not rested:
        parts.append(not_seen_at_rest(shown))
    if len(task.among) == 1:
        parts.append(said("The task waits for {robot}.", robot=shown))
    else:
        parts.append(said("The task goes to another robot."))
    if task.steps > 1:
        parts.append(
            said("{done} of {steps} steps are done and stay so.", done=task.done, steps=task.steps)
        )
    return joined(" ", parts)


def not_seen_at_rest(shown: str) -> str:
    """Return that a robot was cut off without being seen at rest."""
    return said(
        "{robot} was not seen at rest: it is stopped, and stays so until somebody has looked.",
        robot=shown,
    )


def goes_on(task: Task, what: str, shown: str) -> str:
    """Return that another robot has it."""
    return _headed(task, what, said("{robot} goes on with it", robot=shown))


def over(task: Task, what: str, shown: str) -> str:
    """Return that a task is done."""
    return _headed(task, what, said("done by {robot}", robot=shown) if shown else said("done"))


def stands(task: Task, what: str, shown: str, why: str) -> str:
    """Return that a task waits for a person, or is over without being done."""
    parts: list[str] = [_headed(task, what, state(task))]
    note = "" if task.why in _REASONS else why  # else it says the same once more
    cause = (
        why_left(task.why, shown or said("its robot")) if task.why is not TaskReason.NONE else ""
    )
    if note and not note.endswith("."):
        cause, note = joined(": ", filter(None, (cause, note))), ""
    if cause and task.why not in {TaskReason.PAUSED, TaskReason.CANCELLED}:
        parts.append(said("Why: {cause}.", cause=cause))
    if note:
        parts.append(note)
    if task.steps > 1:
        parts.append(said("{done} of {steps} steps are done.", done=task.done, steps=task.steps))
    return joined(" ", parts)


def _headed(task: Task, what: str, text: str) -> str:
    return said("Task {task} ({what}): {text}.", task=task.id, what=what, text=text)


def choices(task: Task) -> tuple[tuple[Button, ...], ...]:
    """Return what whoever looks after a task that rests can tap."""
    cancel = Button(CANCEL, f"/task cancel {task.id}")
    if task.state is TaskState.UNKNOWN:
        again = Button(AGAIN, f"/task go {task.id}")
        return ((Button(WAS_DONE, f"/task done {task.id}"), again), (cancel,))
    if task.why is TaskReason.EXPIRED:
        return ((cancel,),)
    if task.state in {TaskState.PAUSED, TaskState.FAILED}:
        label = GO_ON if task.state is TaskState.PAUSED else AGAIN
        return ((Button(label, f"/task go {task.id}"), cancel),)
    return ()


# ---- what people do to it ----


def no_such_task(number: str) -> str:
    """Return that a number means no task."""
    return said("I know no task {number}.", number=echo(number))


def not_yours(task: Task, name: str) -> str:
    """Return that somebody else looks after a task."""
    return said(
        "Task {task} is {name}'s. They can do that, or whoever may assign tasks here.",
        task=task.id,
        name=name,
    )


def does_not_fit(task: Task) -> str:
    """Return that what was asked makes no sense for a task as it is."""
    return said("Task {task} is {state}. Nothing was changed.", task=task.id, state=state(task))


def begins_no_more(task: Task) -> str:
    """Return that the time is over by which a task was to be begun."""
    return said(
        "Task {task} was to be begun by a time that is over. Give it anew. Nothing was changed.",
        task=task.id,
    )


def being_held(task: Task, shown: str) -> str:
    """Return that a task is about to be paused or cancelled."""
    return said(
        "Task {task}: {robot} is brought to rest; I tell you when it is.",
        task=task.id,
        robot=shown,
    )


def now_is(task: Task, why: str = "") -> str:
    """Return how a task is now; of one that waits, what it waits for."""
    now = said("Task {task}: {state}.", task=task.id, state=state(task))
    return joined(" ", (now, said("Why: {cause}.", cause=why))) if why else now


def too_many_steps(most: int) -> str:
    """Return that a task has too many steps."""
    return said("A task has at most {most} steps.", most=most)


def too_much_to_read(steps: int, robots: int, most: int) -> str:
    """Return that a task has too many steps for so many robots."""
    return said(
        "That is {steps} different steps for {robots} robots; steps times robots are at most "
        "{most} in one task. Name fewer robots, or give several tasks. Nothing was done.",
        steps=steps,
        robots=robots,
        most=most,
    )


def too_long(most: int) -> str:
    """Return that more was said than is read."""
    return said(
        "A task is said in at most {most} characters. Give several. Nothing was done.", most=most
    )


def no_priority(least: int, most: int) -> str:
    """Return the bounds of a priority."""
    return said("A priority is a number from {least} to {most}.", least=least, most=most)


def no_time() -> str:
    """Return that a step cannot take no time."""
    return said("A step takes longer than that. Nothing was done.")


def no_battery() -> str:
    """Return the bounds of a battery."""
    return said("A battery is between 1 and 100 %.")


def and_more(count: int) -> str:
    """Return that a list goes on."""
    return said_n("and one more", "and {n} more", count)


def waits_for(tasks: Sequence[str]) -> str:
    """Return which tasks come first."""
    return said("after {tasks}", tasks=", ".join(tasks))


# ---- deadlines ----


def task(number: TaskId, what: str, lasts: str, cancels: bool) -> str:
    """Return that one task is late."""
    late = said(
        "Task {task} ({what}) is late: it was to be done within {time}.",
        task=number,
        what=what,
        time=lasts,
    )
    return _and_then(late, cancels)


def mission(run: str, moment: str, done: tuple[int, int], cancels: bool) -> str:
    """Return that a mission is late.

    Args:
        run: Its name and number.
        moment: By when it was to be done.
        done: How many of how many tasks are.
        cancels: The rest is cancelled.
    """
    late = said(
        "{mission} is late: it was to be done by {time}. {done} of {tasks} tasks are done.",
        mission=run,
        time=moment,
        done=done[0],
        tasks=done[1],
    )
    return _and_then(late, cancels)


def _and_then(late: str, cancels: bool) -> str:
    goes_on = said("It goes on.")
    rest = said("The rest of it is cancelled; what moves comes to rest first.")
    return joined(" ", (late, rest if cancels else goes_on))
