"""What whoever draws owes to ROSIC."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.robot.view import Drawing, Subject


class Renderer(Protocol):
    """Makes pictures out of what was seen. Called on a thread of its own: it may take a second."""

    def __call__(
        self, subject: Subject, *, low: bool = False, say: Callable[[str], str] = str
    ) -> Drawing:
        """Draw.

        Args:
            subject: What; from a robot, so anything may be wrong with it.
            low: Smaller and coarser, for a bad network.
            say: Returns a sentence as whoever will look reads it.

        Returns:
            At most 4 MB, at most 1,280 pixels a side.

        Raises:
            NothingToSee: It is too large, or no picture at all; the sentence says which.
        """
        ...
