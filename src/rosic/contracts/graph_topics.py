"""Topics of the graph that a robot is on, for protocols that hand them on to programs and pages.

What is opened here moves nothing by itself: who may read or say what is decided before, and what a
profile binds to motion is sent by orders alone. What the robot's side answers to those is handed
on as it came, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any, TypeAlias

    Fields: TypeAlias = Mapping[str, Any]
    """A message by its fields, nested: numbers, text, yes or no, lists. Bytes are ``bytes``, and
    where they come in they may be base64 text; a list of numbers may be an ``array.array``."""
    OnMessage: TypeAlias = Callable[["TopicMessage"], None]


class TopicMessage(Protocol):
    """One message that has come, not looked at yet: to look costs most of what a message costs.

    Attributes:
        size: In bytes, as it came.
    """

    @property
    def size(self) -> int:
        """See above."""
        ...

    @property
    def fields(self) -> Fields:
        """Return its fields.

        Raises:
            Fault: What came is of another type.
        """
        ...


class OpenedTopic(Protocol):
    """A topic that is listened to."""

    @property
    def lost(self) -> int:
        """Return how many messages were dropped, because nobody came to take them in time."""
        ...

    async def close(self) -> None:
        """Listen no more."""
        ...


class OpenedPublisher(Protocol):
    """A topic that is published to."""

    async def packed(self, fields: Fields) -> bytes:
        """Check every field, and return what is sent; what is left out is the type's own default.

        A header without a time is given that of now. This may wait for the link, so whether
        somebody may publish is asked after it. Nothing was sent.

        Raises:
            Fault: It cannot be sent, and why.
        """
        ...

    def send(self, content: bytes) -> None:
        """Send what was packed, at once.

        How much is kept for subscribers that take nothing is bounded in bytes; the newest counts.

        Raises:
            Fault: Nothing was sent, and why.
        """
        ...

    async def close(self) -> None:
        """Leave the topic."""
        ...


class GraphTopics(Protocol):
    """The topics of the graph that a robot is on."""

    @property
    def reported(self) -> Mapping[str, str]:
        """Return the topics that the robot's profile binds, by absolute name, and their types."""
        ...

    @property
    def stop_service(self) -> str:
        """Return the absolute name of the service that stops the robot; empty: it has none."""
        ...

    @property
    def stop_service_type(self) -> str:
        """Return the type of that service; it says nothing where there is none."""
        ...

    @property
    def releases_by(self) -> Mapping[str, object]:
        """Return the fields by which that service lets the robot go on; empty: it never does."""
        ...

    def feedback(self, n: int) -> Fields | None:
        """Return the newest feedback of the robot's side about an order, as it came.

        Args:
            n: The order's number; the newest orders alone are known.
        """
        ...

    def end(self, n: int) -> Fields | None:
        """Return the result or the response by which an order ended, as it came.

        None: its side has said nothing, as where nobody took it, or it is not one of the newest.
        """
        ...

    async def listen(self, topic: str, type_name: str, on_message: OnMessage) -> OpenedTopic:
        """Listen to a topic; every message is told, in order, as long as the loop keeps up.

        Where it does not, the newest is told, and nothing that has waited for long.

        Args:
            topic: Absolute.
            type_name: As the graph calls it.
            on_message: Called on the event loop.

        Raises:
            ConfigurationError: There is no such type, or that is no name.
            Fault: The link is closed, or too much is open.
        """
        ...

    async def publisher(self, topic: str, type_name: str) -> OpenedPublisher:
        """Open a publisher. Raises as `listen` does."""
        ...


@runtime_checkable
class GraphRobot(Protocol):
    """A robot link that is on a graph of topics.

    Attributes:
        topics: Of that graph.
    """

    topics: GraphTopics
