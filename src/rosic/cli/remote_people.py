"""People, rights and the past of a gateway elsewhere, as the commands of this machine show them."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from rosic.cli.remote import print_json
from rosic.core.i18n import joined, plain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.api.resource_schemas import HistoryEntryOut
    from rosic.client import RosicClient

NEWEST: Final = 50
AT_MOST: Final = 1_000
ALWAYS_S: Final = 3e8
GOOD: Final = "good"
LOOK: Final = "look"
MARKS: Final = {GOOD: "", LOOK: "look at this: "}


async def people(client: RosicClient, *, json: bool) -> int:
    """Print who is known there."""
    found = await client.people()
    if json:
        print_json(found)
    for one in () if json else found:
        parts = [one.name, *(["program"] if one.kind == "program" else []), ", ".join(one.roles)]
        parts += ["locked"] if one.locked else []
        print(plain(joined("  ", [part for part in (*parts, one.id) if part])))
    return 0


async def explain(client: RosicClient, person: str, line: str) -> int:
    """Print what would be decided. Return 1 if the answer is no."""
    found = await client.explain(person, line)
    print("\n\n".join(one.text for one in found))
    return 0 if all(one.allowed for one in found) else 1


async def history(client: RosicClient, robot: str, since_s: float | None, *, json: bool) -> int:
    """Print what was asked before, the newest last."""
    limit = NEWEST if since_s is None else AT_MOST
    found = await client.history(
        robot, since_s=ALWAYS_S if since_s is None else since_s, limit=limit
    )
    if json:
        print_json(found[::-1])
    for one in () if json else reversed(found):
        print(_history_line(one))
    return 0


def _history_line(one: HistoryEntryOut) -> str:
    what = one.asked or joined(": ", [part for part in (one.robot, one.skill or one.kind) if part])
    parts = (one.at, one.who, what, one.outcome, one.came)
    return plain(joined("  ", [part for part in parts if part]))


async def table(client: RosicClient, robot: str, since_s: float | None) -> int:
    """Write what was asked before as comma-separated values."""
    found = await client.history_table(robot, since_s=ALWAYS_S if since_s is None else since_s)
    sys.stdout.flush()
    sys.stdout.buffer.write(found)
    sys.stdout.buffer.flush()
    return 0


async def doctor(client: RosicClient) -> int:
    """Print what the doctor of the gateway finds. Return 1 if something should be looked at."""
    found = await client.health()
    for one in found:
        mark = MARKS.get(one.verdict, "not measured: ")
        print(plain(f"{one.about:<10} {mark}{one.text}"))
    return 1 if any(one.verdict == LOOK for one in found) else 0


def said_rights(
    roles: Sequence[str], robots: Sequence[str], limits: Sequence[str], lasts: str | None
) -> str:
    """Return rights as a line says them: ``operator on kuka1 speed <= 0.2 m/s for 2h``."""
    where = ["on", *robots] if robots else []
    span = ["for", lasts] if lasts is not None else []
    return " ".join([*roles, *where, *limits, *span])
