"""An ABB YuMi (IRB 14000): two arms that hand things over."""

from __future__ import annotations

from math import dist, radians
from typing import TYPE_CHECKING, Literal, TypeAlias

from rosic.core.i18n import joined, said
from rosic.core.language.formatting import show_choice
from rosic_sim.robots.machines.activity import ActivityFailed, ActivityRefused, ActivityState
from rosic_sim.robots.machines.joints import JointGroup, MachineJointLimit
from rosic_sim.robots.machines.kinematics import yumi_points
from rosic_sim.robots.machines.objects import Gripper, Position, SimulatedObject, SimulatedObjects
from rosic_sim.robots.machines.stepped_machine import Plan, Recipe, SteppedMachine

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic_sim.robots.machines.arguments import MachineArguments

Side: TypeAlias = Literal["left", "right"]

# Ranges and speeds in the order of the chain, which ABB numbers 1, 2, 7, 3, 4, 5, 6: ABB "Product
# specification IRB 14000", working range and velocity. Accelerations: assumed.
_AXES = (
    (-168.5, 168.5, 180),
    (-143.5, 43.5, 180),
    (-168.5, 168.5, 180),
    (-123.5, 80.0, 180),
    (-290.0, 290.0, 400),
    (-88.0, 138.0, 400),
    (-229.0, 229.0, 400),
)
ARM_LIMITS = tuple(
    MachineJointLimit(radians(low), radians(high), radians(speed), 4.0, 12.0)
    for low, high, speed in _AXES
)
JOINTS = len(ARM_LIMITS)
# ABB "Product manual, grippers for IRB 14000": 50 mm travel, 25 mm/s, 20 N at most.
OPENING_M = 0.050
CLOSING_M_S = 0.025
FORCE_N = 10.0
# Assumed: share of the axis speeds, and taught poses of the left arm (from the inverse kinematics
# of this chain). The tips are 24 cm apart before the meeting and 6 cm at it, pointing at each
# other along y at 42 cm in front and 30 cm above the base. The right arm mirrors them.
SHARE = 0.25
SLOW_SHARE = 0.1
HOME_LEFT = tuple(map(radians, (0, -130, 135, 30, 0, 40, 0)))
BEFORE_LEFT = (-0.7894, -1.0708, 1.156, 0.4098, -0.1768, 1.1624, 0.0)
MEET_LEFT = (-0.9087, -0.8888, 1.2182, 0.5605, -0.3837, 0.8794, 0.0)
_MIRROR = (-1, 1, -1, 1, -1, 1, -1)
APART_M = 0.15
SETTLE_S = 0.2


def _both(left: Sequence[float]) -> tuple[float, ...]:
    return (*left, *(m * angle for m, angle in zip(_MIRROR, left, strict=True)))


HOME, BEFORE, MEET = _both(HOME_LEFT), _both(BEFORE_LEFT), _both(MEET_LEFT)


class Yumi(SteppedMachine):
    """Skills: ``home``, ``handover``. Runs on mains.

    One phase drives both arms, so they move in step to the last digit, and what stops one stops
    the other. Finger tips are at least `APART_M` apart, except between the stages "meeting" and
    "parting" of a hand-over. In a hand-over the object is always held: the giver opens only
    after the receiver has been measured to hold.

    Attributes:
        arms: Fourteen joints, left before right.
        grippers: By side; named ``<robot>/left`` and ``<robot>/right``.
        failed: Sides that have failed.
    """

    def __init__(self, robot: str = "yumi", things: SimulatedObjects | None = None) -> None:
        super().__init__(robot)
        self._things = things if things is not None else SimulatedObjects()
        self.arms = JointGroup((*ARM_LIMITS, *ARM_LIMITS), HOME)
        self.grippers: dict[Side, Gripper] = {
            "left": Gripper(f"{robot}/left", OPENING_M, CLOSING_M_S, self._things),
            "right": Gripper(f"{robot}/right", OPENING_M, CLOSING_M_S, self._things),
        }
        self.failed: set[Side] = set()
        self._extra: dict[str, float] = {}
        self._plans: dict[str, Plan] = {
            "home": self._plan_home,
            "handover": self._plan_handover,
        }

    # --------------------------------------------------------------------------------------- faults

    def fail_arm(self, side: Side, now_s: float) -> None:
        """Let one arm fail: both stop, grippers keep what they hold, the activity fails."""
        self.step(now_s)
        self.failed.add(side)
        self.note = said("the {side} arm has failed, both arms stopped", side=show_choice(side))
        held = self._held()
        self._end(ActivityState.FAILED, f"{self.note}, {held}" if held else self.note)
        self._brake()

    def repair_arm(self, side: Side) -> None:
        """Make an arm whole again; nothing moves."""
        self.failed.discard(side)

    def _held(self) -> str:
        sides = [side for side, gripper in self.grippers.items() if gripper.held is not None]
        if not sides:
            return ""
        return said(
            "the object is still held by the {sides} gripper",
            sides=joined(said(" and the "), map(show_choice, sides)),
        )

    # --------------------------------------------------------------------------------------- plans

    def _plan(self, skill: str) -> Plan | None:
        return self._plans.get(skill)

    def _able(self) -> None:
        for side in self.failed:
            raise ActivityRefused(
                self.id, said("the {side} arm has failed", side=show_choice(side))
            )
        if self._in_motion():
            raise ActivityRefused(self.id, said("still coming to rest"))

    def _plan_home(self, _asked: MachineArguments) -> Recipe:
        return self._recipe_home()

    def _plan_handover(self, asked: MachineArguments) -> Recipe:
        receiver: Side = (
            "left" if asked.choice("to", ("left", "right"), "right") == "left" else "right"
        )
        giver: Side = "right" if receiver == "left" else "left"
        thing = self.grippers[giver].held
        if self.grippers[receiver].held is not None:
            raise ActivityRefused(
                self.id,
                said(
                    "the {receiver} gripper already holds something", receiver=show_choice(receiver)
                ),
            )
        if thing is None:
            raise ActivityRefused(
                self.id,
                said("the {giver} gripper holds nothing to hand over", giver=show_choice(giver)),
            )
        return self._recipe_handover(giver, receiver, thing)

    # -------------------------------------------------------------------------------------- recipes

    def _recipe_home(self) -> Recipe:
        yield from self._leave_meeting(0.5)
        self._stage(said("going home"))
        yield from self._move(HOME, SHARE, 0.5, 1.0)
        return said("both arms at home")

    def _recipe_handover(self, giver: Side, receiver: Side, thing: SimulatedObject) -> Recipe:
        yield from self._leave_meeting(0.05)
        self._stage(said("approaching"))
        self.grippers[receiver].open()
        yield from self._move(BEFORE, SHARE, 0.05, 0.3)
        yield from self._fingers(self.grippers[receiver])
        self._stage(said("meeting"))
        yield from self._move(MEET, SLOW_SHARE, 0.3, 0.45)
        self._stage(said("{receiver} closes", receiver=show_choice(receiver)))
        yield from self._take(giver, receiver, thing)
        self._advance(0.6)
        self._stage(said("verifying both hold"))
        yield from self._wait(SETTLE_S)
        if not self._both_hold(thing):
            yield from self._undo(giver, receiver, thing)
        self._stage(said("{giver} opens", giver=show_choice(giver)))
        both_since = self._time_s
        self.grippers[giver].open()
        yield from self._fingers(self.grippers[giver])
        self._extra["opened_s"] = self._time_s - both_since
        self._stage(said("parting"))
        yield from self._move(BEFORE, SLOW_SHARE, 0.7, 0.85)
        self._stage(said("going home"))
        yield from self._move(HOME, SHARE, 0.85, 1.0)
        if self.grippers[receiver].held is not thing:
            raise ActivityFailed(said("the object was lost after the hand-over"))
        return said(
            "the {receiver} gripper holds the {name}",
            receiver=show_choice(receiver),
            name=show_choice(thing.name),
        )

    def _take(self, giver: Side, receiver: Side, thing: SimulatedObject) -> Recipe:
        """Close the receiver on what the giver really brings."""
        gripper = self.grippers[receiver]
        brought = thing if self.grippers[giver].held is thing else None
        gripper.close(FORCE_N, brought)
        yield from self._fingers(gripper)
        self._extra["width_m"] = gripper.width_m
        self._extra["separation_m"] = self.separation_m()
        return ""

    def _both_hold(self, thing: SimulatedObject) -> bool:
        return all(gripper.held is thing for gripper in self.grippers.values())

    def _undo(self, giver: Side, receiver: Side, thing: SimulatedObject) -> Recipe:
        """Part without a hand-over; the giver keeps what it has."""
        if self.grippers[giver].held is thing:
            self.grippers[receiver].open()
            yield from self._fingers(self.grippers[receiver])
        self._stage(said("parting"))
        yield from self._move(BEFORE, SLOW_SHARE, 0.0, 0.0)
        yield from self._move(HOME, SHARE, 0.0, 0.0)
        raise ActivityFailed(
            said(
                "the {receiver} gripper did not get hold of the object",
                receiver=show_choice(receiver),
            )
        )

    def _leave_meeting(self, end: float) -> Recipe:
        """Part first if the arms were stopped at a meeting; a shared object stays with the left."""
        left, right = self.grippers["left"], self.grippers["right"]
        if left.held is not None and left.held is right.held:
            self._stage(said("right opens"))
            right.open()
            yield from self._fingers(right)
        if self.separation_m() < APART_M:
            self._stage(said("parting"))
            yield from self._move(BEFORE, SLOW_SHARE, 0.0, end)
        return ""

    def _move(self, targets: Sequence[float], share: float, start: float, end: float) -> Recipe:
        self.arms.go(targets, share)
        while not self.arms.still:
            self._advance(start + (end - start) * self.arms.progress)
            yield
        return ""

    @staticmethod
    def _fingers(gripper: Gripper) -> Recipe:
        while not gripper.still:
            yield
        return ""

    def _wait(self, duration_s: float) -> Recipe:
        until_s = self._time_s + duration_s
        while self._time_s < until_s:
            yield
        return ""

    # ------------------------------------------------------------------------------------ mechanics

    def tips(self, side: Side) -> Position:
        """Return where one arm's finger tips are, in the base frame."""
        angles = self.arms.positions
        left = side == "left"
        return yumi_points(angles[:JOINTS] if left else angles[JOINTS:], left=left)[-1]

    def separation_m(self) -> float:
        """Return the distance between the finger tips of both arms."""
        return dist(self.tips("left"), self.tips("right"))

    def _drive(self, dt_s: float) -> None:
        for gripper in self.grippers.values():
            gripper.step(dt_s)
        self.arms.step(dt_s)

    def _brake(self) -> None:
        self.arms.brake()
        for gripper in self.grippers.values():
            gripper.stop()

    def _in_motion(self) -> bool:
        return not (self.arms.still and all(g.still for g in self.grippers.values()))

    def at_rest(self) -> bool:
        """True when all joints are slower than 1 mrad/s and all fingers slower than 0.5 mm/s."""
        slow = 0.0005
        return self.arms.at_rest and all(abs(g.speed_m_s) < slow for g in self.grippers.values())

    def _mark(self) -> None:
        self._extra = {}

    def _measured(self) -> dict[str, float]:
        return dict(self._extra)

    def telemetry(self) -> Mapping[str, float | str]:
        """Joints of both arms in ABB's numbering, tips, grippers; on mains, so no battery."""
        values: dict[str, float | str] = {
            "power": "mains",
            "separation_m": self.separation_m(),
            "mode": "at rest" if self.at_rest() else "moving",
            "failed": " and ".join(sorted(self.failed)),
        }
        for side, gripper in self.grippers.items():
            held = gripper.held
            values[f"{side}_holding"] = held.name if held is not None else ""
            values[f"{side}_gripper_m"] = gripper.width_m
            first = 0 if side == "left" else JOINTS
            for index, name in enumerate((1, 2, 7, 3, 4, 5, 6)):
                values[f"{side}_joint_{name}_rad"] = self.arms.positions[first + index]
        return values
