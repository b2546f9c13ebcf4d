"""What whoever writes down what is seen of robots owes to ROSIC."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.core.robot.observation import Observation, RecordedRobot


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


class ObservationEncoder(Protocol):
    """Makes messages of what was seen, for one reader; it says a thing once until it changes."""

    def messages(self, seen: Iterable[Observation]) -> Iterator[EncodedMessage]:
        """Yield what is said of it, in order. Total: what cannot be said is left out."""
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
    """Begins files."""

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

    def encoder(self, robots: Sequence[RecordedRobot]) -> ObservationEncoder:
        """Return what makes messages of robots without a file, to be sent as they are."""
        ...
