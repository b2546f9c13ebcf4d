"""``rosic check``: a configuration looked at as a start would, and nothing started."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.api.settings_checks import check_served
from rosic.app.admin.control_socket import socket_path
from rosic.app.builder import messenger_of, nobodies
from rosic.app.config import Config, read_config
from rosic.config.lexicons import known_phrases
from rosic.config.plugins import check_robot, robot_factory, shared_spaces
from rosic.config.profiles import known_units
from rosic.config.secrets import open_to_others
from rosic.contracts.chats import messenger_assurance
from rosic.contracts.verification import VerifiesDevices
from rosic.core.identity import ROBOT
from rosic.core.language import Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions, fleet_of
from rosic.core.policy.roles import ASSURANCES, Assurance, Grant
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.clock import Clock


class CheckResult(NamedTuple):
    """What a look at a configuration brought.

    Attributes:
        errors: Everything that is wrong, as far as it can be told.
        advice: What is allowed, but worse than it could be.
        summary: What is in it; empty when anything is wrong.
    """

    errors: list[ConfigurationError]
    advice: list[ConfigurationError]
    summary: str


def check_all(path: Path | str, clock: Clock) -> CheckResult:
    """Look at everything that a start would look at. Opens no connection, writes nothing."""
    read = read_config(path)
    if read.config is None:
        return CheckResult(read.errors, read.advice, "")
    errors = list(_errors(read.config, clock))
    advice = read.advice + _advice(read.config) + list(_unmet(read.config, clock))
    return CheckResult(errors, advice, "" if errors else _told(read.config))


def _errors(config: Config, clock: Clock) -> list[ConfigurationError]:
    errors: list[ConfigurationError] = []
    for table in config.messengers:
        try:
            errors += nobodies(config, messenger_of(table, clock))
        except ConfigurationError as wrong:
            errors.append(wrong)
    factories: dict[str, RobotFactory] = {}
    for kind in dict.fromkeys(profile.link.kind for profile in config.robots):
        try:
            factories[kind] = robot_factory(kind)
        except ConfigurationError as wrong:
            errors.append(ConfigurationError(str(wrong), where=str(config.path)))
    errors += [
        ConfigurationError(fault.sentence, where=str(config.path), hint=fault.hint)
        for profile in config.robots
        if profile.link.kind in factories
        for fault in check_robot(profile, factories[profile.link.kind], clock)
    ]
    errors += [open_.error for open_ in open_to_others(config.files) if open_.everybody]
    try:
        Vocabulary.build(config.robots, known_units(), NO_COMMANDS, known_phrases())
    except ValueError as wrong:
        errors.append(ConfigurationError(f"{wrong}.", where=str(config.path)))
    errors += _wrong_with_api(config)
    try:
        socket_path(config.data)
    except ConfigurationError as wrong:
        errors.append(ConfigurationError(str(wrong), where=str(config.path)))
    return errors


def _wrong_with_api(config: Config) -> Iterator[ConfigurationError]:
    if config.api is None:
        return
    try:
        check_served(config.api, {profile.id: profile for profile in config.robots})
    except ConfigurationError as wrong:
        yield wrong


def _advice(config: Config) -> list[ConfigurationError]:
    """Say which robots nobody may move, and who could never write."""
    where = str(config.path)
    others = [open_.error for open_ in open_to_others(config.files) if not open_.everybody]
    people = {p.name: tuple(Grant(role=role) for role in p.roles) for p in config.people}
    fleet = fleet_of(config.robots)
    rights = Permissions.draw_up(0, config.rulebook, fleet, people, unit_converter(known_units()))
    unmoved = [
        f"Nobody of this file may move {profile.shown}."
        for profile in config.robots
        if people  # otherwise the first start shows a code that makes an admin
        and not any(
            rights.holds(p, profile.id, skill, 0) for p in people for skill in profile.skills
        )
    ]
    said = [
        ConfigurationError(text, where=where)
        for text in (*unmoved, *_unheard(config), *shared_spaces(config.robots))
    ]
    return [*others, *said]


def _unheard(config: Config) -> Iterator[str]:
    """Say at which addresses nobody is ever heard: one slip of a finger in a platform's name."""
    kinds = {table.kind for table in config.messengers}
    here = ", ".join(sorted(kinds))
    for person in config.people:
        elsewhere = [a for a in person.addresses if a.platform not in {*kinds, ROBOT}]
        if not elsewhere:
            continue
        if len(elsewhere) == len(person.addresses):
            yield f"{person.name} has no address on a messenger of this file."
        named = " and ".join(f"{address.platform}:{address.account}" for address in elsewhere)
        yield f"Nobody is heard at {named}: the messengers of this file are {here}."


def _unmet(config: Config, clock: Clock) -> Iterator[ConfigurationError]:
    """Say which assurance is asked for that no conversation here is ever worth."""
    best = _best(config, clock)
    asked = [
        *((f"The role {name}", role.assurance) for name, role in config.rulebook.roles.items()),
        *((f"[[care]] for {', '.join(c.scopes)}", c.assurance) for c in config.rulebook.care),
    ]
    for what, assurance in asked:
        if assurance in ASSURANCES and ASSURANCES[assurance] > best:
            yield ConfigurationError(
                f"{what} asks for a conversation that is {assurance}, and none of this file is ever"
                f" more than {best.said}: nobody can use it.",
                where=str(config.path),
                hint="Ask for less, or add a messenger that is worth it: docs/configuration.md.",
            )


def _best(config: Config, clock: Clock) -> Assurance:
    """Return the most that a conversation of this file can be worth."""
    if config.api is not None:
        return Assurance.LOCAL  # programs and pages of this machine
    found = [Assurance.PROVIDER_READABLE]
    for table in config.messengers:
        try:
            messenger = messenger_of(table, clock)
        except ConfigurationError:
            return Assurance.LOCAL  # that is said already
        verifies = isinstance(messenger, VerifiesDevices)
        found.append(Assurance.E2EE_VERIFIED if verifies else messenger_assurance(messenger))
    return max(found)


def _told(config: Config) -> str:
    return ", ".join(
        f"{count} {one if count == 1 else many}"
        for count, one, many in (
            (len(config.messengers), "messenger", "messengers"),
            (len(config.robots), "robot", "robots"),
            (len(config.people), "person", "people"),
        )
    )
