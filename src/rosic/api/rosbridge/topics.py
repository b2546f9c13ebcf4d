"""Which topics there are for whom, and one subscription and one publisher for all who use one.

A topic belongs to a robot. Those that its profile binds may be read by whoever may see the robot,
and those that move it are published by orders alone. Whatever else is on the graph is closed,
unless the configuration opens it.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.api.rosbridge.subscriptions import TopicUpdate
from rosic.core.i18n import said
from rosic.core.policy.query import Deny
from rosic.core.policy.scope import NO_SKILLS
from rosic.core.time_units import SECOND_NS
from rosic.errors import (
    ConfigurationError,
    NotFound,
    NotPermitted,
    NotUnderstood,
    RobotOffline,
    RobotStopped,
)
from rosic.gateway.live_topics import LiveTopic, bound_topics, live_topic

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.rosbridge.subscriptions import TopicSubscriptions
    from rosic.api.settings import OpenedTopicSettings
    from rosic.contracts.graph_topics import (
        GraphTopics,
        OnMessage,
        OpenedPublisher,
        OpenedTopic,
        TopicMessage,
    )
    from rosic.core.identity import Caller
    from rosic.core.robot.profile import Profile, RobotId

TOPICS_AT_MOST: Final = 256
"""Topics that are open at a time, for all clients together."""
RIGHT_FOR_NS: Final = SECOND_NS // 20
"""So long a right that was looked up is not looked up again; a changed policy counts at once."""

VELOCITIES: Final = frozenset({"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"})
TOO_MANY: Final = said("Too many topics are open here already. Nothing was opened.")

log = logging.getLogger("rosic.api")


def absolute(topic: str) -> str:
    """Return the absolute name of a topic, a service or an action."""
    return f"/{topic.strip('/')}"


def plain_type(type_name: str) -> str:
    """Return a type's name as it was in ROS 1: many clients say it so."""
    for kind in ("/msg/", "/srv/", "/action/"):
        type_name = type_name.replace(kind, "/")
    return type_name


def no_topic(name: str) -> NotFound:
    """Return why somebody uses no topic of this name."""
    return NotFound(said("There is no topic {topic} here that you may use.", topic=name))


class TopicAccess(NamedTuple):
    """What somebody may do with a topic.

    Attributes:
        right: Which right on the robot lets one publish to it; empty: nobody does.
        live: The skill by whose live orders alone it is published to; None: by none.
    """

    robot: RobotId
    topic: str
    type: str
    reads: bool = True
    right: str = ""
    live: LiveTopic | None = None


def check_topics(
    opened: tuple[OpenedTopicSettings, ...], profiles: Mapping[RobotId, Profile]
) -> None:
    """See that what the configuration opens can be opened, and moves nothing past the orders.

    Raises:
        ConfigurationError: It cannot; says why.
    """
    moving = bound_topics(profiles.values())
    for each in opened:
        name, profile = absolute(each.name), profiles.get(each.robot)
        where = f"api.topic {name}"
        if profile is None:
            raise ConfigurationError(f"There is no robot {each.robot!r}.", where=where)
        if name in moving:
            raise ConfigurationError(
                "A skill publishes to this topic.",
                where=where,
                hint="Leave it out: it may be used already, within that skill's bounds.",
            )
        if each.publish and each.type in VELOCITIES:
            raise ConfigurationError(
                "Velocities are published by skills alone.",
                where=where,
                hint="Give the robot's profile a skill with this topic.",
            )
        if each.publish and each.publish not in (*profile.skills, *NO_SKILLS):
            raise ConfigurationError(
                f"{each.robot} has no right {each.publish!r}.",
                where=where,
                hint="Name one of its skills, or a right as share.",
            )


class TopicDirectory:
    """Knows the topics that somebody may use, and whether they may publish.

    Args:
        context: The rooms.
        opened: What the configuration opens besides.
    """

    def __init__(self, context: ApiContext, opened: tuple[OpenedTopicSettings, ...]) -> None:
        self._context = context
        self._opened = {absolute(each.name): each for each in opened}

    def ros(self, robot: RobotId) -> GraphTopics:
        """Return the topics of a robot's graph.

        Raises:
            NotFound: It is on none.
        """
        linker = self._context.kernel.rooms.linker
        topics = linker.graph_topics(robot)
        if topics is None:
            shown = self._context.kernel.rooms.profiles[robot].shown
            raise NotFound(
                said("{robot} is on no ROS 2 graph here, so it has no topics to read.", robot=shown)
            )
        return topics

    def find(self, caller: ApiCaller, topic: str, type_name: str = "") -> TopicAccess:
        """Return what somebody may do with a topic.

        Raises:
            NotFound: There is none, as far as they may know.
            NotUnderstood: It is of another type.
        """
        name = absolute(topic)
        found = next((each for each in self.all(caller) if each.topic == name), None)
        if found is None:
            raise no_topic(name)
        if type_name and plain_type(type_name) != plain_type(found.type):
            raise NotUnderstood(said("{topic} is of the type {type}.", topic=name, type=found.type))
        return found

    def robots(self, caller: ApiCaller) -> frozenset[RobotId]:
        """Return the robots whose topics somebody may use."""
        return self._context.visible(caller) & self._context.kernel.rooms.profiles.keys()

    def all(self, caller: ApiCaller) -> Iterator[TopicAccess]:
        """Go through the topics that somebody may use; each once."""
        rooms = self._context.kernel.rooms
        visible = self._context.visible(caller)
        profiles = [profile for robot, profile in rooms.profiles.items() if robot in visible]
        seen: set[str] = set()
        moving = bound_topics(profiles)
        for name, (robot, _) in moving.items():
            live = live_topic((rooms.profiles[robot],), name)
            kind = live.type if live is not None else self._type_of(robot, name)
            seen.add(name)
            yield TopicAccess(robot, name, kind, live=live)
        for name, opened in self._opened.items():
            if opened.robot in visible and name not in seen:
                seen.add(name)
                yield TopicAccess(opened.robot, name, opened.type, opened.subscribe, opened.publish)
        for profile in profiles:
            topics = rooms.linker.graph_topics(profile.id)
            for name, kind in () if topics is None else topics.reported.items():
                if name not in seen:
                    seen.add(name)
                    yield TopicAccess(profile.id, name, kind)

    def why_closed(self, access: TopicAccess) -> str:
        """Return why nobody publishes to a topic themselves."""
        if self._opened.get(access.topic) is None and access.topic in bound_topics(
            self._context.kernel.rooms.profiles.values()
        ):
            shown = self._context.kernel.rooms.profiles[access.robot].shown
            return said(
                "{topic} moves {robot}, and is published by orders alone. Nothing was sent.",
                topic=access.topic,
                robot=shown,
            )
        return said("{topic} is not published to from here.", topic=access.topic)

    def _type_of(self, robot: RobotId, topic: str) -> str:
        skills = self._context.kernel.rooms.profiles[robot].skills.values()
        return next((s.sent.type for s in skills if absolute(s.sent.topic) == topic), "")


class PublishingRight:
    """Whether somebody may publish to an opened topic; asked before each message.

    Args:
        context: The rooms.
        caller: Who.
        access: Which topic.
    """

    def __init__(self, context: ApiContext, caller: ApiCaller, access: TopicAccess) -> None:
        self._rooms = context.kernel.rooms
        self._clock = context.kernel.machine_clock
        self._caller: Caller = self._rooms.authoriser.stand_for(caller.principal)
        self._access = access
        self._epoch, self._until_ns = -1, 0

    def check(self) -> None:
        """See that they may, now.

        Raises:
            Refusal: They may not; says why. Nothing was sent.
        """
        rooms, access = self._rooms, self._access
        if rooms.stops[access.robot].latched:
            raise RobotStopped(
                said(
                    "{robot} is stopped. Nothing was sent.",
                    robot=rooms.profiles[access.robot].shown,
                )
            )
        now_ns = self._clock.monotonic_ns()
        if rooms.linker.epoch == self._epoch and now_ns < self._until_ns:
            return
        organiser, caller = rooms.organiser, self._caller
        organiser.check_unlocked(caller)
        organiser.check_word(caller, access.robot, access.right)
        decision = organiser.decision(caller, access.robot, access.right)
        if isinstance(decision, Deny) or decision.needs or decision.unchecked:
            raise NotPermitted(
                said(
                    "Publishing to {topic} needs more than the right to it. Nothing was sent.",
                    topic=access.topic,
                )
            )
        self._epoch, self._until_ns = rooms.linker.epoch, now_ns + RIGHT_FOR_NS


class _Listened:
    """A topic that is listened to, and who is told."""

    def __init__(self) -> None:
        self.opened: OpenedTopic | None = None
        self.queues: set[TopicSubscriptions] = set()
        self.turn = asyncio.Lock()


class _Published:
    """A topic that is published to, and by how many clients."""

    def __init__(self) -> None:
        self.opened: OpenedPublisher | None = None
        self.users = 0
        self.turn = asyncio.Lock()


class TopicHub:
    """What is open on robots' graphs for clients of rosbridge."""

    def __init__(self, directory: TopicDirectory) -> None:
        self._directory = directory
        self._listened: dict[str, _Listened] = {}
        self._published: dict[str, _Published] = {}

    async def listen(self, access: TopicAccess, queue: TopicSubscriptions) -> None:
        """Have a client told what is published to a topic.

        Raises:
            RosicError: It cannot be listened to, and why.
        """
        there = self._listened.get(access.topic)
        if there is None:
            self._check_room()
            there = self._listened[access.topic] = _Listened()
        there.queues.add(queue)
        try:
            async with there.turn:
                if there.opened is None:
                    topics, told = self._directory.ros(access.robot), self._told(access, there)
                    there.opened = await topics.listen(access.topic, access.type, told)
        except BaseException:
            await self.leave(access.topic, queue)
            raise

    @staticmethod
    def _told(access: TopicAccess, there: _Listened) -> OnMessage:
        def told(message: TopicMessage) -> None:
            update = TopicUpdate(access.topic, message)
            for queue in there.queues:
                queue.put(update)

        return told

    async def leave(self, topic: str, queue: TopicSubscriptions) -> None:
        """Tell a client no more; nobody listens to what nobody is told."""
        there = self._listened.get(topic)
        if there is None:
            return
        there.queues.discard(queue)
        async with there.turn:
            if there.queues or self._listened.get(topic) is not there:
                return
            del self._listened[topic]
            if there.opened is not None:
                await there.opened.close()

    async def publisher(self, access: TopicAccess) -> OpenedPublisher:
        """Return what publishes to a topic; `release` must follow.

        Raises:
            RosicError: It cannot be published to, and why.
        """
        there = self._published.get(access.topic)
        if there is None:
            self._check_room()
            there = self._published[access.topic] = _Published()
        there.users += 1
        try:
            async with there.turn:
                if there.opened is None:
                    topics = self._directory.ros(access.robot)
                    there.opened = await topics.publisher(access.topic, access.type)
                return there.opened
        except BaseException:
            await self.release(access.topic)
            raise

    async def release(self, topic: str) -> None:
        """Let a publisher go; the last who does closes it."""
        there = self._published.get(topic)
        if there is None:
            return
        there.users -= 1
        async with there.turn:
            if there.users > 0 or self._published.get(topic) is not there:
                return
            del self._published[topic]
            if there.opened is not None:
                await there.opened.close()

    def _check_room(self) -> None:
        if len(self._listened) + len(self._published) >= TOPICS_AT_MOST:
            raise RobotOffline(TOO_MANY)
