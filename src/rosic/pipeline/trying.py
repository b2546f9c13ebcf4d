"""A skill was tapped: say exactly what it will do, and ask; or offer the value that it lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language import Do, bind, show
from rosic.core.message import Button
from rosic.core.saying import joined, said
from rosic.errors import Refusal
from rosic.pipeline.desk import Reply, rows
from rosic.pipeline.replies import ASK_FIRST, CONFIRMED, LEAVE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.language import Reader
    from rosic.core.robot import RobotId
    from rosic.pipeline.rooms import Rooms

LEAVE_IT = Button("Leave it", LEAVE)


class Trying:
    """Turns a tap on a skill into a question. Moves nothing: whoever answers gives the order."""

    def __init__(self, rooms: Rooms, reader: Reader) -> None:
        self._organiser = rooms.organiser
        self._vocabulary = rooms.vocabulary
        self._reader = reader

    def ask(self, principal: PrincipalId, command: str) -> Reply:
        """Return the question before a tapped skill moves anything.

        Where a value is missing, choosing one is the answer: its button says all that will be
        done, and the tap goes the way of a typed command.
        """
        visible = self._organiser.visible(principal)
        line = self._line(command, visible)
        if line is None:  # the robot is out of their sight since
            return Reply(said("{command}?", command=command), _do_it(command))
        try:
            what = self._what(line)
        except Refusal as lacking:
            return self._choose(str(lacking), lacking.offers, visible)
        robot = self._vocabulary.profiles[line.robots[0]].shown
        return Reply(said("{robot}: {what}?", robot=robot, what=what), _do_it(command))

    def _line(self, command: str, visible: frozenset[RobotId]) -> Do | None:
        [line, *_] = self._reader.lines(command, "", visible)
        return line if isinstance(line, Do) else None

    def _what(self, line: Do) -> str:
        """Return what a line does, in words.

        Raises:
            Refusal: It lacks a value, with commands that would do.
        """
        robot, skill = line.robots[0], line.skills[0]
        arguments = bind(self._vocabulary, robot, skill, line.spoken)
        return show(self._vocabulary, robot, skill, arguments)

    def _choose(self, lacking: str, offers: Sequence[str], visible: frozenset[RobotId]) -> Reply:
        buttons = [self._value(offer, visible) for offer in offers]
        moves = any(not button.command.startswith(ASK_FIRST) for button in buttons)
        if moves:
            lacking = joined(" ", (lacking, said("It moves as soon as you tap.")))
        return Reply(lacking, (*rows(buttons), (LEAVE_IT,)))

    def _value(self, offer: str, visible: frozenset[RobotId]) -> Button:
        """Return an offer as a button; one that lacks still more is asked about in its turn."""
        line = self._line(offer, visible)
        if line is None:
            return Button(offer, offer)
        try:
            what = self._what(line)
        except Refusal:
            return Button(offer, f"{ASK_FIRST}{offer}")
        return Button(what.partition(", ")[2] or what, offer)


def _do_it(command: str) -> tuple[tuple[Button, ...], ...]:
    return ((Button("Do it", f"{CONFIRMED}{command}"), LEAVE_IT),)
