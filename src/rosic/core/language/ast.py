"""What one line of a message can mean."""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from rosic.core.order import SpokenValue
from rosic.core.robot.profile import RobotId
from rosic.core.robot.skill import Skill
from rosic.errors import NotUnderstood


class LineContext(msgspec.Struct, frozen=True):
    """What understanding depends on besides the text.

    Attributes:
        selected: The robot or group that this person chose in this chat; empty for none.
        visible: The robots this person may see. Any other robot is as unknown as one that does
            not exist.
        overheard: People talk to each other where it was written, and nobody addressed ROSIC: what
            is no line of the grammar is talk.
    """

    selected: str
    visible: frozenset[RobotId]
    overheard: bool = False


class Do(msgspec.Struct, frozen=True, kw_only=True):
    """Let one robot, or the members of a group, do something.

    Attributes:
        robots: At least one; for a group, its visible members that have the skill.
        skills: The skill of each robot, in the same order.
        spoken: Values as said; `bind` makes arguments of them, robot by robot.
        text: The line as typed, without characters that cannot be seen.
        group: The group's name; empty for one robot.
        named: The line itself names the robot or the group: it is not merely what is chosen in that
            chat, or the only one that can do it.
        speech: It means nothing else, so it is taken for words to a robot that one talks to.
    """

    robots: tuple[RobotId, ...]
    skills: tuple[Skill, ...]
    spoken: tuple[SpokenValue, ...]
    text: str
    group: str = ""
    named: bool = False
    speech: bool = False

    @property
    def name(self) -> str:
        """Whom it is for: a group's name, or a robot's id."""
        return self.group or self.robots[0]


class Status(msgspec.Struct, frozen=True):
    """How are they? No robots means: all the person may see."""

    robots: tuple[RobotId, ...] = ()


class Help(msgspec.Struct, frozen=True):
    """What can be said? A robot's or a group's name alone asks this of it.

    Attributes:
        topic: A robot's id, a group's name, one of `keywords.HELP_PAGES`, or empty.
    """

    topic: str = ""


class Robots(msgspec.Struct, frozen=True):
    """Which robots are there?"""


class Use(msgspec.Struct, frozen=True):
    """From now on this robot or group is meant when none is named.

    Attributes:
        name: A robot's id or a group's name; empty undoes the choice.
    """

    name: str = ""


class Resume(msgspec.Struct, frozen=True):
    """Undo a stop.

    Attributes:
        robots: Empty when none was named and none is selected: the one that is stopped, if it is
            only one; else the person has to say which.
        named: The line names them: they are not merely what is chosen in that chat, or all.
        spared: Those that it leaves out by their names: ``all but omni``.
    """

    robots: tuple[RobotId, ...] = ()
    named: bool = False
    spared: tuple[RobotId, ...] = ()


class Start(msgspec.Struct, frozen=True):
    """The first word to a bot, perhaps with the payload of an invitation."""

    payload: str = ""


class CommandLine(msgspec.Struct, frozen=True):
    """Something asked of ROSIC itself: who am I, book a robot, invite somebody.

    Attributes:
        verb: One of ``keywords.COMMANDS``.
        rest: The line after it, as typed.
    """

    verb: str
    rest: str


class Halt(msgspec.Struct, frozen=True):
    """A stop among other lines. `hears_stop` found it in the whole text before: it is obeyed.

    Attributes:
        names: As `hears_stop` returns them.
    """

    names: tuple[str, ...] = ()


class Cancel(msgspec.Struct, frozen=True):
    """Somebody ends what they have under way themselves; nothing is latched.

    Attributes:
        names: As `hears_cancel` returns them.
    """

    names: tuple[str, ...] = ()


class Misunderstood(msgspec.Struct, frozen=True):
    """The line says nothing that can be done.

    Attributes:
        sentence: What to tell.
        offers: Commands that would be understood instead.
    """

    sentence: str
    offers: tuple[str, ...] = ()
    code: str = NotUnderstood.code

    @property
    def about_stop(self) -> bool:
        """Whether a stop may have been meant, so that it is answered whoever was spoken to."""
        return "stop" in self.offers


class Proposed(Misunderstood, frozen=True, kw_only=True):
    """The line leaves something out, or is vague: its offers are what may be meant, best first.

    Attributes:
        follows: What it says of what was asked before it: ``again``, ``faster``; empty: nothing.
        doubtful: Some of its words mean nothing, or have no place in what is offered.
    """

    follows: tuple[str, ...] = ()
    doubtful: bool = False


class Answered(msgspec.Struct, frozen=True):
    """What people say to each other, and to a bot.

    Attributes:
        what: ``hello``, ``bye``, ``thanks``, ``never_mind`` or ``self``: who it is.
    """

    what: str


Line: TypeAlias = (
    Do
    | Halt
    | Status
    | Help
    | Robots
    | Use
    | Resume
    | Start
    | CommandLine
    | Answered
    | Misunderstood
)
