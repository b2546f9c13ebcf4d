"""Topics: sending, the newest value, and every word."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.errors import BadValue, NotSent
from rosic.robots.ros2.messages.encode import to_message, type_of
from rosic.robots.ros2.publishers import TopicPublishers, ends_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.rclpy_import import RclpyModules, RosObject
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.publishers import About, Ends

HEADER = "std_msgs/Header"
CLOSED = "The link to ROS 2 is closed; nothing was sent."

ON_ITS_WAY_S = 0.25
"""A message is kept by its publisher until every subscriber has it. Acknowledgements would tell,
but come only with the next heartbeat, every 3 s."""


EARLIER_AT_MOST = 5
EARLIER_EVERY_NS = 100_000_000
STAMP = slice(4, 12)
"""Where seconds and nanoseconds stand in a message that begins with a header: behind the four bytes
that say how it is encoded."""


@dataclass(frozen=True)
class TopicQos:
    """Quality of service, as far as a profile has to know it.

    A publisher and a subscriber meet only when the one offers what the other asks for: a reliable
    subscriber hears no best-effort publisher, a latched one hears only latched publishers.

    Attributes:
        reliable: What gets lost is sent again.
        latched: The last messages are kept for whoever comes later (transient local).
        depth: How many messages are kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 10

    def profile(self, ros: RclpyModules) -> RosObject:
        """Return it in the words of rclpy."""
        qos = ros.qos
        reliability, durability = qos.ReliabilityPolicy, qos.DurabilityPolicy
        return qos.QoSProfile(
            history=qos.HistoryPolicy.KEEP_LAST,
            depth=max(1, self.depth),
            reliability=reliability.RELIABLE if self.reliable else reliability.BEST_EFFORT,
            durability=durability.TRANSIENT_LOCAL if self.latched else durability.VOLATILE,
        )


class Publisher:
    """Sends to one topic.

    Attributes:
        topic: Absolute name.
    """

    def __init__(
        self, runtime: RosConnection, topic: str, cls: RosObject, handle: RosObject
    ) -> None:
        self.topic = topic
        self._runtime = runtime
        self._cls = cls
        self._handle = handle
        self._stamped = cls.get_fields_and_field_types().get("header") == HEADER
        self._sent_s = -ON_ITS_WAY_S

    @property
    def listeners(self) -> int:
        """How many subscribers are matched now. A topic says no more about who received it."""
        return int(self._handle.get_subscription_count()) if self._runtime.alive else 0

    def takers(self) -> Ends:
        """Return who takes what is sent: one that begins anew is another."""
        if not self._runtime.alive:
            return {}
        return ends_of(self._runtime.thread.node.get_subscriptions_info_by_topic(self.topic))

    def publish(self, values: Values) -> None:
        """Check, convert and send, at once and on the calling thread.

        Raises:
            BadValue: A value does not fit; nothing was sent.
            NotSent: The link is closed, or ROS did not take it (its queue is full).
        """
        self.send(to_message(self._cls, values))

    def made(self, values: Values) -> RosObject | bytes:
        """Check, convert and serialise, so that nothing is left to do when it is sent.

        What carries a stamp gets that when it is sent, and is serialised then.

        Raises:
            BadValue: A value does not fit.
        """
        message = to_message(self._cls, values)
        if self._stamped:
            return message
        return bytes(self._runtime.ros.serialization.serialize_message(message))

    def packed(self, message: RosObject) -> bytes:
        """Serialise a message; a header without a time is given that of now.

        Raises:
            NotSent: The link is closed.
        """
        if not self._runtime.alive:
            raise NotSent(CLOSED)
        if self._stamped and not (message.header.stamp.sec or message.header.stamp.nanosec):
            message.header.stamp = self._runtime.thread.node.get_clock().now().to_msg()
        return bytes(self._runtime.ros.serialization.serialize_message(message))

    def send(self, message: RosObject | bytes) -> None:
        """Send a message, or what was made of it, at once and on the calling thread.

        A message with a header is stamped with the time of now: robots refuse what is old.

        Raises:
            NotSent: As `publish` does.
        """
        if not self._runtime.alive:
            raise NotSent(CLOSED)
        try:
            if self._stamped and not isinstance(message, bytes):
                message.header.stamp = self._runtime.thread.node.get_clock().now().to_msg()
            self._handle.publish(message)
            self._sent_s = monotonic()
            self._runtime.traffic.went(len(message) if isinstance(message, bytes) else 0)
        except Exception as error:  # RCLError under a flood; it has no stable home in rclpy
            raise NotSent(f"ROS 2 did not take the message for {self.topic}.") from error

    async def close(self) -> None:
        """Leave the topic, but not at once after sending: what is on its way is lost with us."""
        rest_s = self._sent_s + ON_ITS_WAY_S - monotonic()
        if rest_s > 0 and self._runtime.alive:
            await asyncio.sleep(rest_s)
        await self._runtime.discard(lambda node: node.destroy_publisher(self._handle))


class Subscription:
    """What `LatestMessage` and `MessageStream` share: messages stay bytes until they are looked at.

    Turning bytes into a Python message is most of the cost of a topic, and under the interpreter
    lock the event loop pays for it. Robots send hundreds of messages a second; people read a few.
    """

    def __init__(self, runtime: RosConnection, topic: str, cls: RosObject) -> None:
        self.topic = topic
        self.handle: RosObject = None
        self.cls = cls
        self._runtime = runtime
        self._offered = False

    @property
    def publishers(self) -> int:
        """How many publishers are matched now: whether anybody would be heard."""
        if self.handle is None or not self._runtime.alive:
            return 0
        return int(self.handle.get_publisher_count())

    async def close(self) -> None:
        """Leave the topic."""
        await self._runtime.discard(lambda node: node.destroy_subscription(self.handle))

    def _knock(self) -> None:
        """Ask to be called on the loop, unless that is already under way; on the ROS thread."""
        if not self._offered:
            self._offered = True
            if not self._runtime.thread.hand_over(self._answered):
                self._offered = False

    def _answered(self) -> None:
        self._offered = False
        self._deliver()

    def _deliver(self) -> None:
        raise NotImplementedError

    def _decode(self, content: bytes) -> RosObject:
        try:
            return self._runtime.ros.serialization.deserialize_message(content, self.cls)
        except Exception as error:
            raise BadValue(
                f"{self.topic} holds something that is no {type_of(self.cls)}."
            ) from error


class ReceivedMessage(NamedTuple):
    """A message, when it came, and when it was sent, both on the runtime's clock."""

    received_ns: int
    sent_ns: int
    content: bytes


class LatestMessage(Subscription):
    """The newest message of a topic, and a few from a moment before.

    One that bears the time of the one before it (``header.stamp``) is no new one, however often a
    relay repeats it: it was sent when that was.

    What a publisher had kept for whoever comes later is read like any other, but nobody was heard
    by that: it does not count in ``received``, and has no part in `age_s` and the like.

    Attributes:
        received: How many have come so far.
        senders: Who has sent them.
    """

    def __init__(
        self,
        runtime: RosConnection,
        topic: str,
        cls: RosObject,
        on_new: Callable[[LatestMessage], None] | None,
    ) -> None:
        super().__init__(runtime, topic, cls)
        self.received = 0
        self.senders = TopicPublishers()
        self._on_new = on_new
        self._stamped = _is_stamped(cls)
        self._earlier: deque[ReceivedMessage] = deque(maxlen=EARLIER_AT_MOST)
        self._newest: ReceivedMessage | None = None
        self._kept: ReceivedMessage | None = None
        self._kept_handle: RosObject = None
        self._decoded: tuple[bytes, RosObject] | None = None
        self._waiting: set[asyncio.Future[None]] = set()

    @property
    def age_s(self) -> float | None:
        """Seconds since the newest message came here; None when none ever has."""
        newest = self._newest
        return None if newest is None else (self._runtime.now_ns() - newest.received_ns) / SECOND_NS

    @property
    def received_ns(self) -> int | None:
        """When the newest message came here, on the runtime's clock; None when none ever has."""
        newest = self._newest
        return None if newest is None else newest.received_ns

    @property
    def sent_ns(self) -> int | None:
        """When the newest message was sent, on the runtime's clock; None when none has come."""
        newest = self._newest
        return None if newest is None else newest.sent_ns

    @property
    def told_age_s(self) -> float | None:
        """Seconds since `message` came here, or was said if it was kept; None without one."""
        told_ns = self.told_ns
        return None if told_ns is None else (self._runtime.now_ns() - told_ns) / SECOND_NS

    @property
    def told_ns(self) -> int | None:
        """When that was, on the runtime's clock; it may be before this clock began."""
        kept = self._kept
        return self.received_ns if kept is None else kept.sent_ns

    @property
    def size_bytes(self) -> int:
        """How large the newest message is, before anybody decodes it; 0 without one."""
        newest = self._kept or self._newest
        return 0 if newest is None else len(newest.content)

    def message(self) -> RosObject | None:
        """Return the newest message; None when none has come. Decoded once, when first asked for.

        Raises:
            BadValue: What came cannot be decoded.
        """
        newest = self._kept or self._newest
        if newest is None:
            return None
        content = newest.content
        if self._decoded is None or self._decoded[0] is not content:
            self._decoded = (content, self._decode(content))
        return self._decoded[1]

    def earlier(self) -> tuple[ReceivedMessage, ...]:
        """Return some of the messages before the newest, the last of them last."""
        return tuple(self._earlier)

    def decoded(self, heard: ReceivedMessage) -> RosObject:
        """Return one of them.

        Raises:
            BadValue: It cannot be decoded.
        """
        return self._decode(heard.content)

    async def newer(self, than: int, *, timeout_s: float) -> int:
        """Wait until more than ``than`` messages have come, and return how many have.

        Raises:
            TimeoutError: They have not.
        """
        async with asyncio.timeout(timeout_s):
            while self.received <= than:
                waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
                self._waiting.add(waiting)
                try:
                    await waiting
                finally:
                    self._waiting.discard(waiting)
        return self.received

    def arrived(self, content: bytes, about: About) -> None:
        """Take a message; on the ROS thread."""
        now_ns, before = self._runtime.now_ns(), self._newest
        sent_ns = self.senders.take(about, now_ns)
        if before is not None:
            if self._stamped and _repeats(content, before.content):
                sent_ns = before.sent_ns
            last = self._earlier[-1].received_ns if self._earlier else 0
            if before.received_ns - last >= EARLIER_EVERY_NS:
                self._earlier.append(before)
        self._newest, self._kept = ReceivedMessage(now_ns, sent_ns, content), None
        self.received += 1
        self._runtime.traffic.came(len(content))
        self._knock()

    def arrived_kept(self, content: bytes, about: About) -> None:
        """Take a message that was kept, unless it, or a newer one, is known; on the ROS thread.

        What is said from now on comes here, too, and again as any other: then that counts.
        """
        now_ns, before = self._runtime.now_ns(), self._kept or self._newest
        past_ns = self.senders.take_kept(about, self._runtime.wall_ns())
        if past_ns is not None and (before is None or before.sent_ns < now_ns - past_ns):
            self._kept = ReceivedMessage(now_ns, now_ns - past_ns, content)
            self._knock()

    async def hear_kept(self, subscribe: Callable[[], Awaitable[RosObject]]) -> None:
        """Open the subscription to what is kept, once."""
        if self._kept_handle is None:
            self._kept_handle = await subscribe()

    async def close(self) -> None:
        """Leave the topic."""
        kept, self._kept_handle = self._kept_handle, None
        if kept is not None:
            await self._runtime.discard(lambda node: node.destroy_subscription(kept))
        await super().close()

    def _deliver(self) -> None:
        for waiting in self._waiting:
            if not waiting.done():
                waiting.set_result(None)
        if self._on_new is not None:
            self._on_new(self)


def _is_stamped(cls: RosObject) -> bool:
    """Tell whether messages of a type begin with a ``std_msgs/msg/Header``."""
    first = next(iter(cls.get_fields_and_field_types().values()), "")
    return bool(first == "std_msgs/Header")


def _repeats(content: bytes, before: bytes) -> bool:
    """Tell whether a message bears the time of another; one without any time does not."""
    stamp = bytes(content[STAMP])
    return any(stamp) and stamp == bytes(before[STAMP])


class MessageStream(Subscription):
    """Every message of a topic, in order, up to a number that may wait.

    Attributes:
        dropped: How many were lost because the loop did not come to them.
    """

    def __init__(
        self,
        runtime: RosConnection,
        topic: str,
        cls: RosObject,
        on_message: Callable[[RosObject], None],
        depth: int,
    ) -> None:
        super().__init__(runtime, topic, cls)
        self.dropped = 0
        self._on_message = on_message
        self._waiting: deque[bytes] = deque(maxlen=max(1, depth))

    def arrived(self, content: bytes) -> None:
        """Take a message; on the ROS thread."""
        if len(self._waiting) == self._waiting.maxlen:
            self.dropped += 1
        self._runtime.traffic.came(len(content))
        self._waiting.append(content)
        self._knock()

    def _deliver(self) -> None:
        for _ in range(len(self._waiting)):
            try:
                message = self._decode(self._waiting.popleft())
            except BadValue:
                self.dropped += 1
                continue
            self._on_message(message)


# ---- rate limited topic ----

# A topic on which anybody may say anything at any rate: the newest are taken, at a pace.

WAITING_AT_MOST: Final = 16
PAUSE_S: Final = 0.05
# Before the text of a std_msgs/String on the wire: how it is encoded, and how long it is.
HEAD_BYTES: Final = 8


class RateLimitedTopic(Subscription):
    """Texts of one topic, taken in turns with a pause between them.

    The first of a calm topic is taken at once. Of a flood, what is turned into Python is bounded;
    what is too old by then is dropped and counted, and what is too long never becomes a text.

    Args:
        runtime, topic, cls: As `Subscription` has them; of type ``std_msgs/msg/String``.
        on_words: Takes UTF-8 on the event loop, and how many were dropped before it.
        at_most: So many bytes and one more are handed on of a longer text.
    """

    def __init__(
        self,
        runtime: RosConnection,
        topic: str,
        cls: RosObject,
        on_words: Callable[[bytes, int], None],
        at_most: int,
    ) -> None:
        super().__init__(runtime, topic, cls)
        self.dropped = 0
        self._on_words = on_words
        self._at_most = at_most
        self._reported = 0
        self._waiting: deque[tuple[bool, bytes]] = deque(maxlen=WAITING_AT_MOST)

    def arrived(self, content: bytes) -> None:
        """Take a message; on the ROS thread."""
        if len(self._waiting) == WAITING_AT_MOST:
            self.dropped += 1
        self._runtime.traffic.came(len(content))
        whole = len(content) <= HEAD_BYTES + self._at_most + 1
        kept = content if whole else bytes(content[HEAD_BYTES : HEAD_BYTES + self._at_most + 1])
        self._waiting.append((whole, kept))
        self._knock()

    def _answered(self) -> None:
        """Take a turn; the next knock is heard after a pause."""
        self._deliver()
        asyncio.get_running_loop().call_later(PAUSE_S, self._after_pause)

    def _after_pause(self) -> None:
        self._offered = False
        if self._waiting and self._runtime.alive:
            self._offered = True
            self._answered()

    def _deliver(self) -> None:
        for _ in range(len(self._waiting)):
            whole, content = self._waiting.popleft()
            dropped, self._reported = self.dropped - self._reported, self.dropped
            words = content
            if whole:
                try:
                    words = self._decode(content).data.encode(errors="replace")
                except BadValue:
                    words = b""
            self._on_words(words, dropped)
