"""`python -m tests.tracing FILE ARGUMENT...`: the command `rosic`, followed function by function.

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
    """Notes which functions are entered.

    Attributes:
        entered: Their names, as module and function, in order; and whether they began, or went on.
    """

    def __init__(self) -> None:
        self.entered: list[tuple[tuple[str, str], bool]] = []
        self._known: dict[CodeType, tuple[tuple[str, str], int] | None] = {}

    def __call__(self, frame: FrameType, event: str, _argument: Any) -> None:  # noqa: ANN401
        """Take what the interpreter tells; see ``sys.setprofile``."""
        if event != "call":
            return
        code = frame.f_code
        try:
            known = self._known[code]
        except KeyError:
            known = self._known[code] = _named(frame)
        if known is not None:
            self.entered.append((known[0], frame.f_lasti == known[1]))

    @property
    def begun(self) -> list[str]:
        """The names of those that began, module and all."""
        return [".".join(name) for name, began in self.entered if began]

    def start(self) -> None:
        """Follow this thread, and every one that it starts."""
        threading.setprofile(self)
        sys.setprofile(self)

    @staticmethod
    def stop() -> None:
        """Follow nothing that begins from now on."""
        threading.setprofile(None)
        sys.setprofile(None)


def _named(frame: FrameType) -> tuple[tuple[str, str], int] | None:
    """Return the name of a function of ROSIC, and where in its code it begins; else None."""
    module = str(frame.f_globals.get("__name__", ""))
    if module.partition(".")[0] not in PACKAGES:
        return None
    begins = (i.offset for i in dis.get_instructions(frame.f_code) if i.opname == "RESUME")
    return (module, frame.f_code.co_qualname), next(begins, -1)


def main(arguments: list[str]) -> int:
    """Run the command and write what was noted; return its exit status."""
    file, *command = arguments
    from rosic.cli.main import main as rosic  # noqa: PLC0415 - what importing calls is not followed

    tracer = Tracer()
    tracer.start()
    try:
        return rosic(command)
    finally:
        tracer.stop()
        Path(file).write_text("\n".join(tracer.begun), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
