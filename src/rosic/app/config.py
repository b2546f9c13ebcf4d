"""One TOML file seeds a gateway: its settings, messengers, robots, people and roles.

From the first start on the database is the truth; this file adds, and revives nobody.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
from msgspec import inspect

from rosic.api.metrics.endpoint import MetricsSettings
from rosic.api.settings import ApiSettings, parse_listen
from rosic.api.webhooks.settings import WebhookSettings, key_of
from rosic.app.people import ConfiguredPerson
from rosic.config.gateway_file import (
    ConfigFile,
    Keep,
    LogLevel,
    PrincipalTable,
    author_findings,
    config_rules,
    robot_findings,
    rule_findings,
    said_addresses,
    said_roles,
)
from rosic.config.missions import Missions, rulebook_of
from rosic.config.profiles import find_profile, fleet_findings, known_units, read_profile
from rosic.config.secrets import SecretSettings
from rosic.config.toml_source import read_toml
from rosic.config.validation import SourceValidator
from rosic.container.files import FileQuota
from rosic.contracts.file_rules import ValidationFinding
from rosic.core.fleet.mission import Mission
from rosic.core.policy.roles import RoleRules
from rosic.core.rate_limit import RateLimit, parse_rate
from rosic.core.robot.profile import Profile, RobotId
from rosic.errors import ConfigurationError
from rosic.interpreters.chat_completions import InterpreterSettings
from rosic.interpreters.endpoint import advice_on, parse_endpoint

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.config.api_tables import ApiTable, MetricsTable
    from rosic.config.source_map import SourceMap
    from rosic.core.language import UnitTable


class MessengerSettings(msgspec.Struct, frozen=True, kw_only=True):
    """One account on one messenger.

    Attributes:
        kind: Name of a messenger adapter.
        name: Unique in the file; the kind when left out.
        settings: Everything else in its table. Secrets are `Secret`.
        where: Its line in the file, for what the adapter finds wrong.
    """

    kind: str
    name: str
    settings: dict[str, Any]
    where: str = ""


class Config(msgspec.Struct, frozen=True, kw_only=True):
    """What a gateway is seeded with.

    Attributes:
        path: The file.
        name: Of this place, as people see it.
        data: Folder of the record, absolute.
        rulebook: Roles, care and pre-emption.
        zone: Of the place.
        limits: Of each person.
        robot_limits: Of robots that have one.
        robot_limit: Of robots that are added while it runs; None: they have none.
        missions: What several robots do when somebody says so.
        room: For files that people keep.
        files: What was read: the file itself, and profiles that do not ship.
        interpreter: Who may be shown what is not understood; None: nobody.
        api: How the API is served; None: nothing listens.
        metrics: Where metrics are served; None: nowhere.
        webhooks: Who elsewhere is told what happens.
        begin_anew: Said on the command line: a record that was lost is begun anew.
    """

    path: Path
    name: str
    data: Path
    lease_idle_s: float
    log_level: LogLevel
    messengers: tuple[MessengerSettings, ...]
    robots: tuple[Profile, ...]
    people: tuple[ConfiguredPerson, ...]
    rulebook: RoleRules
    zone: str
    limits: RateLimit
    robot_limits: dict[RobotId, RateLimit]
    keep: Keep
    room: FileQuota
    missions: tuple[Mission, ...] = ()
    robot_limit: RateLimit | None = None
    files: tuple[Path, ...] = ()
    interpreter: InterpreterSettings | None = None
    begin_anew: bool = False
    api: ApiSettings | None = None
    metrics: MetricsSettings | None = None
    webhooks: tuple[WebhookSettings, ...] = ()


class ReadConfig(NamedTuple):
    """A configuration that was read.

    Attributes:
        config: None when anything is wrong with it or with one of its robots.
        errors: Everything that is wrong.
        advice: What is allowed, but worse than it could be.
    """

    config: Config | None
    errors: list[ConfigurationError]
    advice: list[ConfigurationError]


def load_config(
    path: Path | str,
    units: UnitTable | None = None,
    environ: Mapping[str, str] | None = None,
    *,
    secrets: bool = True,
) -> Config:
    """Read the configuration and the profiles it names.

    Args:
        path: A TOML file.
        units: The units that people may use; None takes all that ROSIC knows.
        environ: Where ``{ env = ... }`` looks; None takes the environment of the process.
        secrets: Whether they are needed. Otherwise those that cannot be had are left out: whoever
            looks after people from another shell talks to no messenger.

    Raises:
        ConfigurationError: The first thing that is wrong, with its file and line.
    """
    read = read_config(path, units, environ, secrets=secrets)
    if read.config is None:
        raise read.errors[0]
    return read.config


def read_config(
    path: Path | str,
    units: UnitTable | None = None,
    environ: Mapping[str, str] | None = None,
    *,
    secrets: bool = True,
) -> ReadConfig:
    """Read the configuration, and collect what is wrong and what could be better. Never raises."""
    try:
        source = read_toml(Path(path))
    except ConfigurationError as error:
        return ReadConfig(None, [error], [])
    walker = SourceValidator(source, config_rules())
    walker.check(source.data, inspect.type_info(ConfigFile), ())
    if walker.errors:
        return ReadConfig(None, walker.errors, [])
    file = msgspec.convert(source.data, ConfigFile)
    reading = _Reading(source, Path(path), file)
    resolving = SecretSettings(
        source, Path(path).parent, os.environ if environ is None else environ
    )
    messengers, interpreter = reading.with_secrets(resolving, needed=secrets)
    webhooks = reading.webhooks(resolving) if secrets else ()
    robots = reading.robots(units)
    missions = () if reading.errors else reading.missions(robots, units)
    if reading.errors:
        return ReadConfig(None, reading.errors, reading.advice)
    config = Config(
        path=Path(path),
        name=file.gateway.name,
        data=(Path(path).parent / Path(file.gateway.data).expanduser()).absolute(),
        lease_idle_s=file.gateway.lease_idle_s,
        log_level=file.gateway.log_level,
        messengers=messengers,
        robots=robots,
        people=tuple(_seed(person) for person in file.principal),
        rulebook=rulebook_of(file.role, file.care, file.gateway.preempt),
        zone=file.gateway.zone,
        limits=RateLimit(burst=file.limits.burst, per_s=file.limits.per_s),
        robot_limits=_robot_limits(file, robots),
        robot_limit=parse_rate(file.limits.robot) if file.limits.robot else None,
        keep=file.keep,
        missions=missions,
        room=file.files.room,
        files=tuple(reading.files),
        interpreter=interpreter,
        api=_api(file.api, Path(path).parent),
        metrics=_metrics(file.metrics),
        webhooks=webhooks,
    )
    return ReadConfig(config, [], reading.advice)


def _api(table: ApiTable, folder: Path) -> ApiSettings | None:
    """Return how the API is served; files are found beside the configuration."""
    if not table.listen:
        return None

    def found(file: str) -> str:
        return str((folder / Path(file).expanduser()).absolute()) if file else ""

    return ApiSettings(
        listen=parse_listen(table.listen),
        hosts=table.hosts,
        url=table.url.rstrip("/"),
        certificate=found(table.certificate),
        private_key=found(table.private_key),
        proxies=table.proxies,
        topics=table.topic,
        rosbridge=parse_listen(table.rosbridge) if table.rosbridge else None,
        origins=table.origins,
    )


def _metrics(table: MetricsTable) -> MetricsSettings | None:
    if not table.listen:
        return None
    return MetricsSettings(listen=parse_listen(table.listen), hosts=table.hosts)


def _robot_limits(file: ConfigFile, robots: Sequence[Profile]) -> dict[RobotId, RateLimit]:
    said = {
        profile.id: table.rate or file.limits.robot
        for profile, table in zip(robots, file.robot, strict=True)
    }
    return {robot: parse_rate(text) for robot, text in said.items() if text}


def _seed(person: PrincipalTable) -> ConfiguredPerson:
    return ConfiguredPerson(
        name=person.name,
        addresses=tuple(address for _, address in said_addresses(person)),
        roles=tuple(role for _, role in said_roles(person)),
    )


class _Reading:
    """What the file names is looked up: secrets and profiles."""

    def __init__(self, source: SourceMap, path: Path, file: ConfigFile) -> None:
        self.errors: list[ConfigurationError] = []
        self.advice: list[ConfigurationError] = []
        self._source = source
        self._folder = path.parent
        self.files = [path]
        self._file = file

    def with_secrets(
        self, secrets: SecretSettings, *, needed: bool
    ) -> tuple[tuple[MessengerSettings, ...], InterpreterSettings | None]:
        """Return what has secrets among its settings."""
        read = self._messengers(secrets), self._interpreter(secrets)
        self.errors += secrets.errors if needed else ()
        return read

    def _messengers(self, secrets: SecretSettings) -> tuple[MessengerSettings, ...]:
        made: list[MessengerSettings] = []
        for index, table in enumerate(self._file.messenger):
            place = ("messenger", index)
            own = {key: value for key, value in table.items() if key not in {"kind", "name"}}
            made.append(
                MessengerSettings(
                    kind=table["kind"],
                    name=table.get("name", table["kind"]),
                    settings=secrets.resolve(own, place),
                    where=self._source.where(place),
                )
            )
        return tuple(made)

    def _interpreter(self, secrets: SecretSettings) -> InterpreterSettings | None:
        table, place = self._file.language, ("language",)
        if not table.endpoint:
            return None
        endpoint = parse_endpoint(table.endpoint)
        key = secrets.resolve(table.key or None, (*place, "key"))
        self.advice += [
            self._source.error((*place, "endpoint"), sentence, hint)
            for sentence, hint in advice_on(endpoint, keyed=key is not None)
        ]
        return InterpreterSettings(
            endpoint=endpoint, model=table.model, key=key, timeout_s=table.timeout_s
        )

    def webhooks(self, secrets: SecretSettings) -> tuple[WebhookSettings, ...]:
        """Return who elsewhere is told what happens."""
        found: list[WebhookSettings] = []
        for index, table in enumerate(self._file.webhook):
            place = ("webhook", index, "secret")
            before = len(secrets.errors)
            secret = secrets.resolve(table.secret, place)
            if len(secrets.errors) > before:
                self.errors += secrets.errors[before:]
                continue
            try:
                key_of(secret)
            except ValueError as wrong:
                self.errors.append(self._source.error(place, f"{wrong}.", ""))
                continue
            topics = frozenset(table.events)
            made = WebhookSettings(
                url=table.url, secret=secret, topics=topics, private=table.private
            )
            found.append(made)
        return tuple(found)

    def robots(self, units: UnitTable | None) -> tuple[Profile, ...]:
        found: list[Profile | None] = [
            self._robot(index, units) for index in range(len(self._file.robot))
        ]
        robots = [profile for profile in found if profile is not None]
        if len(robots) == len(found):
            table = known_units() if units is None else units
            self._note(fleet_findings(robots, table))
            if not self.errors:
                self._note(rule_findings(self._file, robots, table))
                self._note(author_findings(self._file, robots))
                self._note(robot_findings(self._file, robots))
        return tuple(robots)

    def missions(self, robots: Sequence[Profile], units: UnitTable | None) -> tuple[Mission, ...]:
        if not self._file.mission:
            return ()
        missions = Missions(robots, known_units() if units is None else units)
        for index, table in enumerate(self._file.mission):
            path = self._folder / Path(table.file).expanduser()
            if path.exists():
                missions.read(path)
            else:
                place = ("mission", index, "file")
                self._note([ValidationFinding(place, f"There is no mission at {table.file}.")])
        found = missions.found()
        self.errors += missions.errors
        return found

    def _note(self, findings: Iterable[ValidationFinding]) -> None:
        self.errors += [self._source.error(*finding) for finding in findings]

    def _robot(self, index: int, units: UnitTable | None) -> Profile | None:
        table = self._file.robot[index]
        place = ("robot", index, "profile")
        try:
            path = find_profile(table.profile, self._folder)
        except ConfigurationError as error:
            self.errors.append(self._source.error(place, str(error)))
            return None
        if not path.exists():
            self._note([ValidationFinding(place, f"There is no profile at {table.profile}.")])
            return None
        if Path(table.profile).suffix:  # none that ships
            self.files.append(path)
        read = read_profile(path, units, link=table.link)
        self.errors += read.errors
        self.advice += read.advice
        return read.profile
