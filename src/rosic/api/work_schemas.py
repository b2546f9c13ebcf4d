"""What is sent and received of queues, tasks and missions."""

from __future__ import annotations

from typing import Annotated

import msgspec

from rosic.api.schemas import Name


class QueueEntryOut(msgspec.Struct, frozen=True):
    """Somebody waits for a robot.

    Attributes:
        place: 1 is next.
        offered: It is their turn now; they have a minute to take it.
    """

    robot: str
    who: str
    own: bool
    place: int
    offered: bool


class TaskIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A task, in words of `/task`.

    Attributes:
        on: A robot, a group, or ``any``.
        steps: ``move 0.5 m left``; one after another.
        options: ``priority 5``, ``by 15:00``, ``battery 30 %``, as the chat has them.
    """

    on: Name
    steps: Annotated[
        tuple[Annotated[str, msgspec.Meta(min_length=1, max_length=200)], ...],
        msgspec.Meta(min_length=1, max_length=64),
    ]
    options: Annotated[str, msgspec.Meta(max_length=200)] = ""


class TaskOut(msgspec.Struct, frozen=True):
    """A task that is open.

    Attributes:
        what: In its author's words for them alone; else the names of its skills.
        state: ``queued``, ``assigned``, ``running``, ``paused``, ``failed`` or ``unknown``.
        wanted: A robot's id, a group's name; empty: any that can.
        robot: Who has it; empty: nobody.
        robots: Who can carry it out, as far as the caller may see them.
        done, steps: How many steps are done, of how many.
        mission: Id of the mission that it belongs to; empty: none.
        waits: Why it has not begun.
    """

    id: str
    what: str
    state: str
    who: str
    own: bool
    wanted: str
    robot: str
    robots: tuple[str, ...]
    done: int
    steps: int
    priority: int
    mission: str
    waits: str
    given: str


class MissionOut(msgspec.Struct, frozen=True):
    """A mission that the caller may start.

    Attributes:
        parameters: What is said when it is started, as people read it.
    """

    name: str
    title: str
    parameters: tuple[str, ...]


class MissionRunOut(msgspec.Struct, frozen=True):
    """A mission that was started, and is not over.

    Attributes:
        done, tasks: How many of its tasks are done, of how many.
        resting: How many of them wait for a person.
    """

    id: str
    done: int
    tasks: int
    resting: int


class MissionsOut(msgspec.Struct, frozen=True):
    """What may be started, and what runs."""

    missions: tuple[MissionOut, ...]
    runs: tuple[MissionRunOut, ...]


class MissionStartIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a mission is started, in words of `/mission`.

    Attributes:
        values: ``distance=2 m``, or when: ``every mon 8:00``; empty: now, as it is.
    """

    values: Annotated[str, msgspec.Meta(max_length=300)] = ""


class WorkShareOut(msgspec.Struct, frozen=True):
    """How busy a robot was in some time.

    Attributes:
        worked_s: So long it had a task, or an order that needs it for itself.
        share: Of the time that was counted, 0 to 1; a gateway that is down counts no work.
    """

    worked_s: float
    share: float


class UsageOut(msgspec.Struct, frozen=True):
    """How busy a robot was.

    Attributes:
        at_work: It is at work now.
        today: Since midnight, where the caller is.
        week: In the last seven days.
    """

    robot: str
    at_work: bool
    today: WorkShareOut
    week: WorkShareOut
