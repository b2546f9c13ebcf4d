"""``help``: a menu of what one person can ask for here, with examples they may send as they are."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core import messages
from rosic.core.i18n import figure, joined, said
from rosic.core.language.command import HelpNeed, HelpPage
from rosic.core.language.common_names import shown_command, shown_name
from rosic.core.language.formatting import beginning
from rosic.core.message import Button
from rosic.core.policy.scope import FLEET, GRANT, RESUME
from rosic.core.robot.profile import Slots
from rosic.core.robot.view import ViewKind
from rosic.core.units import measured

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.language.command import Command
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Parameter, Skill
    from rosic.gateway.commands import CommandRegistry
    from rosic.gateway.components import Components


EXAMPLES: Final = 3
ANY: Final = (-inf, inf)
NAMED: Final = "{shown}"
"""Stands for a robot's name while two are compared."""
SEVERAL: Final = 2
MOVE: Final = said("Move")
SEE: Final = said("See")
SHARE: Final = said("Share")
FLEET_TITLE: Final = said("Fleet")
ALARMS: Final = said("Alarms")
TITLES: Final = {
    HelpPage.MOVE: MOVE,
    HelpPage.SEE: SEE,
    HelpPage.SHARE: SHARE,
    HelpPage.FLEET: FLEET_TITLE,
    HelpPage.ALARMS: ALARMS,
}

MORE: Final = said(
    "More of each, by its button or by: help move, help see, help share, help fleet, help alarms."
)

_LOOKS: Final[Mapping[HelpNeed, Callable[[Profile], bool]]] = {
    HelpNeed.PICTURE: lambda profile: profile.offers(ViewKind.PICTURE),
    HelpNeed.MAP: lambda profile: profile.offers(ViewKind.MAP),
    HelpNeed.POSE: lambda profile: profile.pose is not None,
    HelpNeed.TELEMETRY: lambda profile: bool(profile.telemetry),
}


class HelpMenu:
    """Says what can be said, and nothing that this person could not use.

    Args:
        rooms: Who may what, and which robots there are.
        commands: Which are offered now.
    """

    def __init__(self, rooms: Components, commands: CommandRegistry) -> None:
        self._commands = commands
        self._organiser = rooms.organiser
        self._profiles = rooms.profiles
        self._vocabularies = rooms.vocabularies
        self._pages = {page: rooms.vocabulary.commands.on_page(page) for page in HelpPage}

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
            Button(TITLES[page], f"help {page}")
            for page in HelpPage
            if any(True for _ in self._lines(page, principal, visible))
        ]
        if buttons:
            lines.append(MORE)
        return joined("\n", lines), buttons

    def section(self, name: str, principal: PrincipalId, visible: frozenset[RobotId]) -> str:
        """Return one page; empty if there is none of that name."""
        if name not in TITLES:
            return ""
        page = HelpPage(name)
        lines = list(self._lines(page, principal, visible))
        lines = lines or [said("There is nothing of that for you yet.")]
        return joined("\n", (joined("", (TITLES[page], ":")), *lines))

    def _lines(
        self, page: HelpPage, principal: PrincipalId, visible: frozenset[RobotId]
    ) -> Iterator[str]:
        """Yield a page: examples, and every command that this person can use."""
        if page is HelpPage.FLEET and len(visible) < SEVERAL:
            return
        examples = self.examples(principal, visible) if page is HelpPage.MOVE else []
        yield from (joined("", ("  ", example)) for example in examples)
        for command in self._pages[page]:
            if not self._commands.is_offered(command.name):
                continue
            assert command.help is not None  # noqa: S101 - it stands on a page
            yield from self._line(command, command.help.needs, principal, visible, examples)

    def _line(
        self,
        command: Command,
        needs: HelpNeed | str,
        principal: PrincipalId,
        visible: frozenset[RobotId],
        examples: Sequence[str],
    ) -> Iterator[str]:
        """Yield the line of a command if this person can use it, and what is shown before it."""
        robot = ""
        if needs in _LOOKS:
            looks = _LOOKS[HelpNeed(needs)]
            robot = next((name for name in sorted(visible) if looks(self._profiles[name])), "")
            if not robot:
                return
        elif needs is HelpNeed.TOGETHER:
            example = self._together(principal, visible)
            if not example:
                return
            yield joined("", ("  ", example))
        elif not self._can(needs, principal, visible, examples):
            return
        typed = joined(" ", filter(None, (command.typed, robot)))
        yield joined("", ("  ", typed, " · ", command.summary))

    def _can(
        self,
        needs: HelpNeed | str,
        principal: PrincipalId,
        visible: frozenset[RobotId],
        examples: Sequence[str],
    ) -> bool:
        organiser = self._organiser
        match needs:
            case HelpNeed.NOTHING:
                return True
            case HelpNeed.MOTION:
                return bool(examples)
            case HelpNeed.RESUME:
                return any(organiser.allows(principal, robot, RESUME) for robot in visible)
            case HelpNeed.BOOKING:
                booked = (r for r in visible if self._profiles[r].slots is not Slots.NONE)
                return any(organiser.why_not_move(principal, robot) is None for robot in booked)
            case HelpNeed.GRANT:
                return any(organiser.allows(principal, robot, GRANT) for robot in (FLEET, *visible))
        return organiser.allows(principal, FLEET, needs)

    # ---- one robot ----

    def of_robots(self, principal: PrincipalId, profiles: Iterable[Profile]) -> str:
        """Return what robots can do for this person, and how far; those that are alike together."""
        told: dict[Hashable, tuple[str, Profile]] = {}
        kinds: dict[str, tuple[Profile, list[Profile]]] = {}
        for profile in profiles:
            made_of = self._made_of(principal, profile)
            if made_of not in told:
                theirs = self._theirs(principal, profile)
                told[made_of] = messages.help_for(theirs, NAMED), theirs
            text, theirs = told[made_of]
            kinds.setdefault(text, (theirs, []))[1].append(profile)
        return joined("\n", (_help_for(*kind) for kind in kinds.values()))

    def _made_of(self, principal: PrincipalId, profile: Profile) -> Hashable:
        """Return what the help on a robot is made of: to make it of each robot takes long."""
        rights, now_ns = self._organiser.rights, self._organiser.wall_ns()
        compiled, robot = self._vocabularies.current.compiled_skill, profile.id
        return tuple(
            (_skill_made_of(skill), *widest.items())
            for skill in profile.skills.values()
            if (widest := rights.widest(principal, robot, skill.id, now_ns)) is not None
            and compiled(robot, skill.id) is not None
        )

    def _theirs(self, principal: PrincipalId, profile: Profile) -> Profile:
        """Return a profile with what this person may let its robot do, within their limits."""
        skills: dict[str, Skill] = {}
        for skill in profile.skills.values():
            widest = self._widest(principal, profile.id, skill.id)
            compiled = self._vocabularies.current.compiled_skill(profile.id, skill.id)
            if widest is None or compiled is None:
                continue
            of_theirs = {
                name: _narrowed(parameter, compiled.by_name[name], *widest[name])
                if name in widest
                else parameter
                for name, parameter in skill.parameters.items()
            }
            skills[skill.id] = replace(skill, parameters=of_theirs)
        return replace(profile, skills=skills)

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
                values = list(_values(compiled, self._bounds(principal, skill.id, robots)))
                if None not in values:
                    command = shown_command(skill.id, compiled.spoken, skill.titles)
                    return joined(" ", (name, command, *filter(None, values)))
        return ""

    def _widest(
        self, principal: PrincipalId, robot: RobotId, skill: str
    ) -> dict[str, tuple[float, float]] | None:
        organiser = self._organiser
        return organiser.rights.widest(principal, robot, skill, organiser.wall_ns())

    def _bounds(
        self, principal: PrincipalId, skill: str, robots: Iterable[RobotId]
    ) -> dict[str, tuple[float, float]]:
        """Return how far somebody may go with a skill of every one of some robots, SI."""
        found: dict[str, tuple[float, float]] = {}
        for robot in robots:
            for name, (low, high) in (self._widest(principal, robot, skill) or {}).items():
                before = found.get(name, (low, high))
                found[name] = (max(low, before[0]), min(high, before[1]))
        return found

    def _of(self, robots: Iterable[RobotId]) -> Iterator[Profile]:
        return (self._profiles[robot] for robot in robots)


def _narrowed(
    parameter: Parameter, compiled: CompiledParameter, least: float, most: float
) -> Parameter:
    """Return a parameter with its bounds within two others, SI; those have some slack."""
    within = max(least, compiled.low), min(most, compiled.high)
    low, high = (float(f"{compiled.unit.from_si(bound):.8g}") for bound in within)
    usual = parameter.default
    if isinstance(usual, int | float):
        usual = min(max(usual, low), high)
    return replace(parameter, min=low, max=high, default=usual)


def _skill_made_of(skill: Skill) -> Hashable:
    """Return what the help on a skill is made of, but for the rights of its reader."""
    return (
        skill.id,
        *skill.titles.items(),
        *[
            (name, of.unit, of.min, of.max, of.text, of.default, *(of.choices or ()))
            for name, of in skill.parameters.items()
        ],
    )


def _help_for(theirs: Profile, kind: Iterable[Profile]) -> str:
    """Return what robots of one kind can do for somebody, from what one of them may."""
    shown = ", ".join(profile.shown for profile in kind)
    if not theirs.skills:
        return said("You may look at {shown}. What you lack, ask for: /ask", shown=shown)
    return messages.help_for(theirs, shown)


def _shared(skill: str) -> Callable[[Profile], bool]:
    return lambda profile: skill in profile.skills


def _values(
    compiled: CompiledSkill, bounds: Mapping[str, tuple[float, float]]
) -> Iterator[str | None]:
    """Yield what has to be said beside a skill; None where only a person can know."""
    wanted = [p for p in compiled.parameters if p.default is None]
    numbers = sum(p.is_number for p in wanted)
    for parameter in wanted:
        yield _value(parameter, bounds.get(parameter.name, ANY), named=numbers > 1)


def _value(parameter: CompiledParameter, bounds: tuple[float, float], *, named: bool) -> str | None:
    value = beginning(parameter)
    if value is None or not parameter.is_number:
        return None if value is None else shown_name(str(value))
    number = parameter.unit.from_si(min(max(float(value), bounds[0]), bounds[1]))
    text, symbol = f"{number:.4g}", parameter.unit.symbol
    if named:
        return joined("=", (parameter.shown, figure(text)))
    return measured(f"{text} {symbol}".rstrip(), number, symbol)
