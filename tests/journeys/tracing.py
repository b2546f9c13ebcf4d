"""`python -m tests.journeys.tracing FILE ARGUMENT...`: the command `rosic`, followed by name.

Every function of ROSIC that begins is noted, in whatever thread, in the order in which they begin.
A coroutine begins once, when its first line runs; that it goes on is no beginning. The notes are
written to the file when the command has ended, one name a line.
"""

from __future__ import annotations

import dis
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from types import CodeType, FrameType

PACKAGES = ("rosic", "rosic_sim")


class Tracer:
    """Notes which functions begin.

    Attributes:
        begun: Their names, module and all, as they began.
    """

    def __init__(self) -> None:
        self.begun: list[str] = []
        self._known: dict[CodeType, tuple[str, int] | None] = {}

    def __call__(self, frame: FrameType, event: str, _argument: Any) -> None:  # noqa: ANN401
        """Take what the interpreter tells; see ``sys.setprofile``."""
        if event != "call":
            return
        code = frame.f_code
        try:
            known = self._known[code]
        except KeyError:
            known = self._known[code] = _named(frame)
        if known is not None and frame.f_lasti == known[1]:
            self.begun.append(known[0])

    def start(self) -> None:
        """Follow this thread, and every one that it starts."""
        threading.setprofile(self)
        sys.setprofile(self)


def _named(frame: FrameType) -> tuple[str, int] | None:
    """Return the name of a function of ROSIC, and where in its code it begins; else None."""
    module = str(frame.f_globals.get("__name__", ""))
    if module.partition(".")[0] not in PACKAGES:
        return None
    begins = (i.offset for i in dis.get_instructions(frame.f_code) if i.opname == "RESUME")
    return f"{module}.{frame.f_code.co_qualname}", next(begins, -1)


def main(arguments: list[str]) -> int:
    """Run the command and write what was noted; return its exit status."""
    file, *command = arguments
    from rosic.cli.main import main as rosic  # noqa: PLC0415 - what importing calls is not followed

    tracer = Tracer()
    tracer.start()
    try:
        return rosic(command)
    finally:
        sys.setprofile(None)
        Path(file).write_text("\n".join(tracer.begun), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
