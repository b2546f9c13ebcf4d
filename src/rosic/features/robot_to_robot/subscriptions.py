"""Who follows what robots share: other robots, at a pace, and chats, as a digest."""

from __future__ import annotations

import logging
from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.message import Chat
from rosic.core.policy.scope import READ
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import RobotId
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import PeerRobot
    from rosic.core.robot.dialogue_protocol import Shared
    from rosic.features.robot_to_robot.inbox import LoopGuard
    from rosic.features.robot_to_robot.permissions import PeerPermissions
    from rosic.features.robot_to_robot.shared_state import SharedState

KIND: Final = "shared-ear"
FOLLOWED_BY_ONE: Final = 64
EARS_OF_ONE: Final = 64
PAIR_PACE: Final = RateLimit(burst=10.0, per_s=5.0)
PAIRS_AT_MOST: Final = 8_192

log = logging.getLogger("rosic.robot_to_robot")

_json = msgspec.json.Encoder().encode


class Subscriber(msgspec.Struct, frozen=True, array_like=True):
    """Somebody who follows a robot.

    Attributes:
        robot, topic: Which; an empty topic: everything it shares, and what it says to others.
        peer: The robot that follows; empty for a chat.
        who: The person who follows in a chat; empty for a robot.
    """

    robot: RobotId
    topic: str
    peer: RobotId = ""
    who: PrincipalId = ""


class SubscriberChat(msgspec.Struct, frozen=True, array_like=True):
    """The chat that follows; sealed, for a chat's id is an account's."""

    messenger: str
    chat: Chat


_encode = msgspec.msgpack.Encoder().encode
_read_ear = msgspec.msgpack.Decoder(Subscriber).decode
_read_where = msgspec.msgpack.Decoder(SubscriberChat).decode


class Subscriptions:
    """Brings what is shared to those who follow it.

    A robot hears at most `PAIR_PACE` from each other robot; what comes faster is brought when
    there is room again, and then only the newest of each topic.

    Attributes:
        peers: The robots that can be told something.
    """

    def __init__(
        self, rights: PeerPermissions, shared_state: SharedState, guard: LoopGuard, clock: Clock
    ) -> None:
        self.peers: dict[RobotId, PeerRobot] = {}
        self._rights = rights
        self._shared_state = shared_state
        self._guard = guard
        self._clock = clock
        self._ears: dict[str, Subscriber] = {}
        self._chats: dict[str, SubscriberChat] = {}
        self._by_robot: dict[RobotId, dict[str, Subscriber]] = {}
        self._buckets: OrderedDict[tuple[RobotId, RobotId], Bucket] = OrderedDict()
        self._late: dict[tuple[RobotId, str, RobotId], None] = {}

    # ---- following ----

    def follow(self, subscriber: Subscriber, where: SubscriberChat | None = None) -> Fact | None:
        """Return what is to be written so that somebody follows; None if they do already.

        Raises:
            TooManyRequests: They follow, or the robot is followed by, as many as can be.
        """
        key = key_of(subscriber, where)
        if key in self._ears:
            return None
        mine = sum(
            e.peer == subscriber.peer and e.who == subscriber.who for e in self._ears.values()
        )
        if mine >= EARS_OF_ONE or len(self._by_robot.get(subscriber.robot, ())) >= FOLLOWED_BY_ONE:
            raise TooManyRequests(
                said(
                    "Too many follow {robot} already, or you follow too much.",
                    robot=self._rights.shown(subscriber.robot),
                ),
                retry_after_s=0.0,
            )
        letter = Letter(subscriber.who, _encode(where)) if where is not None else None
        return Fact(kind=KIND, key=key, body=_encode(subscriber), letter=letter)

    def unfollow(self, subscriber: Subscriber, where: SubscriberChat | None = None) -> Fact | None:
        """Return what is to be written so that somebody does not; None if they do not."""
        key = key_of(subscriber, where)
        return Fact(kind=KIND, key=key, body=b"") if key in self._ears else None

    def unfollow_here(
        self, robot: RobotId, who: PrincipalId, where: SubscriberChat
    ) -> tuple[Fact, ...]:
        """Return what is to be written so that somebody reads nothing of a robot in one chat."""
        here = where.messenger, where.chat.id, where.chat.topic
        theirs = (key for key, e in self._by_robot.get(robot, {}).items() if e.who == who)
        places = ((key, self._chats[key]) for key in theirs if key in self._chats)
        return tuple(
            Fact(kind=KIND, key=key, body=b"")
            for key, at in places
            if (at.messenger, at.chat.id, at.chat.topic) == here
        )

    def end_all(self, who: PrincipalId) -> tuple[Fact, ...]:
        """Return what is to be written so that somebody follows nothing any more."""
        return tuple(
            Fact(kind=KIND, key=key, body=b"") for key, e in self._ears.items() if e.who == who
        )

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read follows nothing."""
        before = self._ears.pop(fact.key, None)
        if before is not None:
            self._by_robot[before.robot].pop(fact.key, None)
            self._chats.pop(fact.key, None)
        if not fact.body:
            return
        try:
            subscriber = _read_ear(fact.body)
            where = None if fact.letter is None else _read_where(fact.letter.content)
        except msgspec.MsgspecError:
            log.warning("who follows a robot cannot be read")
            return
        if where is None and subscriber.who:
            return  # it was erased
        self._ears[fact.key] = subscriber
        self._by_robot.setdefault(subscriber.robot, {})[fact.key] = subscriber
        if where is not None:
            self._chats[fact.key] = where

    def chats(
        self, robot: RobotId, topic: str
    ) -> Iterator[tuple[str, PrincipalId, SubscriberChat]]:
        """Yield the chats that follow a topic, and whose they are who may read it now."""
        for key, subscriber in self._by_robot.get(robot, {}).items():
            where = self._chats.get(key)
            meant = subscriber.topic in {"", topic}
            if where is not None and meant and self._rights.may(subscriber.who, robot, READ):
                yield key, subscriber.who, where

    # ---- bringing ----

    def bring(self, shared: Shared) -> None:
        """Bring something new to the robots that follow it."""
        for subscriber in tuple(self._by_robot.get(shared.robot, {}).values()):
            if subscriber.peer and subscriber.topic in {"", shared.topic}:
                self._bring(shared, subscriber.peer)

    def _bring(self, shared: Shared, to: RobotId) -> None:
        now_ns, pair = self._clock.monotonic_ns(), (shared.robot, to)
        if self._guard.is_cut(*pair, now_ns) or not self._rights.robot_may(to, shared.robot, READ):
            return
        bucket = self._buckets.get(pair)
        if bucket is None:
            bucket = self._buckets[pair] = Bucket(PAIR_PACE, now_ns)
            if len(self._buckets) > PAIRS_AT_MOST:
                self._buckets.popitem(last=False)
        if bucket.take(now_ns) > 0:
            self._late[shared.robot, shared.topic, to] = None
            return
        self.send(to, described(shared, self._clock.wall_ns()) | {"kind": "shared"})

    def catch_up(self) -> None:
        """Bring what came too fast, as far as there is room now: the newest of it."""
        late, self._late = self._late, {}
        for robot, topic, to in late:
            shared = self._shared_state.get(robot, topic)
            if shared is not None:
                self._bring(shared, to)

    def send(self, to: RobotId, words: Mapping[str, object]) -> bool:
        """Say something to a robot. Return whether its nodes listen."""
        peer = self.peers.get(to)
        if peer is None:
            return False
        try:
            return peer.hear(_json(words))
        except Exception:
            log.exception("%s could not be told something", to)
            return False


def described(shared: Shared, now_ns: int) -> dict[str, object]:
    """Return what a robot reads about something shared."""
    return {
        "from": shared.robot,
        "topic": shared.topic,
        "data": msgspec.Raw(shared.data),
        "at_s": shared.at_ns / 1e9,
        "age_s": max(0.0, (now_ns - shared.at_ns) / 1e9),
        "id": shared.id,
        "hops": shared.hops,
    }


def key_of(subscriber: Subscriber, where: SubscriberChat | None) -> str:
    """Return the key of a subscriber's fact, which names nobody."""
    at = (where.messenger, where.chat.id, where.chat.topic) if where is not None else ()
    said_of = "\0".join((subscriber.robot, subscriber.topic, subscriber.peer, subscriber.who, *at))
    return blake2b(said_of.encode(), digest_size=DIGEST_BYTES).hexdigest()
