"""Writing the first configuration of a place: files that a check accepts, or none at all."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.setup.check import check_all
from rosic.config.plugins import check_robot_kind, demand_good, robot_factory
from rosic.config.profiles import SUFFIXES, check_profile, kind_in, load_profile, shipped_profiles
from rosic.contracts.file_rules import nearest
from rosic.core.identity import Address
from rosic.errors import ConfigurationError, OutOfBounds
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import Profile

TOKEN_FILE = "telegram-token.txt"  # noqa: S105 - the name of a file
ROBOTS = "robots"
SIMULATED = "simulated"
LOCALTIME = Path("/etc/localtime")
UTC = "UTC"
TELEGRAM, TERMINAL = "telegram", "terminal"


class SetupAnswers(msgspec.Struct, frozen=True, kw_only=True):
    """What somebody answered to the questions of ``rosic init``.

    Attributes:
        token: To be kept in a file of its own; empty for none.
        token_env: Instead: a variable of the environment that holds it.
        token_file: Instead: a file that holds it, as the configuration is to name it.
        robots: Names of profiles that ship.
        link: How those are reached; empty: as their profiles say.
        not_simulated: Those of them that cannot be simulated: reached as their profiles say.
        files: Profiles of one's own, by absolute path.
        files_link: How those are reached; empty: as they say.
        drafts: Profiles that were drafted from the ROS 2 graph, by id.
        admin: None lets the first start print a code.
    """

    name: str
    zone: str = "UTC"
    token: str = ""
    token_env: str = ""
    token_file: str = ""
    robots: tuple[str, ...] = ()
    link: str = SIMULATED
    not_simulated: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    files_link: str = ""
    drafts: dict[str, str] = {}
    admin: Address | None = None

    @property
    def has_telegram(self) -> bool:
        """Whether there is a bot; otherwise people talk at the terminal."""
        return bool(self.token or self.token_env or self.token_file)


class SetupResult(msgspec.Struct, frozen=True):
    """The files that were written.

    Attributes:
        written: Every file, as it was named.
        advice: What could be better, a sentence each.
    """

    written: tuple[str, ...]
    advice: tuple[str, ...]


def check_absent(path: Path) -> None:
    """See that a configuration may be written there.

    Raises:
        ConfigurationError: There is one already.
    """
    if path.exists() or path.is_symlink():
        raise ConfigurationError(
            "There is a configuration already; it was left alone.",
            where=str(path),
            hint="Name another file with -c, or move this one away.",
        )


def is_file(robot: str) -> bool:
    """Whether a profile is named as a file of one's own, and not as one that ships."""
    return robot.endswith(SUFFIXES) or "/" in robot


def check_robots(names: tuple[str, ...], clock: Clock, link: str = "") -> None:
    """See that these are profiles that ship, or files, of robots that can be reached from here.

    Args:
        names: As they were typed.
        clock: The machine's.
        link: How they are reached, whatever their profiles say.

    Raises:
        ConfigurationError: The first that is none, and why.
    """
    shipped = shipped_profiles()
    for name in names:
        if is_file(name):
            if not link and (kind := kind_in(Path(name).expanduser())):
                check_robot_kind(kind)  # else only what every robot has could be looked at
            check_reached(load_profile(Path(name).expanduser(), link=link), name, clock)
        elif name not in shipped:
            hint = f"{nearest(name, shipped)} A file of your own is named ./{name}.yaml."
            raise ConfigurationError(f"No profile is called {name!r}.", hint=hint)
        elif link:
            check_reached(load_profile(shipped[name], link=link), name, clock)
        elif not can_be_simulated(name, clock):
            check_reached(load_profile(shipped[name]), name, clock)


def check_reached(profile: Profile, where: str, clock: Clock) -> None:
    """See that a start could make the link to a robot, for it is no good to learn that at the end.

    Raises:
        ConfigurationError: It could not.
    """
    demand_good(profile, robot_factory(profile.link.kind), clock, where)


def can_be_simulated(name: str, clock: Clock) -> bool:
    """Tell whether a robot that ships can be simulated here."""
    try:
        check_reached(load_profile(shipped_profiles()[name], link=SIMULATED), name, clock)
    except ConfigurationError:
        return False
    return True


def check_zone(name: str) -> None:
    """See that there is such a time zone.

    Raises:
        ConfigurationError: There is none.
    """
    try:
        zone_named(name)
    except OutOfBounds as wrong:
        raise ConfigurationError(str(wrong)) from wrong


def zone_here(localtime: Path = LOCALTIME) -> str:
    """Return the time zone that this machine keeps; UTC if it does not say so by a name."""
    said = os.environ.get("TZ", "").removeprefix(":")
    name = said or str(localtime.resolve()).rpartition("/zoneinfo/")[2]
    try:
        check_zone(name)
    except ConfigurationError:
        return UTC
    return UTC if name in {f"Etc/{UTC}", "Etc/UCT", "Universal", "Zulu"} else name


def check_token(token: str) -> None:
    """See that something may be a Telegram token, before it is kept.

    Raises:
        ConfigurationError: It is none; the sentence does not repeat it.
    """
    if token and re.fullmatch(r"\d{3,20}:[\w-]{20,100}", token, re.ASCII) is None:
        raise ConfigurationError(
            "That does not look like a Telegram token.",
            hint="BotFather shows it as digits, a colon, and 35 letters and digits.",
        )


def check_account(text: str) -> Address:
    """Return the address of a Telegram account.

    Raises:
        ConfigurationError: It is no number.
    """
    account = text.removeprefix(f"{TELEGRAM}:").strip()
    if not (account.isascii() and account.isdigit() and len(account) <= 20):  # noqa: PLR2004
        raise ConfigurationError(
            f"{text!r} is not a Telegram id: that is a number, and no name.",
            hint="Leave it out to get a code that makes whoever sends it the admin.",
        )
    return Address(TELEGRAM, account)


def found(path: Path, answers: SetupAnswers, clock: Clock) -> SetupResult:
    """Write everything, and look at it as a start would.

    Raises:
        ConfigurationError: A file is in the way or cannot be written, or what was answered makes
            no configuration that a gateway starts with. Nothing is left behind.
    """
    check_absent(path)
    check_zone(answers.zone)
    if not (answers.robots or answers.files or answers.drafts):
        raise ConfigurationError("There is no robot, so there would be nothing to talk to.")
    made: list[Path] = []
    try:
        for name, text in _files(path, answers).items():
            _write(path.parent / name, text, made)
        advice = _checked(path, made, clock)
    except BaseException:
        for file in made:
            file.unlink(missing_ok=True)
        raise
    return SetupResult(tuple(map(str, made)), advice)


def _files(path: Path, answers: SetupAnswers) -> dict[str, str]:
    files = {f"{ROBOTS}/{name}.yaml": text for name, text in answers.drafts.items()}
    if answers.token:
        files[TOKEN_FILE] = f"{answers.token}\n"
    # The configuration comes last: while it is not there, nothing else means anything.
    return {**files, path.name: "\n".join(_lines(path, answers))}


def _beside(file: str, path: Path) -> str:
    """Return how a configuration names a file: from its own folder, where the file lies in it."""
    folder = path.parent.absolute()
    return f"./{Path(file).relative_to(folder)}" if Path(file).is_relative_to(folder) else file


def _lines(path: Path, answers: SetupAnswers) -> Iterator[str]:
    yield "# Written by rosic init. What each line means: docs/configuration.md"
    yield "# People and roles are seeded from here once; from then on the record has the say."
    yield from _table("[gateway]", {"name": answers.name, "zone": answers.zone})
    yield from _table("[[messenger]]", _messenger(answers))
    for name in answers.robots:
        linked = answers.link and name not in answers.not_simulated
        link = {"link": answers.link} if linked else {}
        yield from _table("[[robot]]", {"profile": name, **link})
    for file in answers.files:
        link = {"link": answers.files_link} if answers.files_link else {}
        yield from _table("[[robot]]", {"profile": _beside(file, path), **link})
    for name in answers.drafts:
        yield from _table("[[robot]]", {"profile": f"{ROBOTS}/{name}.yaml"})
    if answers.admin is not None:
        person = {"name": "Admin", "address": str(answers.admin), "role": "admin"}
        yield from _table("[[principal]]", person)


def _messenger(answers: SetupAnswers) -> dict[str, str | dict[str, str]]:
    if not answers.has_telegram:
        return {"kind": TERMINAL}
    if answers.token_env:
        return {"kind": TELEGRAM, "token": {"env": answers.token_env}}
    return {"kind": TELEGRAM, "token": {"file": answers.token_file or TOKEN_FILE}}


def _table(heading: str, values: Mapping[str, str | dict[str, str]]) -> Iterator[str]:
    yield f"\n{heading}"
    for key, value in values.items():
        if isinstance(value, dict):
            inner = ", ".join(f"{name} = {_quoted(text)}" for name, text in value.items())
            yield f"{key} = {{ {inner} }}"
        else:
            yield f"{key} = {_quoted(value)}"


def _quoted(text: str) -> str:
    """Return a text as TOML writes it: JSON's escapes are among TOML's."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _write(path: Path, text: str, made: list[Path]) -> None:
    mode = 0o600 if path.name == TOKEN_FILE else 0o644
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
        made.append(path)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(f"{text.rstrip()}\n")
    except FileExistsError:
        raise ConfigurationError(
            "The file exists already; it was left alone.",
            where=str(path),
            hint="Nothing was written.",
        ) from None
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "its name or its text"
        raise ConfigurationError(
            f"This cannot be written ({why}).", where=str(path), hint="Nothing was written."
        ) from error


def _checked(path: Path, made: list[Path], clock: Clock) -> tuple[str, ...]:
    checked = check_all(path, clock)
    if checked.errors:
        drafts = [error for file in made if file.suffix == ".yaml" for error in check_profile(file)]
        raise (drafts or checked.errors)[0]
    return tuple(map(str, checked.advice))
