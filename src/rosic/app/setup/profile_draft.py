"""A first profile for a robot that was seen on a ROS 2 graph. Pure: names and types in, text out.

Every guess is on the careful side, and the text says which ones have to be looked at.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import yaml

from rosic.app.setup import profile_draft_nav2 as others
from rosic.robots.ros2.answer_fields import ABORTS, code_fields, named, reason_field
from rosic.robots.ros2.profile_checks import enough_s

if TYPE_CHECKING:
    from rosic.app.setup.profile_draft_nav2 import ArmDraft, MapPose

Fields: TypeAlias = Callable[[str], Mapping[str, str] | None]
"""Name of an action type to its goal's fields and their types; None when it is not installed."""

TWIST = "geometry_msgs/msg/Twist"
STAMPED = "geometry_msgs/msg/TwistStamped"
ODOMETRY = "nav_msgs/msg/Odometry"
JOINTS = "sensor_msgs/msg/JointState"
BATTERY = "sensor_msgs/msg/BatteryState"
IMAGE = "sensor_msgs/msg/CompressedImage"
GRID = "nav_msgs/msg/OccupancyGrid"
PLAN = "nav_msgs/msg/Path"
LOCATED = "geometry_msgs/msg/PoseWithCovarianceStamped"
STRING = "std_msgs/msg/String"
TRIGGER = "std_srvs/srv/Trigger"
WATCHDOG_S = 0.5

HEADER = """\
# Drafted from the ROS 2 graph. Look at every bound before anybody uses it, then run:
# rosic robot check {robot}.yaml
"""
STREAMING = """\
# watchdog_s is a guess: the robot must come to rest by itself when velocities cease. Measure it:
# rosic doctor -c rosic.toml --try {robot}
"""

NO_REST = "# Left out of at_rest:"
UNJUDGED = "# Whatever it answers reads as done:"
GUESSED = "# Without a unit, from 0 to 1, as nothing tells better:"
UNSAID = "# Left as it is when nothing is said of it:"
WITHIN_S = 1.0
"""What at_rest.within_s is unless it is said."""

# Ending of a field's name to its unit and careful bounds in it.
UNITS: dict[str, tuple[str, float, float]] = {
    "_rad_s": ("rad/s", 0.1, 0.5),
    "_m_s": ("m/s", 0.05, 0.2),
    "_rad": ("rad", -1.57, 1.57),
    "_deg": ("deg", -90, 90),
    "_m": ("m", 0.01, 1),
    "_n": ("N", 1, 20),
    "_s": ("s", 0.1, 5),
}
PLAIN = ("", 0.0, 1.0)
NUMBERS = re.compile(r"(?:double|float|float32|float64|u?int(?:8|16|32|64))\Z")
WHOLE = re.compile(r"u?int(?:8|16|32|64)\Z")
FLOATS = re.compile(r"(?:double|float|float32|float64)\Z")
BOOLEAN = "boolean"
YES_OR_NO: dict[str, Any] = {
    "choices": {"off": [], "on": []},
    "means": {"off": {"value": False}, "on": {"value": True}},
    "default": "off",
}


class ReportedTopics(NamedTuple):
    """What was heard of its topics while it was looked at.

    Attributes:
        every_s: How many seconds apart what shows rest came, by topic.
        no_rest: Why a topic that could show rest shows none.
        per_cent: Batteries that say 100 where their message is defined to say 1.
    """

    every_s: Mapping[str, float] = {}
    no_rest: Mapping[str, str] = {}
    per_cent: frozenset[str] = frozenset()


class SeenRobot(NamedTuple):
    """What one robot offers on the graph: names to types.

    Attributes:
        namespace: ``/omni``; empty for what stands at the root.
        heard: Topics that somebody subscribes to.
        said: Topics that somebody publishes.
        stand: Where it was on its map; None if it did not say.
        limbs: Joints of its trajectory controllers, by the name of the action.
        mixed: The line that says that it is more than one robot; empty if it does not seem so.
        reported: What was heard of it.
    """

    namespace: str
    heard: Mapping[str, str]
    said: Mapping[str, str]
    services: Mapping[str, str]
    actions: Mapping[str, str]
    stand: MapPose | None = None
    limbs: Mapping[str, ArmDraft] = {}
    mixed: str = ""
    reported: ReportedTopics = ReportedTopics()


def robot_id(namespace: str) -> str:
    """Return what people could call a robot of a namespace."""
    name = re.sub(r"[^a-z0-9_]", "_", namespace.strip("/").lower())
    return (name if re.match(r"[a-z]", name) else f"robot_{name}".rstrip("_"))[:32]


def drafted(seen: SeenRobot, fields: Fields, answers: Fields) -> str:
    """Return a profile as YAML.

    Args:
        seen: The robot.
        fields: Tells the fields of an action's goal.
        answers: Tells those of its result.
    """
    robot = robot_id(seen.namespace)
    skills = _skills(seen, fields, answers)
    streams = any("stream_hz" in skill.get("topic", {}) for skill in skills.values())
    profile: dict[str, Any] = {
        "id": robot,
        "title": robot.replace("_", " "),
        "link": _link(seen),
        "stop": _stop(seen),
        "link_loss": "continue" if others.GOES_ON & set(seen.actions.values()) else "hold",
        "busy": "refuse",
        "watchdog_s": WATCHDOG_S if streams else None,
        "at_rest": _at_rest(seen),
        "joints": _joints(seen),
        "skills": skills,
        "telemetry": _telemetry(seen),
        "camera": _first(seen.said, IMAGE),
        "map": _first(seen.said, GRID),
        "pose": _first(seen.said, LOCATED) or _first(seen.said, ODOMETRY),
        "path": _first(seen.said, PLAN),
        "alerts": _alerts(seen),
    }
    kept = {key: value for key, value in profile.items() if value not in (None, {})}
    body = yaml.safe_dump(kept, sort_keys=False, allow_unicode=True, width=110)
    notes = (HEADER + (STREAMING if streams else "")).format(robot=robot)
    return seen.mixed + notes + "".join((*_notes(seen), *_gaps(seen, fields, answers))) + body


def _notes(seen: SeenRobot) -> Iterable[str]:
    """Say what has to be filled in, for the robots that are known better than by names."""
    for topic, why in sorted(seen.reported.no_rest.items()):
        yield f"{NO_REST} {topic}: {why}.\n"
    kinds = set(seen.actions.values())
    if others.NAVIGATE in kinds:
        where = "where it stands now" if seen.stand else "0, 0, as it did not say where it is"
        pose = next(iter(_of(seen.said, LOCATED)), "its localisation")
        yield others.NAVIGATE_NOTE.format(where=where, pose=pose, area=others.AREA_M)
    for limbs in seen.limbs.values():
        yield others.FOLLOW_NOTE.format(
            where="how it stands now",
            topic=limbs.topic,
            reach=others.REACH_RAD,
            speed=others.SPEED_RAD_S,
        )
        break
    if others.GRIP in kinds:
        yield others.GRIP_NOTE


def _gaps(seen: SeenRobot, fields: Fields, answers: Fields) -> Iterable[str]:
    """Say what a draft of an action leaves open: success, units, fields of its goal."""
    for name, kind in sorted(seen.actions.items()):
        if _known(seen, name, kind) is not None:
            continue
        codes = code_fields(answers(kind) or {})
        if codes and kind.partition("/")[0] not in ABORTS:
            yield f"{UNJUDGED} {name}. {named(codes)}.\n"
        goal = (fields(kind) or {}).items()
        guessed = [field for field, its in goal if FLOATS.match(its) and not _ending(field)]
        if guessed:
            yield f"{GUESSED} {', '.join(guessed)} of {name}. Write unit, min and max.\n"
        unsaid = [
            f"{field} ({its})" for field, its in goal if not NUMBERS.match(its) and its != BOOLEAN
        ]
        if unsaid:
            yield f"{UNSAID} {', '.join(unsaid)} of {name}. Write what it has to be under goal.\n"


def _link(seen: SeenRobot) -> dict[str, Any]:
    link: dict[str, Any] = {"kind": "ros2", "namespace": seen.namespace or "/"}
    listens = any(_ends(name, "to_robot_topic") for name in _of(seen.heard, STRING))
    if listens and any(_ends(name, "from_robot_topic") for name in _of(seen.said, STRING)):
        link["dialogue"] = True
    return link


def _stop(seen: SeenRobot) -> dict[str, str | bool] | None:
    stop: dict[str, str | bool] = {}
    for name in _of(seen.services, TRIGGER):
        if _ends(name, "stop", "halt"):
            stop |= {"service": name, "type": TRIGGER}
            break
    for kind in (TWIST, STAMPED):
        for name in () if "zero" in stop else _of(seen.heard, kind):
            stop |= {"zero": name, "zero_type": kind}
            break
    # A trajectory controller holds when its goal is cancelled, and has no other way to be stopped.
    return stop or ({"cancel_only": True} if seen.limbs else None)


def _joints(seen: SeenRobot) -> dict[str, Any] | None:
    for limbs in seen.limbs.values():
        return {"topic": limbs.topic, "limits": others.limits(limbs)}
    return None


def _at_rest(seen: SeenRobot) -> dict[str, Any] | None:
    for kind in (ODOMETRY, JOINTS):
        for name in _of(seen.said, kind):
            if name in seen.reported.no_rest:
                continue
            every_s = seen.reported.every_s.get(name, 0.0)
            within_s = enough_s(every_s)
            return rest_of(name, kind) | ({"within_s": within_s} if within_s > WITHIN_S else {})
    return None


def rest_of(topic: str, kind: str) -> dict[str, Any]:
    """Return how rest is measured by a topic."""
    field = "velocity"
    if kind == ODOMETRY:
        # Nobody sees from here whether it flies: what only rises or sinks does not rest.
        axes = ("linear.x", "linear.y", "linear.z", "angular.z")
        field = ", ".join(f"twist.twist.{axis}" for axis in axes)
    return {"topic": topic, "type": kind, "field": field, "below": 0.005}


def _telemetry(seen: SeenRobot) -> dict[str, Any]:
    telemetry: dict[str, Any] = {}
    for name in _of(seen.said, BATTERY):
        telemetry["battery"] = {
            "topic": name,
            "type": BATTERY,
            "field": "percentage",
            "unit": "%",
            "alert_below": 20,
        }
        if name in seen.reported.per_cent:
            telemetry["battery"]["full"] = 100
        break
    # A localisation says on a map where it is, but not again and again: that is the 'pose'.
    for name in () if LOCATED in seen.said.values() else _of(seen.said, ODOMETRY):
        for axis in ("x", "y"):
            field = f"pose.pose.position.{axis}"
            telemetry[axis] = {"topic": name, "type": ODOMETRY, "field": field, "unit": "m"}
        break
    return telemetry


def _alerts(seen: SeenRobot) -> list[dict[str, str]] | None:
    """Return an alarm for a robot that is not there, where anything of it can be heard."""
    if _at_rest(seen) is None and not _telemetry(seen):
        return None
    return [{"name": "gone", "when": "offline", "for": "30 s", "tell": "operators"}]


def _first(said: Mapping[str, str], kind: str) -> dict[str, str] | None:
    return next(({"topic": name, "type": kind} for name in _of(said, kind)), None)


def _skills(seen: SeenRobot, fields: Fields, answers: Fields) -> dict[str, Any]:
    skills: dict[str, Any] = {}
    for name, kind in sorted(seen.actions.items()):
        known = _known(seen, name, kind)
        if known is None:
            known = {_skill_id(name): _action(name, kind, fields(kind), answers(kind))}
        skills |= known
    for name in _of(seen.services, TRIGGER):
        if not _ends(name, "stop", "halt"):
            skills.setdefault(
                _skill_id(name), {"class": "task", "service": {"name": name, "type": TRIGGER}}
            )
    for kind in (TWIST, STAMPED):
        for name in _of(seen.heard, kind):
            skills.setdefault("drive", _drive(name, kind))
    return skills


def _known(seen: SeenRobot, name: str, kind: str) -> dict[str, Any] | None:
    """Return the skills of an action that is known better; None for any other."""
    if kind == others.NAVIGATE:
        return others.navigating(name, seen.stand)
    if kind == others.FOLLOW and name == next(iter(seen.limbs), None):
        return others.following(name, seen.limbs[name])
    if kind == others.GRIP:
        return others.gripping(name)
    # A second arm, or one that did not say where it is, has to be written by hand.
    return {} if kind == others.FOLLOW or kind.startswith(others.INSIDE) else None


def _drive(topic: str, kind: str) -> dict[str, Any]:
    inside = "twist." if kind == STAMPED else ""
    return {
        "title": "Drive at a velocity for a while",
        "titles": {"de": "Eine Weile mit einer Geschwindigkeit fahren"},
        "class": "motion",
        "parameters": {
            "linear": {
                "title": "Forward",
                "titles": {"de": "Vorwärts"},
                "unit": "m/s",
                "min": -0.2,
                "max": 0.2,
                "default": 0,
            },
            "angular": {
                "title": "Turning left",
                "titles": {"de": "Linksdrehung"},
                "unit": "deg/s",
                "min": -30,
                "max": 30,
                "default": 0,
            },
            "duration": {
                "title": "For how long",
                "titles": {"de": "Wie lange"},
                "unit": "s",
                "min": 0.1,
                "max": 2,
            },
        },
        "topic": {
            "name": topic,
            "type": kind,
            "stream_hz": 10,
            "message": {f"{inside}linear.x": "$linear", f"{inside}angular.z": "$angular"},
        },
    }


def _action(
    name: str, kind: str, fields: Mapping[str, str] | None, answers: Mapping[str, str] | None
) -> dict[str, Any]:
    parameters: dict[str, Any] = {}
    goal: dict[str, str] = {}
    for field, kind_of_field in (fields or {}).items():
        if NUMBERS.match(kind_of_field):
            parameter, bounds = _parameter(field, whole=bool(WHOLE.match(kind_of_field)))
            parameters[parameter] = bounds
            goal[field] = f"${parameter}"
        elif kind_of_field == BOOLEAN:
            parameters[field.lower()] = deepcopy(YES_OR_NO)  # an alias is no YAML of ours
            goal[field] = f"${field.lower()}.value"
    action: dict[str, Any] = {"name": name, "type": kind}
    reason = reason_field(answers or {})
    if reason:
        action["message"] = reason
    skill: dict[str, Any] = {"class": "motion"}
    if goal:
        skill["parameters"] = parameters
        action["goal"] = goal
    return skill | {"action": action}


def _ending(field: str) -> str:
    return next((ending for ending in UNITS if field.endswith(ending)), "")


def _parameter(field: str, *, whole: bool) -> tuple[str, dict[str, Any]]:
    ending = _ending(field)
    unit, low, high = UNITS.get(ending, PLAIN)
    parameter: dict[str, Any] = {"unit": unit, "min": low, "max": high}
    if whole:
        parameter = {"min": 0, "max": 10, "integer": True}
    elif not unit:
        parameter = {"min": low, "max": high}
    return field.removesuffix(ending).lower() or field.lower(), parameter


def _skill_id(name: str) -> str:
    return re.sub(r"[^a-z0-9_]", "_", name.rpartition("/")[2].lower())


def _of(entries: Mapping[str, str], kind: str) -> Iterable[str]:
    return sorted(name for name, found in entries.items() if found == kind)


def _ends(name: str, *words: str) -> bool:
    return name.rpartition("/")[2] in words
