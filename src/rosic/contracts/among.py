"""What robots that speak with each other owe to ROSIC, and whoever keeps their tasks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias, runtime_checkable

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId

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
