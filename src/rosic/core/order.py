"""From what a person asked to what a robot did: request, permit, order, report, outcome."""

from __future__ import annotations

import enum
from typing import Final

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import CommandId, KeyId, PrincipalId
from rosic.core.robot.profile import RobotId
from rosic.core.robot.skill import Argument, Skill

FOREVER_NS: Final = 2**63 - 1


class SpokenValue(msgspec.Struct, frozen=True, gc=False, cache_hash=True):
    """One value as it was said: ``50 cm``, ``force=20``, ``left``.

    Attributes:
        name: The parameter's name if it was said, else empty.
        number: None for a word.
        word: The unit of a number (empty when none was said), or the word itself.
    """

    name: str
    number: float | None
    word: str


class Request(msgspec.Struct, frozen=True, gc=False):
    """What a person asked of one robot.

    Attributes:
        group: The name under which several robots were asked together; empty for one robot.
        spoken: Values as said, not yet converted or bounded.
        text: The line as typed, or as the button says it.
        sent_ns: Wall clock of the platform, never later than our receive time.
        age_ns: How old it was when we received it.
        deadline_ns: Monotonic clock after which no robot may act on it.
        expires_ns: The same moment on the wall clock; whichever clock is later counts.
        sequel: An earlier line of the same message asked the same robot; wait for that one.
        live: Its values are replaced by samples while it runs.
    """

    cid: CommandId
    robot: RobotId
    skill: Skill
    spoken: tuple[SpokenValue, ...]
    text: str
    sent_ns: int
    age_ns: int
    deadline_ns: int
    expires_ns: int
    group: str = ""
    sequel: bool = False
    live: bool = False


class Permit(msgspec.Struct, frozen=True, gc=False):
    """The organiser's decision that a principal may do this now. It travels with the order.

    Attributes:
        fence: Number of the lease under which the robot is commanded; 0 for a skill that only
            observes.
        new_fence: This permit raised the fence; the record must hold it before the robot moves.
        stop_generation: The robot's stop generation when admitted.
        epoch: Number of the policy under which it was admitted.
        until_ns: Wall clock; from then on it has to be decided anew: a slot, a grant or a key
            ends, or somebody's slot begins.
        cancels: How often the principal had ended what they had under way with the robot; once
            they do so again, an order admitted before does not begin.
    """

    principal: PrincipalId
    key: KeyId
    robot: RobotId
    skill: str
    fence: int
    new_fence: bool
    stop_generation: int
    epoch: int
    until_ns: int = FOREVER_NS
    cancels: int = 0


class Order(msgspec.Struct, frozen=True):
    """What ROSIC decided: typed, bounded, numbered, expiring. Arguments are SI.

    Attributes:
        n: The robot's order number; only grows.
        deadline_ns: Monotonic clock; not acted on later.
        expires_ns: The same moment on the wall clock; not acted on later, by either.
        start_ns: Monotonic clock of a common start for several robots; None starts at once. Kept
            by robots whose way has a place for it, which do not begin much later either.
        words: How it reads: ``move, 0.50 m left``.
        live: Its values are replaced by samples while it runs; see `rosic.core.sample_gate`.
    """

    cid: CommandId
    robot: RobotId
    skill: Skill
    arguments: dict[str, Argument]
    n: int
    deadline_ns: int
    expires_ns: int
    permit: Permit
    start_ns: int | None = None
    sequel: bool = False
    words: str = ""
    live: bool = False

    def is_late(self, now_ns: int, wall_ns: int) -> bool:
        """Whether it has expired by the monotonic clock or by the wall clock (I2).

        Neither alone would do: a virtual machine that is paused stops the one, and somebody who
        sets the other back would make an old order good again.
        """
        return now_ns > self.deadline_ns or wall_ns > self.expires_ns


class OrderStage(enum.Enum):
    """Where an order is in its life. ``RECEIVED`` and later are said by the robot side only."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    ACCEPTED = "accepted"
    QUEUED = "queued"
    SENT = "sent"
    RECEIVED = "received"
    RUNNING = "running"


class StageReport(msgspec.Struct, frozen=True, gc=False):
    """A step in the life of an order.

    Attributes:
        fraction: In [0, 1], never falling; None when unknown.
        note: The robot's words; inert, may be empty.
    """

    stage: OrderStage
    fraction: float | None = None
    note: str = ""


class OrderProgress:
    """What may be told of how far a robot's side says that it is: a fraction that never falls.

    Attributes:
        fraction: The furthest so far; None until there is any.
    """

    def __init__(self) -> None:
        self.fraction: float | None = None

    def reported(self, fraction: float | None) -> float | None:
        """Take in what its side says, which may be no fraction; return what may be told."""
        if fraction is not None and 0.0 <= fraction <= 1.0:
            self.fraction = max(fraction, self.fraction or 0.0)
        return self.fraction


class OrderEnding(enum.Enum):
    """How a life ends (I7).

    ``DONE`` and ``FAILED``, ``CANCELLED`` come from the robot side. ``SENT`` is all that can be
    said of a robot that does not acknowledge: at most one actuation, like ``UNKNOWN``.
    ``REFUSED`` means that the robot has not moved.
    """

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"
    SENT = "sent"
    UNKNOWN = "unknown"
    REFUSED = "refused"


class Outcome(msgspec.Struct, frozen=True):
    """What was really done.

    Attributes:
        note: The robot's words; inert, may be empty.
        facts: Measured by the robot side, SI, unit in the name: ``distance_m``.
        code: For a refusal, the error's stable code; for an end that is in doubt, too.
    """

    ending: OrderEnding
    note: str = ""
    facts: dict[str, float] = {}
    code: str = ""


NEVER_BEGUN = said("ROSIC was shut down before this could begin. Nothing was done.")


class Stop(msgspec.Struct, frozen=True, gc=False):
    """A stop of one robot. Never queued, limited, expired or void.

    Attributes:
        generation: Every order admitted under an earlier one is void from now on.
    """

    robot: RobotId
    generation: int


class RestReport(msgspec.Struct, frozen=True, gc=False):
    """The robot side's answer to a stop.

    Attributes:
        confirmed: It was measured at rest. False: it did not confirm; it may still move.
        seconds: From the stop reaching the adapter to rest, or to giving up.
        note: How it rests when it is not simply standing: ``landed``.
        declined: What its own stop answered, if that was no success.
        unanswered: Its own stop did not answer, or is not there; what was measured was measured.
    """

    robot: RobotId
    confirmed: bool
    seconds: float
    note: str = ""
    declined: str = ""
    unanswered: bool = False
