"""What was asked for, for the operator: of everybody, a robot or a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.naming import the_one, utc
from rosic.core.history import REFUSED, STOPPED, HistoryQuery
from rosic.core.i18n import plain
from rosic.core.language import clean
from rosic.core.language.sanitise import quote
from rosic.errors import NotUnderstood
from rosic.features.personal_data.order_history import (
    NOTHING_YET,
    ReadEntry,
    at_once,
    read_entry,
    stopped,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rosic.app.admin.api import AdminContext
    from rosic.core.history import HistoryEntry
    from rosic.core.robot.profile import RobotId

AT_MOST = 10_000
LINES_AT_ONCE = 200
NO_RECORD = "This record cannot be looked into."

_encode = msgspec.json.Encoder(enc_hook=plain).encode


class HistoryParameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Whose history, and how much of it.

    Attributes:
        since_s: Not older than so many seconds; None: the newest ones, however old.
        json: For programs, the newest last, as lists.
    """

    robot: str = ""
    person: str = ""
    since_s: float | None = None
    limit: int = 100
    json: bool = False


async def history_of(books: AdminContext, asked: HistoryParameters) -> Iterator[str]:
    """Return what was asked for, the newest last, many commands at a time.

    Raises:
        NotUnderstood: There is no such robot or person.
        StoreFault: It cannot be read now.
    """
    if books.data_context is None:
        raise NotUnderstood(NO_RECORD)
    robot = books.vocabulary.robot(asked.robot) if asked.robot else None
    if asked.robot and robot is None:
        known = ", ".join(books.profiles)
        raise NotUnderstood(f"There is no robot called {clean(asked.robot)}. There are: {known}.")
    person = the_one(books.authoriser.directory, asked.person).id if asked.person else ""
    now_ns = books.clock.wall_ns()
    query = HistoryQuery(
        principal=person,
        robot="" if robot is None else robot.id,
        since_ns=0 if asked.since_s is None else now_ns - int(asked.since_s * 1e9),
        limit=max(1, min(asked.limit, AT_MOST)),
    )
    found = await books.data_context.container_store.history(query)
    if not found and not asked.json:
        return iter((_nothing(books, asked, query),))
    return _written(books, found[::-1], json=asked.json)


def _nothing(books: AdminContext, asked: HistoryParameters, query: HistoryQuery) -> str:
    """Say in one sentence what there is nothing of."""
    if not (query.robot or query.principal or query.since_ns):
        return str(NOTHING_YET)
    what = f" of {books.profiles[query.robot].shown}" if query.robot else ""
    who = f" by {books.name(query.principal)}" if query.principal else ""
    since = "" if asked.since_s is None else f" since {books.moment(query.since_ns)}"
    return f"Nothing was asked{what}{who or ''}{since}."


def _written(books: AdminContext, found: tuple[HistoryEntry, ...], *, json: bool) -> Iterator[str]:
    for at in range(0, max(1, len(found)), LINES_AT_ONCE):
        some = found[at : at + LINES_AT_ONCE]
        if json:
            read = [read_entry(entry, books.vocabulary) for entry in some]
            yield _encode([_listed(books, one) for one in read]).decode()
        else:
            yield "\n".join(_line(books, entry, robots) for entry, robots in at_once(some))


def _line(books: AdminContext, entry: HistoryEntry, robots: Sequence[RobotId]) -> str:
    read = read_entry(entry, books.vocabulary)
    asked = stopped(robots, books.vocabulary) if entry.kind == STOPPED else read.asked
    if entry.kind == REFUSED and asked:
        asked = quote(asked)
    parts = (books.moment(read.at_ns), books.name(read.who), asked, read.came)
    return "  ".join(filter(None, map(str, parts)))


def _listed(books: AdminContext, read: ReadEntry) -> dict[str, object]:
    return {
        "at": utc(read.at_ns),
        "person": read.who,
        "name": books.name(read.who),
        "robot": read.robot or None,
        "skill": read.skill or None,
        "asked": read.asked or None,
        "outcome": read.outcome or None,
        "told": read.came,
        "ended": utc(read.ended_ns),
    }
