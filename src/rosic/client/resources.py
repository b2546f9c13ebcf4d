"""What there is beside orders: times, queues, a right for a while, tasks and missions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal
from urllib.parse import quote

from rosic.api.people_schemas import AccessRequestIn, AccessRequestOut
from rosic.api.resource_schemas import (
    AlertOut,
    BookingIn,
    BookingMoveIn,
    BookingOut,
    HistoryEntryOut,
    TelemetryOut,
)
from rosic.api.schemas import AnswerOut
from rosic.api.work_schemas import (
    MissionsOut,
    MissionStartIn,
    QueueEntryOut,
    TaskIn,
    TaskOut,
    UsageOut,
)

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import TypeVar

    T = TypeVar("T")


class ResourceCalls:
    """Asks for it. What only looks is asked again for some seconds; nothing else is sent twice.

    Each raises ApiProblem where the gateway says no, and NotAnswered where it does not answer. An
    `AnswerOut` is what the chat says; with the state ``asked`` somebody has to agree first.
    """

    async def _look(
        self,
        path: str,
        type_: type[T],
        *,
        params: Mapping[str, str | float] | None = None,
        more_s: float = 0.0,
    ) -> T:
        raise NotImplementedError

    async def _once(
        self, path: str, type_: type[T], body: object, more_s: float = 0.0, *, method: str = "POST"
    ) -> T:
        raise NotImplementedError

    # ---- times and queues ----

    async def bookings(
        self, robot: str = "", *, begin: str = "", end: str = ""
    ) -> list[BookingOut]:
        """Return whose time it is; of the week to come, if no times (RFC 3339) are said."""
        params = query(robot=robot, **{"from": begin, "to": end})
        return await self._look("bookings", list[BookingOut], params=params)

    async def book(self, robot: str, start: str, minutes: int) -> BookingOut:
        """Have a robot for a time, from a full minute (RFC 3339) on."""
        return await self._once("bookings", BookingOut, BookingIn(robot, start, minutes))

    async def move_booking(self, booking: str, start: str, minutes: int) -> BookingOut:
        """Move a booking of mine to another time; where that is refused, it stays what it was."""
        moved = BookingMoveIn(start, minutes)
        return await self._once(f"bookings/{part(booking)}", BookingOut, moved, method="PATCH")

    async def give_back(self, booking: str) -> AnswerOut:
        """Give a time back."""
        return await self._once(f"bookings/{part(booking)}", AnswerOut, None, method="DELETE")

    async def queue(self, robot: str = "") -> list[QueueEntryOut]:
        """Return who waits for which robot."""
        return await self._look("queue", list[QueueEntryOut], params=query(robot=robot))

    async def join_queue(self, robot: str) -> AnswerOut:
        """Wait for a robot."""
        return await self._once(f"robots/{part(robot)}/queue", AnswerOut, None)

    async def leave_queue(self, robot: str) -> AnswerOut:
        """Wait for a robot no longer."""
        return await self._once(f"robots/{part(robot)}/queue", AnswerOut, None, method="DELETE")

    async def take_turn(self, robot: str) -> AnswerOut:
        """Take the robot that is offered to me now."""
        return await self._once(f"robots/{part(robot)}/queue/take", AnswerOut, None)

    async def take_over(self, robot: str) -> AnswerOut:
        """Take a robot over from whoever has it; what it does ends first."""
        return await self._once(f"robots/{part(robot)}/take-over", AnswerOut, None)

    async def release(self, robot: str) -> AnswerOut:
        """Give a robot back."""
        return await self._once(f"robots/{part(robot)}/release", AnswerOut, None)

    # ---- a right for a while ----

    async def access_requests(self) -> list[AccessRequestOut]:
        """Return what I have asked for and wait for."""
        return await self._look("access-requests", list[AccessRequestOut])

    async def ask_for(self, robot: str, right: str, minutes: int) -> AnswerOut:
        """Ask whoever may give a right for it."""
        body = AccessRequestIn(robot, right, minutes)
        return await self._once("access-requests", AnswerOut, body)

    # ---- tasks and missions ----

    async def tasks(self) -> list[TaskOut]:
        """Return the open tasks that I may see."""
        return await self._look("tasks", list[TaskOut])

    async def give_task(self, on: str, *steps: str, options: str = "") -> AnswerOut:
        """Let whichever robot of ``on`` (or ``any``) can carry steps out, one after another."""
        return await self._once("tasks", AnswerOut, TaskIn(on, steps, options))

    async def act_on_task(
        self, task: str, act: Literal["pause", "go", "cancel", "done"]
    ) -> AnswerOut:
        """Hold a task, let it go on, end it, or say that it was done."""
        return await self._once(f"tasks/{part(task)}/{act}", AnswerOut, None)

    async def missions(self) -> MissionsOut:
        """Return which missions there are, and which run."""
        return await self._look("missions", MissionsOut)

    async def start_mission(self, name: str, values: str = "") -> AnswerOut:
        """Start a mission: now, or ``every mon 8:00``."""
        body = MissionStartIn(values)
        return await self._once(f"missions/{part(name)}/start", AnswerOut, body)

    async def act_on_mission(self, run: str, act: Literal["pause", "go", "cancel"]) -> AnswerOut:
        """Hold every task of a mission that runs, let them go on, or end them."""
        return await self._once(f"missions/runs/{part(run)}/{act}", AnswerOut, None)

    # ---- how it does, and the past ----

    async def telemetry(
        self, robot: str, value: str = "", *, since_s: float = 3_600.0
    ) -> TelemetryOut:
        """Return how a value of a robot was lately; without a value, which there are."""
        params = {**query(value=value), "since_s": since_s}
        return await self._look(f"robots/{part(robot)}/telemetry", TelemetryOut, params=params)

    async def utilisation(self) -> list[UsageOut]:
        """Return for how long each robot was at work today, and in seven days."""
        return await self._look("utilisation", list[UsageOut])

    async def alerts(self) -> list[AlertOut]:
        """Return the alarms that are open, the newest first."""
        return await self._look("alerts", list[AlertOut])

    async def seen(self, robot: str) -> AnswerOut:
        """Say that I have seen the alarms of a robot."""
        return await self._once(f"robots/{part(robot)}/alerts/seen", AnswerOut, None)

    async def history(
        self, robot: str = "", *, text: str = "", since_s: float = 86_400.0, limit: int = 100
    ) -> list[HistoryEntryOut]:
        """Return what was asked before, the newest first; of a robot, where I may read that."""
        params = {**query(robot=robot, text=text), "since_s": since_s, "limit": limit}
        return await self._look("history", list[HistoryEntryOut], params=params)


def part(name: str) -> str:
    """Return a name as a part of a path."""
    return quote(name, safe="") or "-"


def query(**params: str) -> dict[str, str | float]:
    """Return the parameters of a query that are said."""
    return {name: value for name, value in params.items() if value}
