"""What others on this machine could read or change."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rosic.app.private_memory import keep_memory_private
from rosic.app.setup.findings import DiagnosticFinding, FindingVerdict
from rosic.config.file_permissions import open_to_others

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.app.config import Config


def examine_memory() -> DiagnosticFinding:
    """Do here what a start does, and read it back: tokens and keys are in its memory."""
    if keep_memory_private():
        return DiagnosticFinding(
            "memory", FindingVerdict.GOOD, "a gateway leaves no core dump, and no debugger in"
        )
    if sys.platform != "linux":
        text = "core dumps can be kept out on Linux alone; they would hold tokens and keys"
        return DiagnosticFinding("memory", FindingVerdict.NOT_MEASURED, text)
    return DiagnosticFinding(
        "memory", FindingVerdict.LOOK, "core dumps are not kept out; they hold tokens and keys"
    )


def examine_openness(config: Config) -> Iterator[DiagnosticFinding]:
    """Look who may write the configuration, the profiles and the data."""
    found = tuple(open_to_others((*config.files, config.data)))
    for one in found:
        yield DiagnosticFinding("files", FindingVerdict.LOOK, str(one.error))
    if not found:
        yield DiagnosticFinding(
            "files", FindingVerdict.GOOD, "nobody else may write what it is started with"
        )
