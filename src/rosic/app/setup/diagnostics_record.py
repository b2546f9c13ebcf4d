"""The data folder: whether its record is the one that was last used, and all files are there."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rosic.app.admin.asked import Ask, Verb
from rosic.app.admin.control_client import NotRunning, ask_gateway
from rosic.app.record_monitor import lost
from rosic.app.setup.findings import DiagnosticFinding, FindingVerdict
from rosic.errors import RosicError
from rosic.stores.record_mark import RecordMark, was_begun

if TYPE_CHECKING:
    from pathlib import Path

log = logging.getLogger("rosic.doctor")

ABOUT = "data"
_LOST = str(lost(""))


async def examine_record(data: Path) -> DiagnosticFinding:
    """Ask the gateway that runs on a data folder, or look at the folder."""
    try:
        asked = ask_gateway(data, Ask(Verb.STATUS), log.warning)
        said = [answer.text async for answer in asked]
    except NotRunning:
        return _of_nobody(data)
    except RosicError as silent:
        return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, str(silent))
    else:
        found = next((line for text in said for line in text.splitlines() if _LOST in line), "")
        if found:
            return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, found)
        return DiagnosticFinding(
            ABOUT, FindingVerdict.GOOD, "in use by a gateway, and all of its files are there"
        )


def _of_nobody(data: Path) -> DiagnosticFinding:
    if not was_begun(data):
        return DiagnosticFinding(ABOUT, FindingVerdict.GOOD, "none yet: the first start makes it")
    try:
        RecordMark(data, begin_anew=False).look()
    except (RosicError, OSError) as wrong:
        return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, str(wrong))
    return DiagnosticFinding(ABOUT, FindingVerdict.GOOD, "there, beside what goes with it")
