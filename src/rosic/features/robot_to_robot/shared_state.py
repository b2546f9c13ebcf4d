"""What robots share: the newest of each robot and topic, bounded, and kept over a restart."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.records import Fact, Letter
from rosic.core.robot.dialogue_protocol import ROBOT_BYTES, TOPICS_A_ROBOT, Shared
from rosic.errors import OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.robot.profile import RobotId

KIND: Final = "shared"

log = logging.getLogger("rosic.robot_to_robot")


class _Body(msgspec.Struct, frozen=True, array_like=True):
    at_ns: int
    until_ns: int
    id: str
    hops: int


_encode = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(_Body).decode


class SharedState:
    """Every robot's topics. What is too old counts as forgotten before it is.

    It is sealed in the container of the robot that shares it.
    """

    def __init__(self, wall_ns: Callable[[], int]) -> None:
        self._wall_ns = wall_ns
        self._shared: dict[RobotId, dict[str, Shared]] = {}
        self._unwritten: dict[tuple[RobotId, str], None] = {}

    def put(self, shared: Shared) -> None:
        """Let something be the newest.

        Raises:
            OutOfBounds: The robot has too many topics, or too much in them. Nothing has changed.
        """
        self.expire(shared.robot)
        topics = self._shared.setdefault(shared.robot, {})
        others = sum(len(s.data) for name, s in topics.items() if name != shared.topic)
        if shared.topic not in topics and len(topics) >= TOPICS_A_ROBOT:
            raise OutOfBounds(
                said(
                    "A robot shares on at most {most} topics. Nothing of it was kept.",
                    most=TOPICS_A_ROBOT,
                )
            )
        if others + len(shared.data) > ROBOT_BYTES:
            raise OutOfBounds(
                said(
                    "A robot shares at most {kib} KiB in all. Nothing of it was kept.",
                    kib=ROBOT_BYTES // 1024,
                )
            )
        topics[shared.topic] = shared
        self._unwritten[shared.robot, shared.topic] = None

    def get(self, robot: RobotId, topic: str = "") -> Shared | None:
        """Return the newest of a topic, or of all topics; None if there is nothing."""
        found = self.of(robot)
        if topic:
            return next((shared for shared in found if shared.topic == topic), None)
        return max(found, key=lambda shared: shared.at_ns, default=None)

    def of(self, robot: RobotId) -> tuple[Shared, ...]:
        """Return what a robot shares now, by topic."""
        now_ns = self._wall_ns()
        topics = self._shared.get(robot, {})
        return tuple(topics[name] for name in sorted(topics) if now_ns < topics[name].until_ns)

    def expire(self, robot: RobotId) -> None:
        """Forget what is too old."""
        topics, now_ns = self._shared.get(robot, {}), self._wall_ns()
        for name in [name for name, s in topics.items() if now_ns >= s.until_ns]:
            del topics[name]
            self._unwritten[robot, name] = None

    def forget(self, robot: RobotId) -> None:
        """Forget all that a robot shares: its container was erased."""
        for name in self._shared.pop(robot, {}):
            self._unwritten[robot, name] = None

    # ---- over a restart ----

    def due(self) -> list[Fact]:
        """Return what is to be written since the last time: of each topic only the newest."""
        for robot in self._shared:
            self.expire(robot)
        facts = [self._fact(robot, topic) for robot, topic in self._unwritten]
        self._unwritten.clear()
        return facts

    def _fact(self, robot: RobotId, topic: str) -> Fact:
        key, shared = f"{robot}/{topic}", self._shared.get(robot, {}).get(topic)
        if shared is None:
            return Fact(kind=KIND, key=key, body=b"")
        body = _Body(shared.at_ns, shared.until_ns, shared.id, shared.hops)
        letter = Letter(robot, shared.data)
        return Fact(kind=KIND, key=key, body=_encode(body), letter=letter)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote. What cannot be read, or was erased, is left out."""
        for fact in facts:
            if not fact.body or fact.letter is None:
                continue
            robot, _, topic = fact.key.partition("/")
            try:
                body = _read(fact.body)
            except msgspec.MsgspecError:
                log.warning("what %s has shared cannot be read", robot)
                continue
            self._shared.setdefault(robot, {})[topic] = Shared(
                robot,
                topic,
                body.at_ns,
                body.until_ns,
                bytes(fact.letter.content),
                body.id,
                body.hops,
            )
