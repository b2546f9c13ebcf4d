"""Six machines and two odd ones, as people would describe them."""

from __future__ import annotations

from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.robots.ros2.profile import Ros2Link

DIRECTIONS: dict[str, tuple[str, ...]] = {
    "forward": ("ahead", "straight on"),
    "back": ("backwards",),
    "left": (),
    "right": (),
}


def omni() -> Profile:
    return Profile(
        id="omni",
        link=Link(kind="memory"),
        words=("rover",),
        skills={
            "move": Skill(
                id="move",
                words=("shift",),
                parameters={
                    "direction": Parameter(choices=DIRECTIONS, default="forward"),
                    "distance": Parameter(unit="m", min=0.01, max=5),
                    "speed": Parameter(unit="m/s", min=0.05, max=0.8, default=0.25),
                },
            ),
            "turn": Skill(
                id="turn",
                parameters={
                    "direction": Parameter(choices={"left": ("ccw",), "right": ("cw",)}),
                    "angle": Parameter(unit="deg", min=1, max=360),
                },
            ),
            "go_home": Skill(id="go_home", title="Go back to the dock"),
        },
    )


def kuka() -> Profile:
    return Profile(
        id="kuka1",
        title="KUKA iiwa",
        link=Link(kind="memory"),
        skills={
            "move_joint": Skill(
                id="move_joint",
                parameters={
                    "joint": Parameter(min=1, max=7, integer=True),
                    "angle": Parameter(unit="deg", min=-170, max=170),
                },
            ),
            "grasp": Skill(
                id="grasp",
                title="Grasp the object",
                words=("grab",),
                parameters={"force": Parameter(unit="N", min=5, max=40, default=15)},
            ),
        },
    )


def yumi() -> Profile:
    return Profile(
        id="yumi",
        title="YuMi",
        link=Link(kind="memory"),
        skills={"handover": Skill(id="handover", words=("hand over",))},
    )


def crazyflie(number: int) -> Profile:
    return Profile(
        id=f"cf{number}",
        link=Link(kind="memory"),
        groups=("crazyflies",),
        skills={
            "takeoff": Skill(
                id="takeoff",
                words=("take off",),
                parameters={"height": Parameter(unit="m", min=0.2, max=2, default=0.5)},
            ),
            "goto": Skill(
                id="goto",
                words=("go to",),
                parameters={
                    name: Parameter(unit="m", min=0.2 if name == "z" else -5, max=5)
                    for name in ("x", "y", "z")
                },
            ),
        }
        | ({"film": Skill(id="film")} if number == 1 else {}),
    )


def echo() -> Profile:
    """A robot with the text link of the paper's Algorithm 8."""
    return Profile(id="echo", link=Ros2Link(kind="memory", dialogue=True))


def oven() -> Profile:
    return Profile(
        id="oven",
        link=Link(kind="memory"),
        skills={
            "heat": Skill(
                id="heat",
                parameters={
                    "temperature": Parameter(unit="°C", min=0, max=250),
                    "power": Parameter(unit="%", min=0, max=100, default=100),
                },
            )
        },
    )


def profiles() -> list[Profile]:
    return [omni(), kuka(), yumi(), *map(crazyflie, (1, 2, 3)), echo(), oven()]
