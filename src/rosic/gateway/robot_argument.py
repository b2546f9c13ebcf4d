"""Which robot somebody means, in a line that is not an order."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.core.i18n import said
from rosic.core.language.compiled import fold
from rosic.core.language.keywords import BEFORE_NAMES, FILLERS
from rosic.core.language.syntax_errors import SyntaxErrorBuilder
from rosic.core.messages import NOTHING_VISIBLE
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.language import VocabularyHolder
    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext

MOST_WORDS = 64
# Of a place like the demonstration none is left out; a page of buttons is enough all the same.
MOST_ROBOTS = 8
ANY = "any"
"""Said before the name of a group, of which one robot is enough."""


class RobotArgumentQueries(Protocol):
    """What other rooms say of who asks: the robots they may see, and the one they chose."""

    @property
    def visible(self) -> Callable[[PrincipalId], frozenset[RobotId]]:
        """Return the robots that somebody may see."""

    @property
    def selected(self) -> Callable[[PrincipalId, Chat], str]:
        """Return the robot or group that somebody chose in a chat; empty for none."""


class RobotArgumentContext(Protocol):
    """What names are found with."""

    @property
    def vocabularies(self) -> VocabularyHolder:
        """Return what holds who is called what."""

    @property
    def sides(self) -> RobotArgumentQueries:
        """Return what other rooms say."""


class RoomQueries(NamedTuple):
    """What the rooms say of who asks."""

    visible: Callable[[PrincipalId], frozenset[RobotId]]
    selected: Callable[[PrincipalId, Chat], str]


class RobotArgumentParts(NamedTuple):
    """What names are found with, as the rooms know it."""

    vocabularies: VocabularyHolder
    sides: RoomQueries


class RobotArgument:
    """Finds the robot at the beginning of what was said after a verb.

    Robots that the person may not see are as unknown as those that do not exist.
    """

    def __init__(self, parts: RobotArgumentContext) -> None:
        self._vocabularies = parts.vocabularies
        self._sides = parts.sides

    def robot(
        self, asked: CommandContext, verb: str, text: str, *, nameless: bool = False
    ) -> tuple[RobotId, str]:
        """Return the robot that is meant, and what was said after its name.

        Without a name it is the one that was chosen in this chat, or the only visible one.

        Args:
            asked: By whom, where.
            verb: For what is offered instead: what stands before the name.
            text: What was said after the verb.
            nameless: The text makes sense as it is, so that its first word is no misspelt name.

        Raises:
            NotUnderstood: No such robot, several, or none was named.
            OutOfBounds: More words than any line has.
            NotPermitted: The person sees no robot at all.
        """
        visible = self._sides.visible(asked.caller.principal)
        if not visible:
            raise NotPermitted(NOTHING_VISIBLE)
        raw = _split(text)
        low = [fold(word) for word in raw]
        called = self._vocabularies.current.longest_callee
        skipped = (word in FILLERS or (word in BEFORE_NAMES and word not in called) for word in low)
        begin = next((i for i, skips in enumerate(skipped) if not skips), len(low))
        name, robots, end = self._named(low, begin, visible)
        rest = " ".join(raw[end:])
        if len(robots) == 1:
            return robots[0], rest
        if robots:
            raise NotUnderstood(which_of(name), offers=_offers(verb, robots, rest))
        if begin < len(low) and not nameless:
            heard = ([verb, *raw], [verb, *low])
            # What comes after the name is read by the verb.
            trouble = SyntaxErrorBuilder(heard, self._vocabularies.current, visible, lambda _: True)
            wrong = trouble.no_such_robot(begin + 1)
            raise NotUnderstood(wrong.sentence, offers=wrong.offers)
        return self._unnamed(asked, verb, visible, text), text

    def robots(
        self, asked: CommandContext, verb: str, text: str
    ) -> tuple[tuple[RobotId, ...], str]:
        """Return the robots of which any one is meant, and what was said after the name.

        Raises:
            NotUnderstood, NotPermitted: As `robot`.
        """
        raw = _split(text)
        begin = 1 if raw and fold(raw[0]) == ANY else 0
        if begin and len(raw) > 1 and fold(raw[1]) in FILLERS:
            begin += 1
        low = [fold(word) for word in raw]
        _, robots, end = self._named(low, begin, self._sides.visible(asked.caller.principal))
        if robots:
            return robots, " ".join(raw[end:])
        robot, rest = self.robot(asked, verb, " ".join(raw[begin:]))
        return (robot,), rest

    def robot_or_group(self, asked: CommandContext, verb: str, text: str) -> tuple[str, str]:
        """Return the robot or the whole group that is meant, and what was said after its name.

        A group of which the person does not see everybody is none for them.

        Raises:
            NotUnderstood, NotPermitted: As `robot`.
        """
        low = [fold(word) for word in _split(text)]
        name, robots, end = self._named(low, 0, self._sides.visible(asked.caller.principal))
        if len(robots) > 1 and robots == self._vocabularies.current.members(name):
            return name, " ".join(text.split()[end:])
        return self.robot(asked, verb, text)

    def calls(self, asked: CommandContext, text: str) -> bool:
        """Whether a text is the name of a robot that the person sees, and nothing else."""
        low = [fold(word) for word in _split(text)]
        visible = self._sides.visible(asked.caller.principal)
        _, robots, end = self._named(low, 0, visible)
        return bool(robots) and end == len(low)

    def at_head(self, asked: CommandContext, text: str) -> tuple[tuple[RobotId, ...], str, str]:
        """Return the visible robots that a text begins with, their name, and what follows it."""
        raw = _split(text)
        visible = self._sides.visible(asked.caller.principal)
        name, robots, end = self._named([fold(word) for word in raw], 0, visible)
        return robots, name, " ".join(raw[end:])

    def _named(
        self, low: list[str], at: int, visible: frozenset[RobotId]
    ) -> tuple[str, tuple[RobotId, ...], int]:
        """Return the longest name here, whom of the visible it calls, and where it ends."""
        most = self._vocabularies.current.longest_callee.get(low[at], 0) if at < len(low) else 0
        for count in range(most, 0, -1):
            callee = self._vocabularies.current.callees.get(" ".join(low[at : at + count]))
            if callee is not None:
                seen = tuple(robot.id for robot in callee.robots if robot.id in visible)
                if seen:
                    return callee.name, seen, at + count
        return "", (), at

    def _unnamed(
        self, asked: CommandContext, verb: str, visible: frozenset[RobotId], text: str
    ) -> RobotId:
        chosen = self._sides.selected(asked.caller.principal, asked.inbound.chat)
        if chosen in visible:
            return chosen
        if len(visible) == 1:
            return next(iter(visible))
        raise NotUnderstood(which_robot(), offers=_offers(verb, tuple(sorted(visible)), text))


def _split(text: str) -> list[str]:
    """Return the words of a line: none of them is left out.

    Raises:
        OutOfBounds: They are too many.
    """
    found = text.split()
    if len(found) > MOST_WORDS:
        raise OutOfBounds(too_many_words(len(found), MOST_WORDS))
    return found


def _offers(verb: str, robots: tuple[RobotId, ...], rest: str) -> tuple[str, ...]:
    return tuple(f"{verb} {robot} {rest}".strip() for robot in robots[:MOST_ROBOTS])


# ---- sentences ----


def too_many_words(count: int, most: int) -> str:
    """Return that more was said than is read."""
    return said(
        "That line has {low} words; I read at most {most}. Nothing was done.", low=count, most=most
    )


def which_robot() -> str:
    """None was named."""
    return said("Which robot?")


def which_of(group: str) -> str:
    """A group was named where one robot is meant."""
    return said("{group} is several robots. Which one?", group=group)
