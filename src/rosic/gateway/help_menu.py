"""``help``: a menu of what one person can ask for here, with examples they may send as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core import messages
from rosic.core.i18n import figure, joined, said
from rosic.core.language.common_names import shown_command, shown_name
from rosic.core.language.formatting import beginning
from rosic.core.message import Button
from rosic.core.policy.scope import FLEET, GRANT, RESUME
from rosic.core.robot.profile import Slots
from rosic.core.robot.view import ViewKind
from rosic.core.units import measured
from rosic.gateway.command_menus import ADMINS, EVERYBODY
from rosic.gateway.command_words import TYPED

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.core.identity import PrincipalId
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.components import Components

    Lines: TypeAlias = Iterable[str]
    Section: TypeAlias = Callable[[PrincipalId, frozenset[RobotId]], Lines]

EXAMPLES: Final = 3
SEVERAL: Final = 2
MOVE: Final = said("Move")
SEE: Final = said("See")
SHARE: Final = said("Share")
FLEET_TITLE: Final = said("Fleet")
ALARMS: Final = said("Alarms")
TITLES: Final = {"move": MOVE, "see": SEE, "share": SHARE, "fleet": FLEET_TITLE, "alarms": ALARMS}

MORE: Final = said(
    "More of each, by its button or by: help move, help see, help share, help fleet, help alarms."
)

_SAID: Final = {
    **dict(EVERYBODY),
    **dict(ADMINS),
    "picture": said("What its camera shows now"),
    "map": said("Where it is on its map"),
    "chart": said("A value over time"),
    "trajectory": said("The way it has gone"),
    "card": said("A message that always shows how robots are"),
    "history": said("What you asked for, and what came of it"),
    "slots": said("Which times are whose"),
    "wait": said("Get a robot when it is free"),
    "cancel booking": said("Give a time back"),
    "handover": said("Pass a robot on to somebody"),
    "mission": said("Several tasks, one after another, also every week"),
    "tasks": said("What is being worked on, and what waits"),
    "together": said("Let several robots begin at the same moment"),
    "alerts": said("What is wrong now, and what was"),
    "mute": said("Hear nothing of an alarm for a while"),
    "settings": said("Your language, units, and how you hear of things"),
    "files": said("Files for robots and of robots"),
    "mydata": said("What is kept of you"),
}


# By the right about the place that each needs.
_ABOUT_PEOPLE: Final = {
    "invite": ("invite",),
    "people": ("people", "revoke", "security"),
    "lock": ("lock",),
}


class HelpMenu:
    """Says what can be said, and nothing that this person could not use.

    Args:
        rooms: Who may what, and which robots there are.
    """

    def __init__(self, rooms: Components) -> None:
        self._organiser = rooms.organiser
        self._profiles = rooms.profiles
        self._vocabularies = rooms.vocabularies
        self._sections: dict[str, Section] = {
            "move": self._move,
            "see": self._see,
            "share": self._share,
            "fleet": self._fleet,
            "alarms": self._alarms,
        }

    def overview(
        self, principal: PrincipalId, visible: frozenset[RobotId]
    ) -> tuple[str, list[Button]]:
        """Return the first page, and a button for each section that has something to say."""
        examples = self.examples(principal, visible)
        lines = [
            messages.help_for_all(examples) if examples else messages.HELP_LOOK,
            messages.HELP_STOP,
        ]
        buttons = [
            Button(TITLES[name], f"help {name}")
            for name, section in self._sections.items()
            if any(True for _ in section(principal, visible))
        ]
        if buttons:
            lines.append(MORE)
        return joined("\n", lines), buttons

    def section(self, name: str, principal: PrincipalId, visible: frozenset[RobotId]) -> str:
        """Return one section; empty if there is none of that name."""
        section = self._sections.get(name)
        if section is None:
            return ""
        lines = list(section(principal, visible)) or [said("There is nothing of that for you yet.")]
        return joined("\n", (joined("", (TITLES[name], ":")), *lines))

    # ---- sections ----

    def _move(self, principal: PrincipalId, visible: frozenset[RobotId]) -> Lines:
        examples = self.examples(principal, visible)
        yield from (joined("", ("  ", example)) for example in examples)
        if examples:
            yield from _commands("again", "use", "undo")
        yield _line("stop")
        if examples:
            yield _line("cancel")
        if any(self._organiser.allows(principal, robot, RESUME) for robot in visible):
            yield _line("resume")

    def _see(self, _: PrincipalId, visible: frozenset[RobotId]) -> Lines:
        yield from _commands("robots", "status", "card", "history")
        shown = [self._profiles[robot] for robot in sorted(visible)]
        for verb, offered in (
            ("picture", lambda p: p.offers(ViewKind.PICTURE)),
            ("map", lambda p: p.offers(ViewKind.MAP)),
            ("trajectory", lambda p: p.pose is not None),
            ("chart", lambda p: bool(p.telemetry)),
        ):
            robot = next((profile for profile in shown if offered(profile)), None)
            if robot is not None:
                yield _line(verb, robot.id)

    def _share(self, principal: PrincipalId, visible: frozenset[RobotId]) -> Lines:
        organiser = self._organiser
        booked = (r for r in visible if self._profiles[r].slots is not Slots.NONE)
        if any(organiser.why_not_move(principal, robot) is None for robot in booked):
            yield from _commands("slots", "book", "wish", "wait", "cancel booking", "handover")
        yield from _commands("me", "ask", "settings", "files", "mydata")
        if any(organiser.allows(principal, robot, GRANT) for robot in (FLEET, *visible)):
            yield from _commands("role", "grant")
        for verb, names in _ABOUT_PEOPLE.items():
            if organiser.allows(principal, FLEET, verb):
                yield from _commands(*names)
        if organiser.allows(principal, FLEET, "slots"):
            yield from _commands("plan")

    def _fleet(self, principal: PrincipalId, visible: frozenset[RobotId]) -> Lines:
        if len(visible) < SEVERAL:
            return
        yield from _commands("fleet")
        example = self._together(principal, visible)
        if example:
            yield joined("", ("  ", example))
            yield from _commands("together")
        if self._organiser.allows(principal, FLEET, "assign"):
            yield from _commands("task", "tasks", "mission")

    def _alarms(self, _: PrincipalId, __: frozenset[RobotId]) -> Lines:
        yield from _commands("alerts", "mute")

    # ---- examples ----

    def examples(self, principal: PrincipalId, visible: Iterable[RobotId]) -> list[str]:
        """Return some commands that this person may send as they are, of different robots."""
        found: list[str] = []
        known: set[frozenset[str]] = set()
        for robot in sorted(visible):
            kind = frozenset(self._profiles[robot].skills)
            example = "" if kind in known else self._example(robot, principal, robot)
            if example:
                known.add(kind)
                found.append(example)
            if len(found) == EXAMPLES:
                break
        return found

    def _together(self, principal: PrincipalId, visible: frozenset[RobotId]) -> str:
        """Return an order to the first group all of whose robots somebody may move."""
        for group in sorted({group for r in visible for group in self._profiles[r].groups}):
            members = self._vocabularies.current.members(group)
            if len(members) >= SEVERAL and visible.issuperset(members):
                example = self._example(group, principal, *members)
                if example:
                    return example
        return ""

    def _example(self, name: str, principal: PrincipalId, *robots: RobotId) -> str:
        for skill in self._profiles[robots[0]].skills.values():
            compiled = self._vocabularies.current.compiled_skill(robots[0], skill.id)
            every = all(self._organiser.allows(principal, robot, skill.id) for robot in robots)
            if every and compiled is not None and all(map(_shared(skill.id), self._of(robots))):
                values = list(_values(compiled))
                if None not in values:
                    command = shown_command(skill.id, compiled.spoken, skill.titles)
                    return joined(" ", (name, command, *filter(None, values)))
        return ""

    def _of(self, robots: Iterable[RobotId]) -> Iterator[Profile]:
        return (self._profiles[robot] for robot in robots)


def _shared(skill: str) -> Callable[[Profile], bool]:
    return lambda profile: skill in profile.skills


def _values(compiled: CompiledSkill) -> Iterator[str | None]:
    """Yield what has to be said beside a skill; None where only a person can know."""
    wanted = [p for p in compiled.parameters if p.default is None]
    numbers = sum(p.is_number for p in wanted)
    for parameter in wanted:
        yield _value(parameter, named=numbers > 1)


def _value(parameter: CompiledParameter, *, named: bool) -> str | None:
    value = beginning(parameter)
    if value is None or not parameter.is_number:
        return None if value is None else shown_name(str(value))
    number = parameter.unit.from_si(float(value))
    text, symbol = f"{number:.4g}", parameter.unit.symbol
    if named:
        return joined("=", (parameter.shown, figure(text)))
    return measured(f"{text} {symbol}".rstrip(), number, symbol)


def _commands(*names: str) -> Iterator[str]:
    return map(_line, names)


def _line(name: str, robot: str = "") -> str:
    typed = joined(" ", filter(None, (TYPED[name], robot)))
    return joined("", ("  ", typed, " · ", _SAID[name]))
