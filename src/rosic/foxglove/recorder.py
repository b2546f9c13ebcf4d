"""Who makes recordings here, if anybody can: nothing of mcap is loaded before the first one."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from rosic.foxglove.session import SUBPROTOCOLS, FoxgloveSession

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.recording import Recorder, RecordingEncoder
    from rosic.core.robot.observation import RecordedRobot


class McapRecorder:
    """Begins MCAP files and connections; see ``contracts.recording.Recorder``."""

    subprotocols: tuple[str, ...] = SUBPROTOCOLS

    def begin(self, robots: Sequence[RecordedRobot], about: dict[str, str]) -> RecordingEncoder:
        """Return what makes a file."""
        made: RecordingEncoder = _mcap_file().McapEncoder(robots, about)
        return made

    def repair(self, content: bytes) -> bytes:
        """Return a whole file of one that was broken off; empty, if nothing of it can be read."""
        return bytes(_mcap_file().repair(content))

    def session(self, robots: Sequence[RecordedRobot], name: str) -> FoxgloveSession:
        """Return one connection by which robots are shown live."""
        return FoxgloveSession(robots, name)


def recorder() -> Recorder | None:
    """Return who makes recordings; None where the library mcap is not installed."""
    return None if find_spec("mcap") is None else McapRecorder()


def _mcap_file() -> Any:  # noqa: ANN401 - a module
    return import_module("rosic.foxglove.mcap_file")
