"""What others on this machine could read or change."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rosic.app.doctor.findings import Finding, Verdict
from rosic.app.documents.open_to_others import open_to_others
from rosic.app.private_memory import keep_memory_private

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.app.config import Config


def examine_memory() -> Finding:
    """Do here what a start does, and read it back: tokens and keys are in its memory."""
    if keep_memory_private():
        return Finding("memory", Verdict.GOOD, "a gateway leaves no core dump, and no debugger in")
    if sys.platform != "linux":
        text = "core dumps can be kept out on Linux alone; they would hold tokens and keys"
        return Finding("memory", Verdict.NOT_MEASURED, text)
    return Finding("memory", Verdict.LOOK, "core dumps are not kept out; they hold tokens and keys")


def examine_openness(config: Config) -> Iterator[Finding]:
    """Look who may write the configuration, the profiles and the data."""
    found = tuple(open_to_others((*config.files, config.data)))
    for one in found:
        yield Finding("files", Verdict.LOOK, str(one.error))
    if not found:
        yield Finding("files", Verdict.GOOD, "nobody else may write what it is started with")
