"""The routes of queues, of handing robots over, of tasks and of missions.

What changes something is said as a line, like whatever else is said: the same rights, the same
sentences, the same record.
"""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, Annotated, Final, Literal

from litestar import delete, get, post
from litestar.params import FromPath, JSONBody, QueryParameter
from litestar.status_codes import HTTP_200_OK, HTTP_201_CREATED

from rosic.api.lines import one_line
from rosic.api.routes import Api, Speech, Who
from rosic.api.schemas import AnswerOut, moment
from rosic.api.work_schemas import (
    MissionOut,
    MissionRunOut,
    MissionsOut,
    MissionStartIn,
    QueueEntryOut,
    TaskIn,
    TaskOut,
    UsageOut,
    WorkShareOut,
)
from rosic.core.fleet.task import RESTING, TaskState
from rosic.core.i18n import in_language, said
from rosic.core.local_time import LocalTime
from rosic.core.time_units import DAY_NS
from rosic.errors import NotFound, NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.pending_work import FleetWork, TaskEntry, TimeAtWork

UNKNOWN_TASK: Final = said("There is no such open task, as far as you may see.")
UNKNOWN_MISSION: Final = said("There is no such mission that you may start.")
UNKNOWN_RUN: Final = said("There is no such mission under way, as far as you may see.")
_NUMBERED: Final = re.compile(r"\S+\s+\d+\s*\Z")
NO_STEP: Final = said("A step is words of one line, without a semicolon. Nothing was done.")
WEEK_NS: Final = 7 * DAY_NS
ROBOTS_AT_ONCE: Final = 20
Robot = Annotated[str, QueryParameter(name="robot", max_length=64)]

# ---- queues, and whose a robot is ----


@get("/queue", summary="Who waits for a robot", tags=["bookings"])
async def queue(api: Api, caller: Who, robot: Robot = "") -> list[QueueEntryOut]:
    """Return who waits for robots that the caller may see, the next one of each first."""
    wanted = [api.profile(caller, robot).id] if robot else sorted(api.visible(caller))
    return [one for each in wanted for one in _queue(api, caller, each)]


def _queue(api: ApiContext, caller: ApiCaller, robot: RobotId) -> Iterator[QueueEntryOut]:
    waiting, name = api.kernel.access.waiting, api.kernel.rooms.authoriser.directory.name
    offer = waiting.standing(robot)
    for place, who in enumerate(waiting.queue(robot), 1):
        offered = offer is not None and offer.principal == who
        yield QueueEntryOut(robot, name(who), who == caller.principal, place, offered)


@post(
    "/robots/{robot:str}/queue",
    status_code=HTTP_200_OK,
    summary="Wait for a robot",
    tags=["bookings"],
)
async def join_queue(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """Wait for a robot, as `/wait` does: who is told when it is their turn."""
    return await speech.command(caller, f"/wait {api.profile(caller, robot).id}")


@delete(
    "/robots/{robot:str}/queue",
    status_code=HTTP_200_OK,
    summary="Wait for it no longer",
    tags=["bookings"],
)
async def leave_queue(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """Wait for a robot no longer."""
    return await speech.command(caller, f"/wait none {api.profile(caller, robot).id}")


@post(
    "/robots/{robot:str}/queue/take",
    status_code=HTTP_200_OK,
    summary="It is my turn, and I take it",
    tags=["bookings"],
)
async def take_turn(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """Take the robot that is offered to the caller now."""
    return await speech.command(caller, f"/wait take {api.profile(caller, robot).id}")


@post(
    "/robots/{robot:str}/take-over",
    status_code=HTTP_200_OK,
    summary="Take a robot over",
    tags=["bookings"],
)
async def take_over(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """Take a robot over from whoever has it, where the rules of the place let the caller.

    What it does ends first, and rest is measured.
    """
    return await speech.command(caller, f"/take over {api.profile(caller, robot).id}")


@post(
    "/robots/{robot:str}/release",
    status_code=HTTP_200_OK,
    summary="Give a robot back",
    tags=["bookings"],
)
async def release(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """End the caller's time with a robot, or somebody's, for whoever looks after the place."""
    return await speech.command(caller, f"/end {api.profile(caller, robot).id}")


# ---- tasks ----


@get("/tasks", summary="What is being worked on, and what waits", tags=["fleet"])
async def tasks(api: Api, caller: Who) -> list[TaskOut]:
    """Return the open tasks that the caller may see, those that have a robot first."""
    work = _work(api, caller)
    return [] if work is None else [_task(api, caller, t) for t in work.tasks_for(caller.principal)]


@post("/tasks", status_code=HTTP_201_CREATED, summary="Give a task", tags=["fleet"])
async def give_task(speech: Speech, caller: Who, data: JSONBody[TaskIn]) -> AnswerOut:
    """Let whichever robot can carry something out, as `/task` does."""
    steps = [one_line(step) for step in data.steps]
    if any(";" in step for step in steps):
        raise NotUnderstood(NO_STEP)
    options = f" {one_line(data.options)}" if data.options.strip() else ""
    line = f"{one_line(data.on)} {'; '.join(steps)}{options}"
    if _NUMBERED.match(line):  # as "pause 7", which does something with a task that there is
        raise NotUnderstood(NO_STEP)
    return await speech.command(caller, f"/task {line}")


@post(
    "/tasks/{task:str}/{act:str}",
    status_code=HTTP_200_OK,
    summary="Hold a task, let it go on, end it",
    tags=["fleet"],
)
async def act_on_task(
    api: Api,
    speech: Speech,
    caller: Who,
    task: FromPath[str],
    act: FromPath[Literal["pause", "go", "cancel", "done"]],
) -> AnswerOut:
    """Hold a task (`pause`), let it go on (`go`), end it (`cancel`), say that it was `done`."""
    work = _work(api, caller)
    found = () if work is None else work.tasks_for(caller.principal)
    if task not in {entry.task.id for entry in found}:
        raise NotFound(UNKNOWN_TASK)
    return await speech.command(caller, f"/task {act} {task}")


@get("/utilisation", summary="How busy robots were", tags=["fleet"])
async def utilisation(api: Api, caller: Who) -> list[UsageOut]:
    """Return for how long robots that the caller may see were at work today, and in seven days."""
    work = _work(api, caller)
    if work is None:
        return []
    zone, now_ns = (
        api.kernel.rooms.organiser.calendar.zone(caller.principal),
        api.kernel.clock.wall_ns(),
    )
    midnight_ns = zone.instant(LocalTime.at(zone.local(now_ns).day_number)).start_ns
    found = []
    for number, robot in enumerate(sorted(api.visible(caller))):
        if number % ROBOTS_AT_ONCE == ROBOTS_AT_ONCE - 1:
            await asyncio.sleep(0)
        today = work.work_of(robot, midnight_ns, now_ns)
        week = work.work_of(robot, now_ns - WEEK_NS, now_ns)
        found.append(UsageOut(robot, today.now, _share(today), _share(week)))
    return found


def _share(time: TimeAtWork) -> WorkShareOut:
    share = min(1.0, time.worked_s / time.counted_s) if time.counted_s > 0 else 0.0
    return WorkShareOut(round(time.worked_s, 3), round(share, 4))


def _work(api: ApiContext, caller: ApiCaller) -> FleetWork | None:
    return None if api.is_locked_out(caller) else api.kernel.shared.work.find()


def _task(api: ApiContext, caller: ApiCaller, entry: TaskEntry) -> TaskOut:
    task, catalogue = entry.task, api.languages.of(caller.principal)
    visible = api.visible(caller)
    return TaskOut(
        id=task.id,
        what=in_language(entry.what, catalogue),
        state=task.state.value,
        who=api.kernel.rooms.authoriser.directory.name(task.author),
        own=task.author == caller.principal,
        wanted=task.wanted,
        robot=task.robot if task.robot in visible else "",
        robots=tuple(robot for robot in task.among if robot in visible),
        done=task.done,
        steps=task.steps,
        priority=task.priority,
        mission=task.mission,
        waits=in_language(entry.waits, catalogue),
        given=moment(task.given_ns),
    )


# ---- missions ----


@get("/missions", summary="Which missions there are, and what runs", tags=["fleet"])
async def missions(api: Api, caller: Who) -> MissionsOut:
    """Return the missions that the caller may start, and those that run."""
    work = _work(api, caller)
    if work is None:
        return MissionsOut((), ())
    catalogue = api.languages.of(caller.principal)
    return MissionsOut(
        tuple(
            MissionOut(
                one.name, one.title, tuple(in_language(p, catalogue) for p in one.parameters)
            )
            for one in work.missions_for(caller.principal)
        ),
        tuple(
            MissionRunOut(
                run.id,
                sum(task.state is TaskState.DONE for task in run.tasks),
                len(run.tasks),
                sum(task.state in RESTING for task in run.tasks),
            )
            for run in work.runs_for(caller.principal)
        ),
    )


@post(
    "/missions/{mission:str}/start",
    status_code=HTTP_200_OK,
    summary="Start a mission",
    tags=["fleet"],
)
async def start_mission(
    api: Api, speech: Speech, caller: Who, mission: FromPath[str], data: JSONBody[MissionStartIn]
) -> AnswerOut:
    """Start a mission, now or when it is said, as `/mission start` does."""
    work = _work(api, caller)
    known = () if work is None else work.missions_for(caller.principal)
    if mission not in {one.name for one in known}:
        raise NotFound(UNKNOWN_MISSION)
    values = f" {one_line(data.values)}" if data.values.strip() else ""
    return await speech.command(caller, f"/mission start {mission}{values}")


@post(
    "/missions/runs/{run:str}/{act:str}",
    status_code=HTTP_200_OK,
    summary="Hold a mission, let it go on, end it",
    tags=["fleet"],
)
async def act_on_mission(
    api: Api,
    speech: Speech,
    caller: Who,
    run: FromPath[str],
    act: FromPath[Literal["pause", "go", "cancel"]],
) -> AnswerOut:
    """Hold every task of a mission that runs (`pause`), let them go on (`go`), or `cancel` it."""
    work = _work(api, caller)
    known = () if work is None else work.runs_for(caller.principal)
    if run not in {one.id for one in known}:
        raise NotFound(UNKNOWN_RUN)
    return await speech.command(caller, f"/mission {act} {run}")


ROUTES: Final = (
    queue,
    join_queue,
    leave_queue,
    take_turn,
    take_over,
    release,
    tasks,
    give_task,
    act_on_task,
    utilisation,
    missions,
    start_mission,
    act_on_mission,
)
