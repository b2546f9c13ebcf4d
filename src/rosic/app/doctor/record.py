"""The data folder: whether its record is the one that was last used, and all files are there."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.app.desk.control import Ask, NotRunning, Verb, ask_gateway
from rosic.app.doctor.findings import Finding, Verdict
from rosic.app.placing.record_watch import lost
from rosic.errors import RosicError
from rosic.stores.record_mark import RecordMark, was_begun

if TYPE_CHECKING:
    from pathlib import Path

ABOUT = "data"
_LOST = str(lost(""))


async def examine_record(data: Path) -> Finding:
    """Ask the gateway that runs on a data folder, or look at the folder."""
    with suppress(NotRunning, RosicError):
        said = [answer.text async for answer in ask_gateway(data, Ask(Verb.STATUS))]
        found = next((line for text in said for line in text.splitlines() if _LOST in line), "")
        if found:
            return Finding(ABOUT, Verdict.LOOK, found)
        return Finding(ABOUT, Verdict.GOOD, "in use by a gateway, and all of its files are there")
    if not was_begun(data):
        return Finding(ABOUT, Verdict.GOOD, "none yet: the first start makes it")
    try:
        RecordMark(data, begin_anew=False).look()
    except (RosicError, OSError) as wrong:
        return Finding(ABOUT, Verdict.LOOK, str(wrong))
    return Finding(ABOUT, Verdict.GOOD, "there, beside what goes with it")
