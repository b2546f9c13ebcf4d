"""The routes of the past: what was asked before, searched, and as a table to keep."""

from __future__ import annotations

import asyncio
import csv
from io import StringIO
from typing import TYPE_CHECKING, Annotated, Final

from litestar import Response, get
from litestar.params import QueryParameter

from rosic.api.resource_schemas import HistoryEntryOut
from rosic.api.routes import Api, Who
from rosic.api.schemas import moment
from rosic.core.history import HistoryQuery
from rosic.core.i18n import in_language, plain, said
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotFound

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.gateway.observed_state import HistoryLine

LISTED_AT_MOST: Final = 1_000
SEARCHED_AT_MOST: Final = 5_000
STEP: Final = 20
NO_RECORD: Final = said("This record cannot be looked into.")
CSV: Final = "text/csv"
COLUMNS: Final = ("at", "who", "kind", "robot", "skill", "asked", "outcome", "came", "ended")
FORMULAS: Final = ("=", "+", "-", "@", "\t", "\r")
"""A spreadsheet would reckon with what begins so."""
Robot = Annotated[str, QueryParameter(name="robot", max_length=64)]
Text = Annotated[str, QueryParameter(name="text", max_length=100)]
Since = Annotated[float, QueryParameter(name="since_s", ge=0, le=3e8)]


@get("/history", summary="What was asked before", tags=["history"])
async def history(
    api: Api,
    caller: Who,
    robot: Robot = "",
    text: Text = "",
    since_s: Since = 86_400.0,
    most: Annotated[int, QueryParameter(name="limit", ge=1, le=LISTED_AT_MOST)] = 100,
) -> list[HistoryEntryOut]:
    """Return what was asked for, the newest first; with a text, what has it somewhere.

    One's own; of a robot also what others asked, for whoever may read that. A text is looked for in
    the newest 5,000.
    """
    return (await _found(api, caller, robot, text, since_s, most))[:most]


@get(
    "/history/export",
    summary="What was asked before, as a table",
    tags=["history"],
    media_type=CSV,
)
async def export(
    api: Api, caller: Who, robot: Robot = "", text: Text = "", since_s: Since = 3e8
) -> Response[bytes]:
    """Return the same as a file of comma-separated values in UTF-8, at most 5,000 lines."""
    found = await _found(api, caller, robot, text, since_s, SEARCHED_AT_MOST)
    written = StringIO()
    table = csv.writer(written, lineterminator="\r\n")
    table.writerow(COLUMNS)
    for number, one in enumerate(found, start=1):
        table.writerow([_cell(getattr(one, column)) for column in COLUMNS])
        await _let_others(number)
    headers = {
        "Content-Disposition": "attachment; filename=history.csv",
        "Cache-Control": "no-store",
    }
    return Response(written.getvalue().encode(), media_type=CSV, headers=headers)


def _cell(value: str | None) -> str:
    text = value or ""
    return f"'{text}" if text.startswith(FORMULAS) else text


async def _found(
    api: ApiContext, caller: ApiCaller, robot: str, text: str, since_s: float, most: int
) -> list[HistoryEntryOut]:
    reader = api.kernel.shared.history.find()
    if reader is None or api.is_locked_out(caller):
        raise NotFound(NO_RECORD)
    named = api.profile(caller, robot).id if robot else ""
    whole = bool(named) and api.oversees(caller, named)
    query = HistoryQuery(
        principal="" if whole else caller.principal,
        robot=named,
        since_ns=max(0, api.kernel.clock.wall_ns() - int(since_s * SECOND_NS)),
        limit=SEARCHED_AT_MOST if text else most,
    )
    wanted = text.casefold()
    shown = list[HistoryEntryOut]()
    for number, line in enumerate(await reader.read(query), start=1):
        one = _shown(api, caller, line)
        if not wanted or wanted in _words(one):
            shown.append(one)
        await _let_others(number)
    return shown


async def _let_others(number: int) -> None:
    """Let others have their turn after each few lines: of thousands, a stop would wait for all."""
    if number % STEP == 0:
        await asyncio.sleep(0)


def _shown(api: ApiContext, caller: ApiCaller, line: HistoryLine) -> HistoryEntryOut:
    one, catalogue = line.entry, api.languages.of(caller.principal)
    return HistoryEntryOut(
        at=moment(one.at_ns),
        who=api.kernel.rooms.authoriser.directory.name(one.principal),
        kind=one.kind,
        robot=one.robot,
        skill=one.skill,
        outcome=one.outcome,
        ended=moment(one.ended_ns) if one.ended_ns else None,
        asked=plain(in_language(line.asked, catalogue)),
        came=plain(in_language(line.came, catalogue)),
    )


def _words(one: HistoryEntryOut) -> str:
    return " ".join((one.who, one.robot, one.skill, one.asked, one.outcome, one.came)).casefold()


ROUTES: Final = (history, export)
