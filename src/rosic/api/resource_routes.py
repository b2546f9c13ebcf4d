"""The routes of what there is beside orders: telemetry, times, people, alarms, files, the past.

What changes something is said as a line, like whatever else is said: the same rights, the same
sentences, the same record.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Final
from urllib.parse import quote

from litestar import Response, delete, get, patch, post
from litestar.params import FromPath, JSONBody, QueryParameter
from litestar.response import Stream as StreamedResponse
from litestar.status_codes import HTTP_200_OK, HTTP_201_CREATED

from rosic.api.resource_schemas import (
    AlertOut,
    BookingIn,
    BookingMoveIn,
    BookingOut,
    FileOut,
    HealthFindingOut,
    PersonOut,
    SampleOut,
    TelemetryOut,
)
from rosic.api.routes import Api, Speech, Who
from rosic.api.schemas import AnswerOut, moment
from rosic.container.files import pieces_of
from rosic.core.i18n import in_language, said
from rosic.core.role_names import role_shown
from rosic.core.time_units import DAY_NS, MINUTE_NS, SECOND_NS
from rosic.errors import NotFound, NotUnderstood
from rosic.organiser.calendar_messages import bookable, moment_typed

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.container.files import StoredFile
    from rosic.core.slot import BookedSlot
    from rosic.gateway.container_context import ContainerContext

WEEK_NS: Final = 7 * DAY_NS
SPAN_NS: Final = 62 * DAY_NS
LISTED_AT_MOST: Final = 1_000
NO_MOMENT: Final = said("That is no time: write it as 2027-02-01T14:00:00Z.")
NO_MINUTE: Final = said("A booking begins at a full minute.")
SPAN: Final = said("Ask for at most 62 days at once, the earlier day first.")
UNKNOWN_BOOKING: Final = said("There is no such booking, as far as you may see.")
UNKNOWN_FILE: Final = said("You keep no such file here.")
DOCTORS_ONLY: Final = said("What the doctor finds is shown to whoever looks after people.")
PEOPLE_ONLY: Final = said("Who is known here is shown to whoever looks after people.")
Robot = Annotated[str, QueryParameter(name="robot", max_length=64)]


@get("/robots/{robot:str}/telemetry", summary="How a value was lately", tags=["robots"])
async def telemetry(
    api: Api,
    caller: Who,
    robot: FromPath[str],
    value: Annotated[str, QueryParameter(name="value", max_length=64)] = "",
    since_s: Annotated[float, QueryParameter(name="since_s", ge=0, le=86_400)] = 3_600.0,
) -> TelemetryOut:
    """Return what a robot has reported of a value, as far as it is kept; none: which there are."""
    profile = api.profile(caller, robot)
    shared = api.kernel.shared.telemetry.find()
    names = () if shared is None else tuple(shared.names(robot))
    told = shared.values(robot, value) if shared is not None and value in names else ()
    now_ns = api.kernel.machine_clock.wall_ns()
    samples = tuple(
        SampleOut(moment(now_ns - int(ago_s * SECOND_NS)), number)
        for ago_s, number in told
        if ago_s <= since_s
    )
    known = profile.telemetry.get(value)
    return TelemetryOut(robot, value, "" if known is None else known.unit, names, samples)


# ---- bookings ----


@get("/bookings", summary="Whose time it is", tags=["bookings"])
async def bookings(
    api: Api,
    caller: Who,
    robot: Robot = "",
    begin: Annotated[str, QueryParameter(name="from", max_length=40)] = "",
    end: Annotated[str, QueryParameter(name="to", max_length=40)] = "",
) -> list[BookingOut]:
    """Return the times of robots that the caller may see; of the week to come, if none is said."""
    if robot:
        api.profile(caller, robot)
    from_ns = _read(begin) if begin else api.kernel.clock.wall_ns()
    to_ns = _read(end) if end else from_ns + WEEK_NS
    if not 0 < to_ns - from_ns <= SPAN_NS:
        raise NotUnderstood(SPAN)
    wanted = [robot] if robot else sorted(api.visible(caller))
    calendar = api.kernel.rooms.organiser.calendar
    found = [slot for each in wanted for slot in calendar.on(each, from_ns, to_ns)]
    found.sort(key=lambda slot: slot.start_ns)
    return [_booking(api, caller, slot) for slot in found[:LISTED_AT_MOST]]


@post("/bookings", status_code=HTTP_201_CREATED, summary="Book a robot", tags=["bookings"])
async def book(api: Api, speech: Speech, caller: Who, data: JSONBody[BookingIn]) -> BookingOut:
    """Have a robot for a time, as `/book` does."""
    robot = api.profile(caller, data.robot).id
    start_ns = _minute(data.start)
    calendar = api.kernel.rooms.organiser.calendar
    line = bookable(robot, start_ns, data.minutes * 60, calendar.zone(caller.principal))
    answer = await speech.settled(caller, f"/{line}")
    for slot in calendar.on(robot, start_ns, start_ns + MINUTE_NS):
        if slot.principal == caller.principal and slot.start_ns == start_ns:
            return _booking(api, caller, slot)
    raise NotUnderstood(answer.text)


@delete(
    "/bookings/{booking:str}",
    status_code=HTTP_200_OK,
    summary="Give a time back",
    tags=["bookings"],
)
async def give_back(api: Api, speech: Speech, caller: Who, booking: FromPath[str]) -> AnswerOut:
    """Give a time back, as `/cancel booking` does; one that has begun ends now."""
    return await speech.command(caller, f"/cancel booking only {_known(api, caller, booking).id}")


@patch("/bookings/{booking:str}", summary="Move a booking", tags=["bookings"])
async def move(
    api: Api, speech: Speech, caller: Who, booking: FromPath[str], data: JSONBody[BookingMoveIn]
) -> BookingOut:
    """Move a booking to another time, as `/rebook` does; where that is refused, it stays."""
    slot, start_ns = _known(api, caller, booking), _minute(data.start)
    calendar = api.kernel.rooms.organiser.calendar
    when = moment_typed(start_ns, data.minutes * 60, calendar.zone(caller.principal))
    answer = await speech.settled(caller, f"/rebook {slot.id} {when}")
    moved = calendar.slot(slot.id)
    if moved is None or moved.start_ns != start_ns:
        raise NotUnderstood(answer.text)
    return _booking(api, caller, moved)


def _known(api: ApiContext, caller: ApiCaller, booking: str) -> BookedSlot:
    """Return a booking that somebody may know of.

    Raises:
        NotFound: There is none, as far as they may see.
    """
    slot = api.kernel.rooms.organiser.calendar.slot(booking)
    if slot is None or (
        slot.principal != caller.principal and slot.robot not in api.visible(caller)
    ):
        raise NotFound(UNKNOWN_BOOKING)
    return slot


def _booking(api: ApiContext, caller: ApiCaller, slot: BookedSlot) -> BookingOut:
    return BookingOut(
        id=slot.id,
        robot=slot.robot,
        who=api.kernel.rooms.authoriser.directory.name(slot.principal),
        own=slot.principal == caller.principal,
        start=moment(slot.start_ns),
        end=moment(slot.end_ns),
        series=slot.series,
    )


def _minute(text: str) -> int:
    """Read when a booking begins, in nanoseconds of the wall clock.

    Raises:
        NotUnderstood: It is no time, or no full minute.
    """
    start_ns = _read(text)
    if start_ns % MINUTE_NS:
        raise NotUnderstood(NO_MINUTE)
    return start_ns


def _read(text: str) -> int:
    """Read a time of RFC 3339, in nanoseconds of the wall clock.

    Raises:
        NotUnderstood: It is none, or says no zone.
    """
    try:
        found = datetime.fromisoformat(text)
        if found.tzinfo is None:
            raise NotUnderstood(NO_MOMENT)
        whole = found.astimezone(UTC)
        return int(whole.timestamp()) * SECOND_NS + whole.microsecond * 1_000
    except (ValueError, OverflowError):
        raise NotUnderstood(NO_MOMENT) from None


# ---- people, alarms ----


@get("/people", summary="Who is known here", tags=["people"])
async def people(api: Api, caller: Who) -> list[PersonOut]:
    """Return everybody who is known, for whoever looks after people."""
    api.check_admin(caller, PEOPLE_ONLY)
    catalogue = api.languages.of(caller.principal)
    locked = api.kernel.rooms.organiser.locked
    known = api.kernel.rooms.authoriser.directory.people()
    return [
        PersonOut(
            id=one.id,
            name=one.name,
            kind="program" if one.is_program else "person",
            roles=one.roles,
            locked=one.id in locked,
            named=tuple(in_language(role_shown(role), catalogue) for role in one.roles),
            accounts=() if one.is_program else tuple(map(str, one.addresses)),
        )
        for one in known
    ]


@get("/health", summary="What the doctor finds", tags=["health"])
async def health(api: Api, caller: Who) -> list[HealthFindingOut]:
    """Return how the gateway and its machine do, for whoever looks after people."""
    api.check_admin(caller, DOCTORS_ONLY)
    doctor = api.kernel.shared.health.find()
    catalogue = api.languages.of(caller.principal)
    found = () if doctor is None else await doctor.findings()
    return [
        HealthFindingOut(one.about, one.verdict, in_language(one.text, catalogue)) for one in found
    ]


@get("/alerts", summary="What is wrong now", tags=["alerts"])
async def alerts(api: Api, caller: Who) -> list[AlertOut]:
    """Return the open alarms of robots that the caller may see, the newest first."""
    shared = api.kernel.shared.alerts.find()
    found = () if shared is None else shared.open_now(api.visible(caller))
    catalogue = api.languages.of(caller.principal)
    name = api.kernel.rooms.authoriser.directory.name
    return [
        AlertOut(
            robot=one.robot,
            name=one.name,
            text=in_language(one.said, catalogue),
            at=moment(one.at_ns),
            measured=in_language(one.measured, catalogue),
            seen_by=name(one.by) if one.by else "",
        )
        for one in found
    ]


@post(
    "/robots/{robot:str}/alerts/seen",
    status_code=HTTP_200_OK,
    summary="I have seen what is wrong",
    tags=["alerts"],
)
async def seen(api: Api, speech: Speech, caller: Who, robot: FromPath[str]) -> AnswerOut:
    """Say that the caller has seen the alarms of a robot, as `/seen` does."""
    return await speech.command(caller, f"/seen {api.profile(caller, robot).id}")


# ---- files ----


@get("/files", summary="My files", tags=["files"])
async def files(api: Api, caller: Who) -> list[FileOut]:
    """Return the caller's own files."""
    containers = _containers(api, caller)
    kept = () if containers is None else containers.files.of(caller.principal)
    return [
        FileOut(one.id, one.name, one.size, one.media_type, one.digest.hex(), moment(one.at_ns))
        for one in kept
    ]


@get("/files/{file:str}", summary="What is in a file", tags=["files"])
async def file_content(api: Api, caller: Who, file: FromPath[str]) -> StreamedResponse:
    """Return the content of a file of the caller's; a browser only saves it."""
    containers, filed = _own_file(api, caller, file)
    headers = {
        "Content-Disposition": f"attachment; filename*=UTF-8''{quote(filed.name, safe='')}",
        "Content-Length": str(filed.size),
        "Cache-Control": "no-store",
    }
    pieces = pieces_of(containers.container_store, filed)
    return StreamedResponse(pieces, media_type="application/octet-stream", headers=headers)


@delete("/files/{file:str}", summary="Delete a file", tags=["files"])
async def delete_file(api: Api, caller: Who, file: FromPath[str]) -> Response[None]:
    """Delete a file of the caller's, for good."""
    containers, _ = _own_file(api, caller, file)
    async with containers.changes.turn() as turn:
        await turn.write(containers.files.drop(_own_file(api, caller, file)[1].id))
    return Response(None, status_code=204)


def _containers(api: ApiContext, caller: ApiCaller) -> ContainerContext | None:
    """Return what is kept; None where it cannot be looked into, and for whoever is locked out."""
    return None if api.is_locked_out(caller) else api.kernel.containers


def _own_file(api: ApiContext, caller: ApiCaller, file: str) -> tuple[ContainerContext, StoredFile]:
    containers = _containers(api, caller)
    if containers is not None:
        for one in containers.files.of(caller.principal):
            if one.id == file:
                return containers, one
    raise NotFound(UNKNOWN_FILE)


ROUTES: Final = (
    telemetry,
    bookings,
    book,
    give_back,
    move,
    people,
    health,
    alerts,
    seen,
    files,
    file_content,
    delete_file,
)
