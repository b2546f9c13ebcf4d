"""What a machine is doing, in the form in which it can be told."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field


class ActivityState(enum.StrEnum):
    """How an activity stands. Everything but ``RUNNING`` is final."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class ActivityRefused(Exception):
    """The machine will not begin this now. It has not moved.

    ``str(error)`` is a sentence that names the robot.

    Attributes:
        robot: Id of the machine.
        reason: The sentence without the name.
    """

    def __init__(self, robot: str, reason: str) -> None:
        super().__init__(f"{robot}: {reason}")
        self.robot = robot
        self.reason = reason


class ActivityFailed(Exception):
    """A recipe cannot be finished; raised inside machines only, never out of them."""


@dataclass(slots=True)
class Activity:
    """One skill, from its beginning to its end. The machine writes, everybody else reads.

    Attributes:
        number: Counts the activities of one machine from 1.
        state: Once final it never changes.
        fraction: In [0, 1]; never falls; 1 only when done.
        stage: What happens at present: "approaching", "lifting".
        detail: One sentence without the robot's name; empty while nothing is to be said.
        begun_s: When motion could begin: the time of ``begin``, or the common start.
        facts: Measured values with their unit in the name. After ``cancelled`` and ``failed``
            they are brought up to date once more when the machine has come to rest.
    """

    number: int
    skill: str
    begun_s: float
    state: ActivityState = ActivityState.RUNNING
    fraction: float = 0.0
    stage: str = ""
    detail: str = ""
    facts: dict[str, float] = field(default_factory=dict)

    @property
    def running(self) -> bool:
        """True until a final state is reached."""
        return self.state is ActivityState.RUNNING

    def enter(self, stage: str) -> None:
        """Begin a stage."""
        self.stage = stage

    def advance(self, fraction: float) -> None:
        """Raise the fraction; lower values are ignored, and the last step belongs to `end`."""
        self.fraction = max(self.fraction, min(fraction, 0.999))

    def end(self, state: ActivityState, detail: str) -> None:
        """Reach a final state; without effect when there is one already."""
        if not self.running:
            return
        self.state = state
        self.stage = ""
        self.detail = detail
        if state is ActivityState.DONE:
            self.fraction = 1.0
