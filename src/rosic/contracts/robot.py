"""What a robot owes to ROSIC."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Awaitable, Callable
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias, runtime_checkable

from rosic.core.order import Order, Outcome, RestReport, StageReport, Stop

if TYPE_CHECKING:
    from rosic.contracts.live_control import LiveControls
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.file_transfer import FileForRobot, Receipt
    from rosic.core.robot.profile import Files, Presence, Profile, RobotId
    from rosic.core.robot.view import View, ViewKind


Tell: TypeAlias = Callable[[StageReport], None]
Say: TypeAlias = Callable[[str], None]


Deliver: TypeAlias = Callable[["FileForRobot"], Awaitable["Receipt"]]


@runtime_checkable
class TakesFiles(Protocol):
    """Files can be handed to its side; see `deliver_of`."""

    async def deliver(self, robot_file: FileForRobot) -> Receipt:
        """Hand one over, once."""


def deliver_of(robot: Robot) -> Deliver | None:
    """Return what a robot calls ``deliver``, if files can be handed to its side.

    It hands over one file, once, and returns what its side says of it. It raises ``RobotOffline``
    when its side is not there, or is stopped: nothing was sent; and ``RobotUnreachable`` when it
    was sent and nothing came in time: its side may or may not have it.
    """
    return robot.deliver if isinstance(robot, TakesFiles) else None


class Robot(Protocol):
    """One robot, or one simulated robot. ``rosic.testing.RobotConformance`` is this in tests.

    Attributes:
        profile: What it is.
        gate: What its side has seen; the adapter asks it immediately before acting.
    """

    profile: Profile
    gate: OrderGate

    async def open(self, say: Say) -> None:
        """Connect.

        Args:
            say: Takes a text the robot says of its own accord; called on the event loop.

        Raises:
            ConfigurationError: It can never work like this (a type that does not exist).
        """
        ...

    async def close(self) -> None:
        """Bring motion under this process's control to rest, then disconnect. Never raises."""
        ...

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Carry out one order and return what was really done.

        Passes the gate first, acts at most once, and never after a stop of a later generation.

        Args:
            order: Belongs to this robot. One at a time.
            tell: Called on the event loop with ``SENT``, then, only because the robot's side
                said so, ``RECEIVED`` and ``RUNNING`` with a fraction that never falls.

        Returns:
            ``SENT`` for a robot that does not acknowledge. ``CANCELLED`` after a stop.

        Raises:
            OrderVoid: The gate declined, or the common start that it would keep is over. The robot
                has not moved.
            RobotOffline: Not there; nothing was sent.
            RobotUnreachable: Sent, and no answer in time. It may or may not have moved.

        Cancelling the call brings the robot to rest before the cancellation leaves this method.
        """
        ...

    async def stop(self, stop: Stop) -> RestReport:
        """Latch the gate before the first suspension, then bring the robot to rest.

        Cancels what is under way, sends zero, calls the robot's own stop, together, and repeats
        until rest is measured or the profile's ``rest_timeout_s`` is over. Never raises.
        """
        ...

    async def resume(self, generation: int) -> None:
        """Undo the latch of ``generation``. The robot does not move because of it.

        Raises:
            RobotUnreachable: Its side did not answer; the latch stays.
        """
        ...

    def presence(self) -> Presence:
        """Return what its side last said; no I/O."""
        ...

    def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Yield what can be seen, each time newer than before, as fast as it is asked for.

        Looking moves nothing and hinders nobody. What it needs from the robot's side is taken up
        with the first step and given back when the generator is closed.

        Raises:
            NothingToSee: With any step: the profile does not offer it, or nothing came within
                some seconds.
        """
        ...


# ---- robots that are driven live ----


@runtime_checkable
class LiveRobot(Protocol):
    """A robot link that can carry out a live order: a stream of values that samples replace.

    The laws of it are in `rosic.testing.RobotConformance`, for robots that are one.
    """

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Carry out one live order and return what was really done, as `Robot.execute` does.

        Nothing is sent before the first sample. Each message has the values of the newest sample,
        and immediately before it is sent the controls are asked whether it may be. Once they say
        why not, zero is sent at once and nothing but zero any more; the order ends when rest was
        measured, or could not be. It never goes on by itself (I6).

        Args:
            order: A live one, of a skill that streams.
            tell: As `Robot.execute`; no fraction is told, as nobody knows how long it lasts.
            controls: What steers it. Left by this method, however it ends.
        """
        ...


# ---- robots that speak with each other ----

UTTERANCE_BYTES: Final = 65_536
"""What a robot says at once may be this long. An adapter hands on one byte more of what is longer,
and ROSIC says why it was not taken."""

Speak: TypeAlias = Callable[[bytes, int], None]
"""Takes one utterance in JSON, and how many before it were lost because they came too fast."""


@runtime_checkable
class PeerRobot(Protocol):
    """A robot whose own nodes share, ask and answer (Algorithm 5)."""

    def meet(self, speak: Speak) -> None:
        """Hand what the robot's nodes say to ``speak``, on the event loop; before it is opened.

        The newest matter: an adapter keeps few that wait, drops the oldest and counts them.
        """
        ...

    def hear(self, words: bytes) -> bool:
        """Bring an utterance in JSON to the robot's nodes, without waiting. Never raises.

        Returns:
            Whether somebody listens there. That it was understood is not known.
        """
        ...


class RobotTasks(Protocol):
    """Whoever keeps the tasks of robots. Without one, help is accepted and no task changes."""

    async def helped(self, helper: RobotId, asker: RobotId) -> str:
        """Adjust the tasks of a robot that helps and of the one it helps; once for each help.

        Args:
            helper: Empty where a person helps.
            asker: Who is helped.

        Returns:
            What was changed, in a sentence that people read; empty: nothing had to be.
        """
        ...


@runtime_checkable
class SilenceTest(Protocol):
    """A robot link that can try out the robot's own watchdog."""

    async def fall_silent(self, order: Order, tell: Tell) -> RestReport:
        """Stream as `execute` does, then cease without a zero, and wait for measured rest.

        Returns:
            The seconds from the last message to rest, or to giving up.
        """
        ...


@runtime_checkable
class DescribesTelemetry(Protocol):
    """A robot link that can tell how its robot reports."""

    async def rest_every_s(self, within_s: float) -> float | None:
        """Listen to what shows rest, at most so long; return how many seconds apart it comes.

        Returns:
            None where it was not heard twice.
        """
        ...

    def guessed(self) -> tuple[str, ...]:
        """Return which values were taken for per cent, as they are no fractions of 1."""
        ...


class FileFolders(Protocol):
    """Inboxes and outboxes of robots: folders that profiles name. Each raises RobotUnreachable."""

    def add_robot(self, robot: RobotId, files: Files) -> None:
        """Know the folders of one more robot."""
        ...

    def path(self, robot: RobotId, name: str) -> str:
        """Return where a file of an inbox lies; empty where there is none."""
        ...

    async def put(
        self, robot: RobotId, name: str, pieces: AsyncGenerator[bytes], digest: bytes
    ) -> bool:
        """Put a file there, whole; False when there is one of that name."""
        ...

    async def names(self, robot: RobotId, most: int) -> tuple[tuple[str, int, int], ...]:
        """Return name, size and time (ns) of what there is, the newest first."""
        ...

    def read(self, robot: RobotId, name: str) -> AsyncGenerator[bytes]:
        """Yield a file's content, piece by piece."""
        ...
