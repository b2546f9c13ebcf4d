"""The data folder: whether its record is the one that was last used, and all files are there."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rosic.app.desk.asked import Ask, Verb
from rosic.app.desk.control_client import NotRunning, ask_gateway
from rosic.app.doctor.findings import Finding, Verdict
from rosic.app.placing.record_watch import lost
from rosic.errors import RosicError
from rosic.stores.record_mark import RecordMark, was_begun

if TYPE_CHECKING:
    from pathlib import Path

log = logging.getLogger("rosic.doctor")

ABOUT = "data"
_LOST = str(lost(""))


async def examine_record(data: Path) -> Finding:
    """Ask the gateway that runs on a data folder, or look at the folder."""
    try:
        asked = ask_gateway(data, Ask(Verb.STATUS), log.warning)
        said = [answer.text async for answer in asked]
    except NotRunning:
        return _of_nobody(data)
    except RosicError as silent:
        return Finding(ABOUT, Verdict.LOOK, str(silent))
    else:
        found = next((line for text in said for line in text.splitlines() if _LOST in line), "")
        if found:
            return Finding(ABOUT, Verdict.LOOK, found)
        return Finding(ABOUT, Verdict.GOOD, "in use by a gateway, and all of its files are there")


def _of_nobody(data: Path) -> Finding:
    if not was_begun(data):
        return Finding(ABOUT, Verdict.GOOD, "none yet: the first start makes it")
    try:
        RecordMark(data, begin_anew=False).look()
    except (RosicError, OSError) as wrong:
        return Finding(ABOUT, Verdict.LOOK, str(wrong))
    return Finding(ABOUT, Verdict.GOOD, "there, beside what goes with it")
