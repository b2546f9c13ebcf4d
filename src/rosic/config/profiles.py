"""Profiles: where they are, what is wrong with them, and the objects made of them."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from msgspec import inspect

from rosic.config.plugins import profile_schema, same_robot
from rosic.config.profile_validation import clash, profile_rules
from rosic.config.units import compile_units
from rosic.config.validation import SourceValidator, opaque_fields
from rosic.config.yaml_source import parse_yaml, read_yaml
from rosic.contracts.adapter import EVERY_ROBOT
from rosic.contracts.file_rules import Place, ValidationFinding, nearest
from rosic.core.robot.profile import Files, Link, Profile, Telemetry
from rosic.core.robot.skill import Skill
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rosic.config.source_map import Data, SourceMap
    from rosic.core.language import UnitTable

SUFFIXES = (".yaml", ".yml")


class ReadProfile(NamedTuple):
    """A profile that was read.

    Attributes:
        profile: None when anything is wrong with it.
        errors: Everything that is wrong.
        advice: What is allowed, but worse than it could be.
    """

    profile: Profile | None
    errors: list[ConfigurationError]
    advice: list[ConfigurationError]


def load_profile(path: Path | str, units: UnitTable | None = None, *, link: str = "") -> Profile:
    """Read one robot.

    Args:
        path: A YAML file.
        units: The units that people may use; None takes all that ROSIC knows.
        link: Reach it by this adapter, whatever the file says: ``simulated``, for a trial.

    Raises:
        ConfigurationError: The first thing that is wrong, with its line.
    """
    read = read_profile(path, units, link=link)
    if read.profile is None:
        raise read.errors[0]
    return read.profile


def check_profile(path: Path | str, units: UnitTable | None = None) -> list[ConfigurationError]:
    """Return everything that is wrong with a file, as far as it can be told; nothing if good."""
    return read_profile(path, units).errors


def read_profile(
    path: Path | str, units: UnitTable | None = None, *, link: str = ""
) -> ReadProfile:
    """Read one robot, and collect what is wrong with it and what could be better. Never raises.

    Args:
        path: A YAML file.
        units: The units that people may use; None takes all that ROSIC knows.
        link: Reach it by this adapter, whatever the file says.
    """
    return _read(lambda: read_yaml(Path(path)), units, link)


def read_profile_text(
    text: str, name: str, units: UnitTable | None = None, *, link: str = ""
) -> ReadProfile:
    """Read one robot from what stands in its file; otherwise as `read_profile`.

    Args:
        text: The file.
        name: How the file is named to people.
        units: As there.
        link: As there.
    """
    return _read(lambda: parse_yaml(text, name), units, link)


def _read(read: Callable[[], SourceMap], units: UnitTable | None, link: str) -> ReadProfile:
    try:
        source = read()
    except ConfigurationError as error:
        return ReadProfile(None, [error], [])
    if link:
        _reach_by(source.data, link)
    schema = profile_schema(_kind_in(source.data))
    if schema is None:
        source.data = _of_every_robot(source.data)
        schema = EVERY_ROBOT
    rules = profile_rules(known_units() if units is None else units, schema.rules)
    walker = SourceValidator(source, rules)
    walker.check(source.data, _form(schema.profile), ())
    if walker.errors:
        return ReadProfile(None, walker.errors, [])
    profile = _with_skill_ids(msgspec.convert(source.data, schema.profile))
    better = [source.error(*finding) for finding in schema.advice(profile)]
    return ReadProfile(profile, [], better)


@cache
def _form(profile: type[Profile]) -> inspect.Type:
    """Return what a profile must look like; worked out once, as that takes a while."""
    return inspect.type_info(profile)


def kind_in(path: Path) -> str:
    """Return the kind of robot link that a profile names; empty where it names none."""
    try:
        return _kind_in(read_yaml(path).data)
    except ConfigurationError:
        return ""  # whoever reads it says why


def _kind_in(data: Data) -> str:
    link = data.get("link") if isinstance(data, dict) else None
    kind = link.get("kind") if isinstance(link, dict) else None
    return kind if isinstance(kind, str) else ""


def _of_every_robot(data: Data) -> Data:
    """Return a profile without the keys that only the adapter of its kind could know.

    That there is no such kind is said by whoever makes the robot.
    """
    if not isinstance(data, dict):
        return data
    parts: dict[str, type] = {"link": Link, "files": Files}
    many: dict[str, type] = {"skills": Skill, "telemetry": Telemetry}
    kept = _keys_of(data, Profile)
    if not _kind_in(data):  # it says no kind, so a key that no robot has is a slip
        own = opaque_fields(Profile)
        kept = {key: value for key, value in data.items() if key not in own}
    for key, part in parts.items():
        if key in kept:
            kept[key] = _keys_of(kept[key], part)
    for key, part in many.items():
        if isinstance(kept.get(key), dict):
            kept[key] = {name: _keys_of(one, part) for name, one in kept[key].items()}
    return kept


def _keys_of(data: Data, part: type) -> Data:
    fields = msgspec.structs.fields(part)
    known = {field.encode_name for field in fields if field.name not in opaque_fields(part)}
    return {k: v for k, v in data.items() if k in known} if isinstance(data, dict) else data


@cache
def known_units() -> UnitTable:
    """Return every unit ROSIC knows; compiled once, as that takes a while."""
    return compile_units()


def reached_in(source: SourceMap) -> frozenset[str]:
    """Return what a profile's robot alone can answer to; also where its rules are not kept yet.

    Nothing, where it is no profile at all: whoever reads it for use says why.
    """
    schema = profile_schema(_kind_in(source.data))
    if schema is None:
        return frozenset()
    try:
        profile = _with_skill_ids(msgspec.convert(source.data, schema.profile))
    except (msgspec.ValidationError, ValueError):
        return frozenset()
    return frozenset(schema.reaches(profile))


def shipped_profiles() -> dict[str, Path]:
    """Return the profiles that come with ROSIC: their names, and where they are."""
    folder = Path(str(files("rosic.robots").joinpath("profiles")))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def find_profile(wanted: str, folder: Path) -> Path:
    """Return the file that ``profile = "..."`` means.

    Args:
        wanted: A path, absolute or relative to ``folder``; or the name of a shipped profile.
        folder: Of the configuration file.

    Raises:
        ConfigurationError: A name that is no path and that no shipped profile has.
    """
    if wanted.endswith(SUFFIXES) or "/" in wanted:
        return folder / Path(wanted).expanduser()
    shipped = shipped_profiles()
    if wanted not in shipped:
        raise ConfigurationError(
            f"No profile is called {wanted!r}.",
            hint=f"{nearest(wanted, shipped)} A file of your own ends in .yaml.",
        )
    return shipped[wanted]


def fleet_findings(profiles: Sequence[Profile], units: UnitTable) -> Iterator[ValidationFinding]:
    """Find what is wrong with robots only because they are together.

    Places are those of the configuration.
    """
    # Who clashes is found by adding one after another: slow for a fleet, so only where it must be.
    apart = not clash(list({profile.id: profile for profile in reversed(profiles)}.values()), units)
    known: list[Profile] = []
    ids: set[str] = set()
    for index, profile in enumerate(profiles):
        place: Place = ("robot", index, "profile")
        if profile.id in ids:
            yield ValidationFinding(
                place, f"Two robots are called {profile.id!r}.", "Give one another id."
            )
            continue
        ids.add(profile.id)
        known.append(profile)
        fault = "" if apart else clash(known, units)
        if fault:
            yield ValidationFinding(place, fault, "Give one of them another name.")
            known.pop()
    # Profiles of one id have been refused already, and may well be the same file.
    places = {id(profile): index for index, profile in enumerate(profiles)}
    for found in same_robot(known):
        yield ValidationFinding(
            ("robot", places[id(found.other)], "profile"), found.sentence, "Keep one of the two."
        )


def _reach_by(data: Data, kind: str) -> None:
    if isinstance(data, dict) and isinstance(data.get("link"), dict):
        data["link"]["kind"] = kind


def _with_skill_ids(profile: Profile) -> Profile:
    skills = {
        name: msgspec.structs.replace(skill, id=name) for name, skill in profile.skills.items()
    }
    return msgspec.structs.replace(profile, skills=skills)
