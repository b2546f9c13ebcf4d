"""What whoever writes down or shows what is seen of robots owes to ROSIC."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.core.robot.observation import Observation, RecordedRobot
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.view import ViewKind


class ChannelDescription(NamedTuple):
    """One row of messages of one kind.

    Attributes:
        topic: ``/omni/pose``.
        schema: Name of what its messages look like: ``foxglove.PoseInFrame``.
        definition: That, as JSON Schema.
        about: What else whoever reads it may want to know: the unit of a value.
    """

    topic: str
    schema: str
    definition: str
    about: tuple[tuple[str, str], ...] = ()


class EncodedMessage(NamedTuple):
    """One message, ready to be written or sent.

    Attributes:
        channel: Of which row; the very object each time.
        at_ns: Wall clock.
        content: JSON.
    """

    channel: ChannelDescription
    at_ns: int
    content: bytes


Frame: TypeAlias = str | bytes
"""Of a WebSocket: text or binary."""


class ObservationSession(Protocol):
    """One connection that shows what is seen: frames in, frames out. One call at a time.

    Attributes:
        wanted: What robots are to show because somebody looks at it now.
    """

    @property
    def wanted(self) -> frozenset[tuple[RobotId, ViewKind]]:
        """Return it."""
        ...

    def begin(self) -> tuple[Frame, ...]:
        """Return what is said first."""
        ...

    def heard(self, frame: Frame) -> tuple[Frame, ...]:
        """Take in what the other end says, and return what is answered. Never raises."""
        ...

    def encode(self, seen: Iterable[Observation]) -> tuple[Frame, ...]:
        """Return what is said of what was seen, to whoever wants it."""
        ...

    def forget(self, robot: RobotId) -> tuple[Frame, ...]:
        """Say that a robot is not to be seen any more; nothing of it is said from now on."""
        ...


class RecordingEncoder(Protocol):
    """Makes one file of what was seen. It does no I/O; each call may be made on another thread.

    One call at a time. What was returned so far is readable by itself up to its last whole part,
    whatever becomes of the rest.
    """

    def encode(self, seen: Sequence[Observation]) -> bytes:
        """Return the next part of the file; empty if there is nothing to add."""
        ...

    def finish(self) -> bytes:
        """Return the last part: with it the file is whole."""
        ...


class Recorder(Protocol):
    """Begins files and connections.

    Attributes:
        subprotocols: Of the WebSocket by which a session is held, the best first.
    """

    subprotocols: tuple[str, ...]

    def begin(self, robots: Sequence[RecordedRobot], about: dict[str, str]) -> RecordingEncoder:
        """Return what makes a file of robots.

        Args:
            robots: Which ones.
            about: Stands in the file as it is: when it was begun, by whom.
        """
        ...

    def repair(self, content: bytes) -> bytes:
        """Return a whole file of one that was broken off: everything up to its last whole part.

        Empty, if nothing of it can be read.
        """
        ...

    def session(self, robots: Sequence[RecordedRobot], name: str) -> ObservationSession:
        """Return one connection by which robots are shown live, and changed by nothing.

        Args:
            robots: Which ones.
            name: Of this place.
        """
        ...
