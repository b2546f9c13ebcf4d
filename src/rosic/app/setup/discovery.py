"""Looking at the live ROS 2 graph, and drafting a profile for every robot that is seen there."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from math import atan2, isfinite
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias, TypeVar

from rosic.app.setup.neighbours import drives, homes, mixed
from rosic.app.setup.profile_draft import (
    BATTERY,
    JOINTS,
    LOCATED,
    ODOMETRY,
    ReportedTopics,
    SeenRobot,
    drafted,
    rest_of,
    robot_id,
)
from rosic.app.setup.profile_draft_nav2 import FOLLOW, NAVIGATE, ArmDraft, MapPose
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.answer_fields import answered_fields
from rosic.robots.ros2.client.graph import GraphSnapshot, snapshot
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.robots.ros2.profile import AtRest
from rosic.robots.ros2.rest_reading import RestReading
from rosic.robots.ros2.telemetry import FULL

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.graph import GraphTopic
    from rosic.robots.ros2.client.topics import LatestMessage


# ---- listening ----

# A bounded listen to what a robot reports: what the names and types of its topics do not tell.

T = TypeVar("T")

LISTENED_S: Final = 3.0
ENOUGH: Final = 30
"""After so many messages nothing new is expected."""
AT_MOST: Final = 16
"""Of one robot so many topics are listened to."""
OLD_NS: Final = SECOND_NS
NEWEST: Final = TopicQos(reliable=False, depth=1)
KEPT: Final = TopicQos(reliable=True, latched=True, depth=1)


class _Rest(NamedTuple):
    every_s: float | None
    doubt: str


async def listened(runtime: RosRuntime, clock: Clock, seen: SeenRobot) -> SeenRobot:
    """Return a robot with what it said of its rest and its battery, all topics at once."""
    showing = [t for t in sorted(seen.said.items()) if t[1] in {ODOMETRY, JOINTS}][:AT_MOST]
    charged = [t for t in sorted(seen.said.items()) if t[1] == BATTERY][:AT_MOST]
    rests = await _all(_rest(runtime, clock, topic, kind) for topic, kind in showing)
    heard = {topic: rest for (topic, _), rest in zip(showing, rests, strict=True)}
    full = await _all(_charge(runtime, topic) for topic, _ in charged)
    return seen._replace(
        reported=ReportedTopics(
            every_s={topic: rest.every_s for topic, rest in heard.items() if rest.every_s},
            no_rest={topic: rest.doubt for topic, rest in heard.items() if rest.doubt},
            per_cent=frozenset(
                topic for (topic, _), most in zip(charged, full, strict=True) if most > FULL
            ),
        )
    )


async def _rest(runtime: RosRuntime, clock: Clock, topic: str, kind: str) -> _Rest:
    """Listen to what could show rest, until it is known how often it comes, or why it does not."""
    try:
        source = await runtime.latest(topic, kind, NEWEST)
    except RosicError:  # its type is not installed here
        return _Rest(None, "")
    try:
        rest = AtRest(**rest_of(topic, kind))
        reading = RestReading(rest, source, runtime.types.message(kind), clock)
        doubt, first, first_ns = "", 0, 0
        async for count in _messages(source):
            first, first_ns = first or count, first_ns or (source.received_ns or 0)
            doubt = reading.doubt(clock.monotonic_ns() - OLD_NS)
            if doubt:
                break
        more = source.received - first
        past_s = ((source.received_ns or 0) - first_ns) / SECOND_NS
        return _Rest(past_s / more if more else None, doubt)
    finally:
        await source.close()


async def _charge(runtime: RosRuntime, topic: str) -> float:
    """Return the most that a battery said of its charge; 0 for one that said nothing."""
    return max(await _all(_charged(runtime, topic, quality) for quality in (KEPT, NEWEST)))


async def _charged(runtime: RosRuntime, topic: str, quality: TopicQos) -> float:
    try:
        source = await runtime.latest(topic, BATTERY, quality)
    except RosicError:
        return 0.0
    most = 0.0
    try:
        async for _ in _messages(source):
            message = source.message()
            told = float("nan") if message is None else float(message.percentage)
            most = max(most, told if isfinite(told) else 0.0)
            if most:
                break
    except RosicError:
        return most
    finally:
        await source.close()
    return most


async def _messages(source: LatestMessage) -> AsyncIterator[int]:
    """Yield how many have come, each time that there are more, for a bounded time."""
    received, end_s = 0, asyncio.get_running_loop().time() + LISTENED_S
    while received < ENOUGH:
        try:
            left_s = end_s - asyncio.get_running_loop().time()
            received = await source.newer(received, timeout_s=left_s)
        except TimeoutError:
            return
        yield received


async def _all(waiting: Iterable[Awaitable[T]]) -> list[T]:
    return list(await asyncio.gather(*waiting))


# ---- discovery ----

# ---- a short look at found robots ----

GET_PARAMETERS: Final = "rcl_interfaces/srv/GetParameters"
TYPES: Final = (BATTERY, LOCATED, JOINTS, ODOMETRY, GET_PARAMETERS)
HEARD_WITHIN_S: Final = 1.5
STRING_ARRAY: Final = 9


async def looked_at(runtime: RosRuntime, seen: SeenRobot) -> SeenRobot:
    """Return a robot with where it stands, as far as it says so within a moment."""
    kinds = set(seen.actions.values())
    if NAVIGATE in kinds:
        seen = seen._replace(stand=await _stand(runtime, seen))
    if FOLLOW in kinds:
        seen = seen._replace(limbs=await _limbs(runtime, seen))
    return seen


async def _stand(runtime: RosRuntime, seen: SeenRobot) -> MapPose | None:
    located = await _heard(runtime, seen, LOCATED)
    if located is None:
        return None
    pose = located.pose.pose
    yaw = 2 * atan2(pose.orientation.z, pose.orientation.w)
    return MapPose(pose.position.x, pose.position.y, yaw, located.header.frame_id or "map")


async def _limbs(runtime: RosRuntime, seen: SeenRobot) -> dict[str, ArmDraft]:
    state = await _heard(runtime, seen, JOINTS)
    if state is None:
        return {}
    topic = _topic(seen, JOINTS)
    positions = dict(zip(state.name, map(float, state.position), strict=False))
    found = {}
    for action, kind in sorted(seen.actions.items()):
        if kind == FOLLOW:
            names = await _controlled(runtime, action) or list(positions)
            if set(names) <= positions.keys():
                found[action] = ArmDraft(topic, {name: positions[name] for name in names})
    return found


async def _controlled(runtime: RosRuntime, action: str) -> list[str]:
    """Return the joints that a controller says are its own; nothing if it does not say."""
    controller = action.rpartition("/")[0]
    link = await runtime.service(f"{controller}/get_parameters", GET_PARAMETERS)
    try:
        answer = await link.call(
            {"names": ["joints"]}, timeout_s=HEARD_WITHIN_S, found_within_s=HEARD_WITHIN_S
        )
    except RosicError:
        return []
    finally:
        await link.close()
    values = [value for value in answer.values if value.type == STRING_ARRAY]
    return [str(name) for value in values for name in value.string_array_value]


async def _heard(runtime: RosRuntime, seen: SeenRobot, kind: str) -> Any:  # noqa: ANN401 - a message
    topic = _topic(seen, kind)
    if not topic:
        return None
    # What is kept for whoever comes later, and what is said again and again, take two ears.
    for quality in (KEPT, NEWEST):
        latest = await runtime.latest(topic, kind, quality)
        try:
            await latest.newer(0, timeout_s=HEARD_WITHIN_S)
            return latest.message()
        except (TimeoutError, RosicError):
            continue
        finally:
            await latest.close()
    return None


def _topic(seen: SeenRobot, kind: str) -> str:
    return min((name for name, found in seen.said.items() if found == kind), default="")


NODE = "rosic_discover"
ANNOUNCED_S = 3.0
"""Fast DDS, which most robots have, says so often who is there; the first word may be lost."""
LOOK_S = ANNOUNCED_S + 1.0
Space: TypeAlias = "tuple[dict[str, str], dict[str, str], dict[str, str], dict[str, str]]"
SHOWING = frozenset({ODOMETRY, JOINTS})
RESTING = ("/odom", "/joint_states")
TELLING = ("/cmd_vel", "/odom", "/joint_states", "/to_robot_topic")


async def discover(
    clock: Clock, *, seconds: float, skip: Callable[[str], None] = lambda _: None
) -> dict[str, str]:
    """Look at the graph for a while, longer if nobody is seen. Return a profile for each robot.

    Args:
        clock: The time.
        seconds: For how long to look.
        skip: Told the names below which something is on the graph that is no robot.

    Returns:
        By the robot's id.

    Raises:
        RosMissing: There is no ROS 2 here.
        ConfigurationError: Nobody is on the graph.
    """
    runtime = await RosRuntime.open(TypeRegistry(TYPES), node_name=NODE)
    try:
        await clock.sleep(seconds)
        found = await snapshot(runtime)
        robots = robots_in(found)
        if not robots:
            seconds += ANNOUNCED_S
            await clock.sleep(ANNOUNCED_S)
            found = await snapshot(runtime)
            robots = robots_in(found)
        for name in left_out(found, robots):
            skip(name)
        robots = [await looked_at(runtime, robot) for robot in robots]
        robots = list(await asyncio.gather(*(listened(runtime, clock, robot) for robot in robots)))
    finally:
        await runtime.close()
    if not robots:
        raise ConfigurationError(
            f"No robot was seen on the ROS 2 graph within {seconds:g} s.",
            hint="Check ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE, or look for longer.",
        )
    return {
        robot_id(seen.namespace): drafted(seen, goal_fields, answered_fields) for seen in robots
    }


def robots_in(found: GraphSnapshot) -> list[SeenRobot]:
    """Sort what is on the graph by its first name; what can neither move nor tell is left out.

    Where several of a kind live below one name, it is sorted by the second, too.
    """
    apart = homes(found.topics)
    topics: defaultdict[str, list[GraphTopic]] = defaultdict(list)
    spaces: defaultdict[str, Space] = defaultdict(lambda: ({}, {}, {}, {}))
    for topic in found.topics:
        name = _space(topic.name, apart)
        topics[name].append(topic)
        space = spaces[name]
        if topic.subscribers:
            space[0][topic.name] = topic.types[0]
        if topic.publishers:
            space[1][topic.name] = topic.types[0]
    for offers, at in ((found.services, 2), (found.actions, 3)):
        for offer in offers:
            spaces[_space(offer.name, apart)][at][offer.name] = offer.types[0]
    _gather(spaces)
    seen = [
        SeenRobot(name, *spaces[name], mixed=mixed(name or "/", topics[name]))
        for name in sorted(spaces)
    ]
    return [
        robot
        for robot in seen
        if robot.actions or _tells(robot.heard) or _tells(robot.said) or drives(robot.heard)
    ]


def left_out(found: GraphSnapshot, robots: Iterable[SeenRobot]) -> list[str]:
    """Return what is on the graph below a name of its own, and in no robot."""
    drafted_of = {
        name
        for robot in robots
        for part in (robot.heard, robot.said, robot.services, robot.actions)
        for name in part
    }
    names = {topic.name for topic in found.topics}
    names |= {offer.name for offer in (*found.services, *found.actions)}
    spaces = {_space(name, frozenset()) for name in names - drafted_of}
    within = {_space(name, frozenset()) for name in drafted_of}
    return sorted(spaces - within - {""})


def _gather(spaces: dict[str, Space]) -> None:
    """Give what cannot show whether it rests to the robot at the root, if there is one that can.

    A robot alone on its graph often has no namespace, but its controllers have names of their own.
    """
    root = spaces.get("")
    if root is None or not _rests(root[1]):
        return
    for name in [name for name, parts in spaces.items() if name and not _apart(parts)]:
        for mine, theirs in zip(root, spaces.pop(name), strict=True):
            mine.update(theirs)


def _apart(parts: Space) -> bool:
    """Tell whether it shows its own rest; by types alone, only where it is driven as well.

    Filters of odometry have names of their own, and belong to the robot that they are about.
    """
    heard, said, *_ = parts
    return any(name.endswith(RESTING) for name in said) or (drives(heard) and _rests(said))


def _rests(said: Mapping[str, str]) -> bool:
    return not SHOWING.isdisjoint(said.values()) or any(name.endswith(RESTING) for name in said)


def goal_fields(kind: str) -> Mapping[str, str] | None:
    """Return the fields of an action's goal; None when its type is not installed here."""
    try:
        action = TypeRegistry((kind,)).action(kind)
    except RosicError:
        return None
    fields: Mapping[str, str] = action.Goal.get_fields_and_field_types()
    return fields


def _space(name: str, apart: frozenset[str]) -> str:
    parts = name.split("/")
    below = "/".join(parts[:3])
    if below in apart and below != name:
        return below
    return f"/{parts[1]}" if len(parts) > 2 else ""  # noqa: PLR2004 - "", space, name


def _tells(topics: Iterable[str]) -> bool:
    return any(name.endswith(TELLING) for name in topics)
