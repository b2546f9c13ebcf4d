"""What could come next in a line: names, skills, values, units. Pure, and small enough to read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.messages import label, parameter_hint, spoken

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.core.language.command import Command
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Parameter, Skill

STOP: Final = "stop"


class Completion(NamedTuple):
    """One way to go on.

    Attributes:
        text: What to put in place of the last ``replaces`` characters.
        meta: What it is, in a few words.
    """

    text: str
    replaces: int
    meta: str


class Completer:
    """Knows the fleet. Replaced when profiles change."""

    def __init__(self, profiles: Iterable[Profile] = (), commands: Iterable[Command] = ()) -> None:
        offered = [command for command in commands if command.hint]
        self._commands = {command.name: command.hint for command in offered}
        self._naming = {command.name for command in offered if command.of_robots}
        self._robots = {profile.id: profile for profile in profiles}
        groups: dict[str, list[Profile]] = {}
        for profile in self._robots.values():
            for group in profile.groups:
                groups.setdefault(group, []).append(profile)
        self._members = {name: [profile] for name, profile in self._robots.items()} | groups

    def complete(self, text: str) -> tuple[Completion, ...]:
        """Return what could come next after the text before the cursor."""
        line = text.lstrip().removeprefix("/")
        first, blank, rest = line.partition(" ")
        name = first.casefold()
        if not blank:
            return tuple(self._firsts(first))
        if name in self._naming:
            return tuple(self._names(rest.rpartition(" ")[2]))
        if name in self._members:
            stop = self._commands.get(STOP, "")
            return tuple(_after_name(self._members[name], rest.lstrip(), stop))
        return ()

    def _firsts(self, begun: str) -> Iterator[Completion]:
        yield from self._names(begun)
        for verb, meta in self._commands.items():
            if verb.startswith(begun.casefold()):
                yield Completion(verb, len(begun), meta)

    def _names(self, begun: str) -> Iterator[Completion]:
        for name, members in self._members.items():
            if name.startswith(begun.casefold()):
                group = name not in self._robots
                meta = ", ".join(m.id for m in members) if group else members[0].shown
                yield Completion(name, len(begun), "" if meta == name else meta)


def _after_name(members: Sequence[Profile], rest: str, stop: str) -> Iterator[Completion]:
    skills = {skill.id: skill for profile in members for skill in profile.skills.values()}
    begun = rest.casefold()
    for skill in skills.values():
        if begun.startswith(f"{spoken(skill)} "):
            yield from _after_skill(skill, rest[len(spoken(skill)) + 1 :])
            return
    for skill in skills.values():
        if spoken(skill).startswith(begun):
            yield Completion(spoken(skill), len(rest), label(skill))
    if STOP.startswith(begun):
        yield Completion(STOP, len(rest), stop)


def _after_skill(skill: Skill, rest: str) -> Iterator[Completion]:
    said, _, begun = rest.rpartition(" ")
    words = said.split()
    previous = words[-1].rpartition("=")[2] if words else ""
    if _is_number(previous):
        for parameter in skill.parameters.values():
            if parameter.unit and parameter.unit.startswith(begun):
                yield Completion(parameter.unit, len(begun), parameter.title.lower())
    named = {word.partition("=")[0] for word in words}
    for name, parameter in skill.parameters.items():
        if name not in named and named.isdisjoint(parameter.choices or ()):
            yield from _values(name, parameter, begun)


def _values(name: str, parameter: Parameter, begun: str) -> Iterator[Completion]:
    if parameter.choices is not None:
        for choice in parameter.choices:
            if choice.startswith(begun):
                yield Completion(choice, len(begun), parameter.title.lower())
    elif not parameter.text and f"{name}=".startswith(begun):
        yield Completion(f"{name}=", len(begun), parameter_hint("", parameter).strip())


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True
