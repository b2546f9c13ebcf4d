"""What a draft says of robots as others build them: Nav2, and arms with ros2_control. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

NAVIGATE: Final = "nav2_msgs/action/NavigateToPose"
FOLLOW: Final = "control_msgs/action/FollowJointTrajectory"
GRIP: Final = "control_msgs/action/GripperCommand"
# Neither Nav2 nor a trajectory controller knows of gateways: a goal goes on when one is gone.
GOES_ON: Final = frozenset({NAVIGATE, FOLLOW})
# What Nav2 is made of inside, and what nobody should say to it from outside.
INSIDE: Final = "nav2_msgs/action/"

REACH_RAD: Final = 0.3
SPEED_RAD_S: Final = 0.2
AREA_M: Final = 2.0
ROUNDED: Final = 3

NAVIGATE_NOTE = """\
# Nav2: 'here' is {where}. Drive the robot to every place that
# people should be able to name, and write down what {pose} says there: x and y in m, yaw in rad.
# goto is bounded to {area:g} m around it; write the bounds of your map instead.
"""
FOLLOW_NOTE = """\
# The arm: 'here' is {where}. Limits are {reach:g} rad around it and {speed:g} rad/s:
# write those of your arm, and poses that people should be able to name, as {topic} reports them.
# It goes straight from pose to pose: whether anything is in the way, nobody checks.
"""
GRIP_NOTE = """\
# The gripper: widths in m. A skill that grips something says 'success: stalled', so that done means
# that something is held.
"""


class MapPose(NamedTuple):
    """Where a robot was seen to be on its map: m, and rad from the x axis."""

    x: float
    y: float
    yaw: float
    frame: str = "map"


class ArmDraft(NamedTuple):
    """The joints of one trajectory controller, and where they were seen to be, by name.

    Attributes:
        topic: That reports them.
    """

    topic: str
    positions: Mapping[str, float]


def navigating(name: str, stand: MapPose | None) -> dict[str, Any]:
    """Return the skills of a robot with Nav2."""
    here = stand or MapPose(0.0, 0.0, 0.0)
    action: dict[str, Any] = {"name": name, "type": NAVIGATE}
    rest = {"remaining": "distance_remaining", "timeout_s": 600}
    frame = {"pose.header.frame_id": here.frame}
    x, y = round(here.x), round(here.y)
    point = {
        "pose.pose.position.x": "$x",
        "pose.pose.position.y": "$y",
        "pose.pose.orientation": "$yaw",
    }
    place = {field: f"$place.{value[1:]}" for field, value in point.items()}
    stands = {"x": round(here.x, ROUNDED), "y": round(here.y, ROUNDED)}
    stands["yaw"] = round(here.yaw, ROUNDED)
    return {
        "goto": {
            "title": "Go to a point on the map",
            "titles": {"de": "Zu einem Punkt auf der Karte fahren"},
            "class": "motion",
            "parameters": {
                "x": {"unit": "m", "min": x - AREA_M, "max": x + AREA_M},
                "y": {"unit": "m", "min": y - AREA_M, "max": y + AREA_M},
                "yaw": {
                    "title": "Heading",
                    "titles": {"de": "Ausrichtung"},
                    "unit": "deg",
                    "min": -180,
                    "max": 180,
                    "default": 0,
                },
            },
            "action": action | {"goal": frame | point} | rest,
        },
        "visit": {
            "title": "Go to a place",
            "titles": {"de": "Zu einem Ort fahren"},
            "class": "motion",
            "words": ["go", "go to"],
            "parameters": {
                "place": {
                    "title": "Place",
                    "choices": {"here": []},
                    "means": {"here": stands},
                },
            },
            "action": action | {"goal": frame | place} | rest,
        },
    }


def following(name: str, limbs: ArmDraft) -> dict[str, Any]:
    """Return the skills of an arm with a trajectory controller."""
    action: dict[str, Any] = {"name": name, "type": FOLLOW}
    here = [round(position, ROUNDED) for position in limbs.positions.values()]
    low = min((limit["min"] for limit in limits(limbs).values()), default=0.0)
    high = max((limit["max"] for limit in limits(limbs).values()), default=0.0)
    return {
        "pose": {
            "title": "Go to a pose",
            "titles": {"de": "In eine Haltung gehen"},
            "class": "motion",
            "words": ["go", "go to"],
            "parameters": {
                "pose": {
                    "title": "Pose",
                    "choices": {"here": []},
                    "means": {"here": {"joints": here}},
                },
            },
            "action": action | {"trajectory": {"to": "$pose.joints", "speed": 0.5}},
        },
        "joint": {
            "title": "Move a joint",
            "titles": {"de": "Ein Gelenk bewegen"},
            "class": "motion",
            "parameters": {
                "joint": {"title": "Joint", "choices": {joint: [] for joint in limbs.positions}},
                "angle": {
                    "title": "To the angle",
                    "titles": {"de": "Auf den Winkel"},
                    "unit": "rad",
                    "min": low,
                    "max": high,
                },
            },
            "action": action | {"trajectory": {"to": "$angle", "joint": "$joint", "speed": 0.5}},
        },
    }


def limits(limbs: ArmDraft) -> dict[str, dict[str, float]]:
    """Return narrow limits around where the joints are."""
    return {
        joint: {
            "min": round(position - REACH_RAD, ROUNDED),
            "max": round(position + REACH_RAD, ROUNDED),
            "speed": SPEED_RAD_S,
        }
        for joint, position in limbs.positions.items()
    }


def gripping(name: str) -> dict[str, Any]:
    """Return the skill of a gripper."""
    return {
        "gripper": {
            "title": "Open or close the gripper",
            "titles": {"de": "Den Greifer öffnen oder schließen"},
            "class": "motion",
            "words": ["fingers"],
            "parameters": {
                "width": {"title": "Width", "unit": "m", "min": 0, "max": 0.05},
                "force": {"title": "Force", "unit": "N", "min": 1, "max": 20, "default": 5},
            },
            "action": {
                "name": name,
                "type": GRIP,
                "goal": {"command.position": "$width", "command.max_effort": "$force"},
                "timeout_s": 20,
            },
        },
    }
