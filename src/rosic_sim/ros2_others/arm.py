"""Six joints that follow a trajectory as far as their motors can, and a gripper with a part."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
FASTEST_RAD_S = (2.0, 2.0, 3.0, 3.0, 3.0, 3.0)
DECELERATION_RAD_S2 = 8.0
LAG_RAD = 0.1
GRIPPER = "finger_joint"
OPEN_M, PART_M, GRIPPER_M_S = 0.085, 0.03, 0.1


class TrajectoryPoint(NamedTuple):
    """Where the joints are to be, and after how many seconds."""

    at_s: float
    positions: tuple[float, ...]


class Arm:
    """Where the joints are, how fast they go, and what they follow.

    Attributes:
        late: It fell behind its trajectory by more than `LAG_RAD`: asked too much of the motors.
    """

    def __init__(self) -> None:
        self.positions = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
        self.speeds = [0.0] * len(JOINTS)
        self.late = False
        self._points: list[TrajectoryPoint] = []
        self._begun_s = 0.0

    def follow(self, points: Sequence[TrajectoryPoint], now_s: float) -> None:
        """Follow a trajectory from where it is."""
        self._points = [TrajectoryPoint(0.0, tuple(self.positions)), *points]
        self._begun_s, self.late = now_s, False

    def halt(self) -> None:
        """Follow nothing; come to rest as fast as the motors can."""
        self._points = []

    @property
    def arrived(self) -> bool:
        """Whether it stands at the end of what it followed."""
        return not self._points and self.at_rest

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves."""
        return not any(self.speeds)

    def step(self, dt_s: float, now_s: float) -> None:
        """Advance by a moment."""
        wanted = self._wanted(now_s + dt_s)
        for index, fastest in enumerate(FASTEST_RAD_S):
            here = self.positions[index]
            if wanted is None:
                speed = self.speeds[index]
                slower = max(0.0, abs(speed) - DECELERATION_RAD_S2 * dt_s)
                self.speeds[index] = slower if speed > 0 else -slower
            else:
                speed = (wanted[index] - here) / dt_s
                self.speeds[index] = max(-fastest, min(fastest, speed))
                self.late = self.late or abs(speed) * dt_s > LAG_RAD
            self.positions[index] = here + self.speeds[index] * dt_s
        if self._points and now_s + dt_s - self._begun_s >= self._points[-1].at_s:
            goal = self._points[-1].positions
            if max(abs(g - p) for g, p in zip(goal, self.positions, strict=True)) < 1e-6:  # noqa: PLR2004 - there
                self._points, self.speeds = [], [0.0] * len(JOINTS)

    def _wanted(self, now_s: float) -> tuple[float, ...] | None:
        """Return where the joints are to be by then; a smooth step leads from point to point."""
        gone_s = now_s - self._begun_s
        for before, after in zip(self._points, self._points[1:], strict=False):
            if gone_s < after.at_s:
                share = max(0.0, gone_s - before.at_s) / max(after.at_s - before.at_s, 1e-9)
                smooth = share * share * (3 - 2 * share)
                pairs = zip(before.positions, after.positions, strict=True)
                return tuple(a + (b - a) * smooth for a, b in pairs)
        return self._points[-1].positions if self._points else None


class ArmGripper:
    """Two fingers, with a part between them until somebody takes it away.

    Attributes:
        width_m: Between the fingers.
        stalled: They push and do not move: they hold something.
    """

    def __init__(self) -> None:
        self.width_m = OPEN_M
        self.speed_m_s = 0.0
        self.stalled = False
        self.part = True
        self._goal_m: float | None = None

    def go(self, width_m: float) -> None:
        """Close or open to a width."""
        self._goal_m, self.stalled = min(max(width_m, 0.0), OPEN_M), False

    def halt(self) -> None:
        """Stay as it is."""
        self._goal_m, self.speed_m_s = None, 0.0

    @property
    def reached(self) -> bool:
        """Whether it is where it was sent."""
        return self._goal_m is not None and abs(self._goal_m - self.width_m) < 1e-6  # noqa: PLR2004 - there

    def step(self, dt_s: float) -> None:
        """Advance by a moment."""
        if self._goal_m is None or self.stalled:
            self.speed_m_s = 0.0
            return
        way = max(-GRIPPER_M_S * dt_s, min(GRIPPER_M_S * dt_s, self._goal_m - self.width_m))
        narrow = self.width_m + way
        if self.part and way < 0 and narrow < PART_M:
            narrow, self.stalled = min(self.width_m, PART_M), True
        self.speed_m_s = (narrow - self.width_m) / dt_s
        self.width_m = narrow
