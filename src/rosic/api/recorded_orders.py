"""Orders that the feed has not, or not any more, as the record knows them: also of earlier runs."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.api.problems import problem
from rosic.api.schemas import OrderOut, Problem, moment
from rosic.core.history import REFUSED, HistoryQuery
from rosic.core.i18n import in_language
from rosic.core.identity import COMMAND_ID_BYTES
from rosic.core.order import OrderStage
from rosic.errors import RecordUnavailable

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.gateway.observed_state import HistoryLine

ORDERED: Final = "claimed"


async def recorded_order(context: ApiContext, caller: ApiCaller, order: str) -> OrderOut | None:
    """Return an order by its id.

    None: the record has none that they may see, or cannot be read now.
    """
    found = await recorded_answer(context, caller, order)
    return None if isinstance(found, Problem) else found


async def recorded_answer(
    context: ApiContext, caller: ApiCaller, order: str
) -> OrderOut | Problem | None:
    """Return what became of an order by its id, or why it was refused to its author.

    None: the record has neither that they may see, or cannot be read now.
    """
    try:
        cid = bytes.fromhex(order)
    except ValueError:
        return None
    reader = context.kernel.shared.history.find()
    if reader is None or len(cid) != COMMAND_ID_BYTES:
        return None
    try:
        found = await reader.read(HistoryQuery(cid=cid, limit=1))
    except RecordUnavailable:
        return None
    for line in found:
        entry = line.entry
        if entry.kind == ORDERED and entry.robot in context.visible(caller):
            return _shown(context, caller, line, order)
        if entry.kind == REFUSED and entry.principal == caller.principal:
            return problem(entry.outcome, line.came)
    return None


def _shown(context: ApiContext, caller: ApiCaller, line: HistoryLine, order: str) -> OrderOut:
    entry = line.entry
    read = partial(in_language, catalogue=context.languages.of(caller.principal))
    own = entry.principal == caller.principal
    whole = own or context.oversees(caller, entry.robot)
    return OrderOut(
        id=order,
        robot=entry.robot,
        skill=entry.skill,
        state=entry.outcome or OrderStage.ACCEPTED.value,
        over=bool(entry.outcome),
        who=context.kernel.rooms.authoriser.directory.name(entry.principal),
        n=entry.n,
        sent=read(line.asked) if whole else "",
        note=read(line.came) if whole else "",
        ended=moment(entry.ended_ns) if entry.ended_ns else None,
    )
