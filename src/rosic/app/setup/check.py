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
from rosic.core.identity import ROBOT
from rosic.core.language import Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions, fleet_of
from rosic.core.policy.roles import Grant
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
    return CheckResult(
        errors, read.advice + _advice(read.config), "" if errors else _told(read.config)
    )


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


def _told(config: Config) -> str:
    return ", ".join(
        f"{count} {one if count == 1 else many}"
        for count, one, many in (
            (len(config.messengers), "messenger", "messengers"),
            (len(config.robots), "robot", "robots"),
            (len(config.people), "person", "people"),
        )
    )
