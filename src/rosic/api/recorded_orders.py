"""Orders that the feed has not, or not any more, as the record knows them: also of earlier runs."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.api.schemas import OrderOut, moment
from rosic.core.history import HistoryQuery
from rosic.core.i18n import in_language
from rosic.core.identity import COMMAND_ID_BYTES
from rosic.core.order import OrderStage
from rosic.errors import RecordUnavailable

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext

ORDERED: Final = "claimed"


async def recorded_order(context: ApiContext, caller: ApiCaller, order: str) -> OrderOut | None:
    """Return an order by its id.

    None: the record has none that they may see, or cannot be read now.
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
        if entry.kind != ORDERED or entry.robot not in context.visible(caller):
            continue
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
    return None
