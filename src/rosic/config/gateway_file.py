"""The configuration file as it is written, and what it must keep besides its types."""

from __future__ import annotations

import enum
import re
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.config.api_tables import (
    ApiTable,
    MetricsTable,
    WebhookTable,
    measured,
    posted,
    served,
)
from rosic.config.missions import rulebook_of
from rosic.config.profile_fields import NAMED
from rosic.container.file_messages import MB
from rosic.container.files import FILES_MOST, PERSON_BYTES, PLACE_BYTES, FileQuota
from rosic.contracts.file_rules import (
    Field,
    FieldForm,
    NumberBounds,
    Place,
    Rules,
    ValidationFinding,
    nearest,
)
from rosic.core.identity import ROBOT, Address
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import fleet_of
from rosic.core.policy.roles import DEFAULT_ROLES, Role, SkillPrecondition
from rosic.core.policy.validation import rulebook_mistakes
from rosic.core.rate_limit import RateLimit, parse_rate
from rosic.core.time_units import DAY_S
from rosic.errors import OutOfBounds
from rosic.interpreters.chat_completions import TIMEOUT_S
from rosic.interpreters.endpoint import EXAMPLE as ENDPOINT_EXAMPLE
from rosic.interpreters.endpoint import parse_endpoint
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.core.language import UnitTable
    from rosic.core.robot.profile import Profile


class LogLevel(enum.Enum):
    """How much the log tells."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class GatewayTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The gateway itself.

    Attributes:
        name: Of this place, as people see it.
        data: Folder of the record, relative to the configuration file.
        zone: Of the place, an IANA name such as Europe/Berlin; times are said in it.
        preempt: Robots, patterns or groups that a higher role may take over.
        lease_idle_s: A robot that its holder has not used for so long is free again.
        log_level: How much the log tells.
    """

    name: str = "rosic"
    data: str = "rosic-data"
    zone: str = "UTC"
    preempt: tuple[str, ...] = ()
    lease_idle_s: float = 60.0
    log_level: LogLevel = LogLevel.INFO


class RobotTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One robot.

    Attributes:
        profile: Name of a profile that ships, or a file relative to the configuration file.
        link: Reaches the robot by this adapter instead of the profile's ``link.kind``.
        rate: How much the robot takes from everybody together: ``60/min burst 10``.
    """

    profile: str
    link: str = ""
    rate: str = ""


class MissionTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One mission.

    Attributes:
        file: Where it is written down, relative to the configuration file.
    """

    file: str


class LimitsTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How fast commands may come.

    Attributes:
        burst: Of one person, at once.
        per_s: Of one person, a second, thereafter.
        robot: Of each robot that has no rate of its own, from everybody together: ``120/min``.
    """

    burst: float = RateLimit().burst
    per_s: float = RateLimit().per_s
    robot: str = ""


class FilesTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much people may keep here in files; megabytes of a million bytes.

    Attributes:
        person_files: Files of one person.
        person_mb: Megabytes of one person.
        place_mb: Megabytes of everybody together.
    """

    person_files: int = FILES_MOST
    person_mb: float = PERSON_BYTES / MB
    place_mb: float = PLACE_BYTES / MB

    @property
    def room(self) -> FileQuota:
        """The same in bytes."""
        return FileQuota(self.person_files, int(self.person_mb * MB), int(self.place_mb * MB))


class Keep(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How long something is kept.

    Attributes:
        slots_days: A time with a robot, after it has ended.
        decisions_days: Who was let in, locked, given a right, and by whom.
    """

    slots_days: float = 90
    decisions_days: float = 1095


class LanguageTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Who may be shown what ROSIC does not understand; nobody, if nothing stands here.

    Attributes:
        endpoint: Of a server that speaks OpenAI's chat completions: ``http://127.0.0.1:11434``.
        model: Which of its models is asked.
        key: Of an account there; better one that stands elsewhere.
        timeout_s: How long one call may take.
    """

    endpoint: str = ""
    model: str = ""
    key: str | dict[str, str] = ""
    timeout_s: float = TIMEOUT_S


class PrincipalTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One person.

    Attributes:
        name: As others see it; no two people have the same.
        address: Account on a messenger: platform and immutable id, ``telegram:1001``.
        addresses: Several of them.
        role: Name of a role.
        roles: Several of them.
    """

    name: str
    address: str = ""
    addresses: tuple[str, ...] = ()
    role: str = ""
    roles: tuple[str, ...] = ()


class ConfigFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The file as it is written.

    Attributes:
        messenger: Accounts on messengers; besides kind and name, what the adapter asks for.
        mission: What several robots do, step by step, when somebody says so.
        role: What a role may do; beside the default roles, or instead of one.
        care: Skills that want more than the right to them.
        limits: How fast commands may come.
        keep: How long what is over is kept.
        files: How much people may keep here in files.
        language: Who may be shown what ROSIC does not understand.
        api: The API beside the chat, and the page.
        metrics: What monitoring reads.
        webhook: Who elsewhere is told what happens.
    """

    gateway: GatewayTable = GatewayTable()
    messenger: tuple[dict[str, Any], ...] = ()
    robot: tuple[RobotTable, ...] = ()
    principal: tuple[PrincipalTable, ...] = ()
    mission: tuple[MissionTable, ...] = ()
    role: dict[str, Role] = {}
    care: tuple[SkillPrecondition, ...] = ()
    limits: LimitsTable = LimitsTable()
    keep: Keep = Keep()
    files: FilesTable = FilesTable()
    language: LanguageTable = LanguageTable()
    api: ApiTable = ApiTable()
    metrics: MetricsTable = MetricsTable()
    webhook: tuple[WebhookTable, ...] = ()


_MODEL: Final = re.compile(r"[!-~]{1,200}").fullmatch
_ADDRESS = FieldForm(
    r"[a-z][a-z0-9_]{0,31}:\S{1,255}",
    "an address",
    "Write platform:account, for example telegram:1001.",
)
_SHOWN = FieldForm(r"[^\x00-\x1f\x7f]{1,64}", "a name", "Use 1 to 64 characters of one line.")

FORMS: Final[dict[Field, FieldForm]] = {
    (GatewayTable, "name"): _SHOWN,
    (GatewayTable, "data"): _SHOWN._replace(
        pattern=r"[^\x00-\x1f\x7f]+", meaning="a folder", hint="Name a folder."
    ),
    (GatewayTable, "zone"): FieldForm(
        r"[A-Za-z0-9_+/-]{1,64}", "a time zone", "Use an IANA name, for example Europe/Berlin."
    ),
    (RobotTable, "link"): NAMED._replace(empty=True),
    (PrincipalTable, "name"): _SHOWN,
    (PrincipalTable, "address"): _ADDRESS,
    (PrincipalTable, "addresses"): _ADDRESS,
    (ConfigFile, "role"): NAMED,
}

BOUNDS: Final[dict[Field, NumberBounds]] = {
    (GatewayTable, "lease_idle_s"): NumberBounds(1, DAY_S),
    (Keep, "slots_days"): NumberBounds(1, 36_500),
    (Keep, "decisions_days"): NumberBounds(30, 36_500),
    (FilesTable, "person_files"): NumberBounds(1, 10_000),
    (FilesTable, "person_mb"): NumberBounds(1, 1_000_000),
    (FilesTable, "place_mb"): NumberBounds(1, 10_000_000),
    (LanguageTable, "timeout_s"): NumberBounds(0.1, 30),
    (LimitsTable, "burst"): NumberBounds(1, 1_000_000),
    (LimitsTable, "per_s"): NumberBounds(0.001, 1_000_000),
}


def config_rules() -> Rules:
    """Return everything a configuration file is checked against, by itself."""
    return Rules(
        bounds=BOUNDS,
        forms=FORMS,
        hidden=frozenset(),
        checks={
            GatewayTable: (_placed,),
            RobotTable: (_robot_rate,),
            LimitsTable: (_robots_rate,),
            FilesTable: (_roomy,),
            LanguageTable: (_interpreted,),
            ApiTable: (served,),
            MetricsTable: (measured,),
            WebhookTable: (posted,),
            PrincipalTable: (_reachable,),
            ConfigFile: (_people, _talkers, _something),
        },
    )


def _placed(gateway: GatewayTable) -> Iterator[ValidationFinding]:
    try:
        zone_named(gateway.zone)
    except OutOfBounds as unknown:
        yield ValidationFinding(("zone",), str(unknown))


def _robot_rate(robot: RobotTable) -> Iterator[ValidationFinding]:
    yield from _rate("rate", robot.rate)


def _robots_rate(limits: LimitsTable) -> Iterator[ValidationFinding]:
    yield from _rate("robot", limits.robot)


def _roomy(files: FilesTable) -> Iterator[ValidationFinding]:
    if files.person_mb > files.place_mb:
        yield ValidationFinding(
            ("person_mb",),
            "One person may keep more than everybody together.",
            "Raise place_mb, or lower person_mb.",
        )


def _interpreted(language: LanguageTable) -> Iterator[ValidationFinding]:
    if not language.endpoint:
        if language.model or language.key:
            yield ValidationFinding(
                ("endpoint",), "No endpoint is named, so nothing would be asked.", ENDPOINT_EXAMPLE
            )
        return
    try:
        parse_endpoint(language.endpoint)
    except ValueError as wrong:
        sentence = f"{wrong}."
        yield ValidationFinding(
            ("endpoint",), sentence[:1].upper() + sentence[1:], ENDPOINT_EXAMPLE
        )
    if not _MODEL(language.model):
        yield ValidationFinding(
            ("model",), "'model' names none of its models.", 'For example model = "qwen3:8b".'
        )


def _rate(key: str, said: str) -> Iterator[ValidationFinding]:
    try:
        if said:
            parse_rate(said)
    except ValueError as fault:
        yield ValidationFinding((key,), f"{fault}.")


def said_roles(person: PrincipalTable) -> list[tuple[Place, str]]:
    """Return a person's roles and where each stands."""
    roles: list[tuple[Place, str]] = [(("roles", i), role) for i, role in enumerate(person.roles)]
    return [(("role",), person.role), *roles] if person.role else roles


def said_addresses(person: PrincipalTable) -> list[tuple[Place, Address]]:
    """Return a person's addresses and where each stands."""
    said: list[tuple[Place, str]] = [
        (("addresses", i), text) for i, text in enumerate(person.addresses)
    ]
    if person.address:
        said.insert(0, (("address",), person.address))
    return [(place, Address(*text.split(":", 1))) for place, text in said]


def _reachable(person: PrincipalTable) -> Iterator[ValidationFinding]:
    if not said_addresses(person):
        yield ValidationFinding(
            (),
            f"{person.name} has no address, so nobody could write as {person.name}.",
            "Give an address, for example telegram:1001.",
        )
    if not said_roles(person):
        yield ValidationFinding(
            (),
            f"{person.name} has no role, so {person.name} could do nothing.",
            "Give a role: viewer, operator, admin, or one of your own.",
        )
    for place, address in said_addresses(person):
        # A Matrix account (@name:server) is an id; @name alone is a username everywhere.
        if address.account.startswith("@") and ":" not in address.account:
            yield ValidationFinding(
                place,
                f"{address.account} is a username, which can pass to somebody else.",
                "Give the account's number or id.",
            )


def _people(file: ConfigFile) -> Iterator[ValidationFinding]:
    names: set[str] = set()
    taken: dict[Address, str] = {}
    roles = {*DEFAULT_ROLES, *file.role}
    for index, person in enumerate(file.principal):
        here: Place = ("principal", index)
        name = person.name.casefold()
        if name in names:
            yield ValidationFinding(
                (*here, "name"), f"Two people are called {person.name}.", "Tell them apart."
            )
        names.add(name)
        for place, address in said_addresses(person):
            if address in taken:
                yield ValidationFinding(
                    (*here, *place), f"{address} already belongs to {taken[address]}."
                )
            taken.setdefault(address, person.name)
        for place, role in said_roles(person):
            if role not in roles:
                yield ValidationFinding(
                    (*here, *place), f"No role is called {role!r}.", nearest(role, roles)
                )


def _talkers(file: ConfigFile) -> Iterator[ValidationFinding]:
    names: set[str] = set()
    for index, table in enumerate(file.messenger):
        here: Place = ("messenger", index)
        for key in ("kind", "name") if "name" in table else ("kind",):
            value = table.get(key)
            if not isinstance(value, str) or not value:
                yield ValidationFinding(
                    (*here, key),
                    f"A messenger needs a {key} that is a text.",
                    'For example kind = "telegram".' if key == "kind" else "",
                )
        name = table.get("name", table.get("kind"))
        if isinstance(name, str) and name in names:
            yield ValidationFinding(
                (*here, "name"), f"Two messengers are called {name!r}.", "Give one another name."
            )
        names.add(str(name))


def _something(file: ConfigFile) -> Iterator[ValidationFinding]:
    if not file.messenger:
        yield ValidationFinding((), "There is no [[messenger]], so nobody could talk to a robot.")
    if not file.robot:
        yield ValidationFinding(
            (), "There is no [[robot]].", 'For example: [[robot]] profile = "omni".'
        )


def rule_findings(
    file: ConfigFile, robots: Iterable[Profile], units: UnitTable
) -> Iterator[ValidationFinding]:
    """Find what is wrong with roles and care: it would give or ask for something else."""
    rulebook = rulebook_of(file.role, file.care, file.gateway.preempt)
    mistakes = rulebook_mistakes(rulebook, fleet_of(robots), unit_converter(units))
    for mistake in mistakes:
        place: Place = mistake.place
        if place and place[0] == "preempt":
            place = ("gateway", *place)
        yield ValidationFinding(place, mistake.sentence, mistake.hint)


def author_findings(file: ConfigFile, robots: Iterable[Profile]) -> Iterator[ValidationFinding]:
    """Find rules that run something as somebody whom the configuration does not name."""
    known = {person.name.casefold() for person in file.principal}
    for index, profile in enumerate(robots):
        for alert in profile.alerts:
            if alert.author and alert.author.casefold() not in known:
                yield ValidationFinding(
                    ("robot", index, "profile"),
                    f"The rule {alert.name!r} of {profile.id} runs as {alert.author}, and nobody "
                    "here is called so.",
                    "Give 'as' the name of a [[principal]].",
                )


def robot_findings(file: ConfigFile, robots: Iterable[Profile]) -> Iterator[ValidationFinding]:
    """Find principals that are robots which are not there."""
    known = {profile.id for profile in robots}
    for index, person in enumerate(file.principal):
        for address in (person.address, *person.addresses):
            platform, _, robot = address.partition(":")
            if platform == ROBOT and robot not in known:
                yield ValidationFinding(
                    ("principal", index),
                    f"{person.name} is to be the robot {robot}, and there is no such [[robot]].",
                    f"There are: {', '.join(sorted(known)) or 'none'}.",
                )
