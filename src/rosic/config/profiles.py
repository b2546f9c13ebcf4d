"""Profiles: where they are, what is wrong with them, and the objects made of them."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from msgspec import inspect

from rosic.config.profile_validation import advice, clash, profile_rules
from rosic.config.units import compile_units
from rosic.config.validation import SourceValidator
from rosic.config.yaml_source import parse_yaml, read_yaml
from rosic.contracts.file_rules import Place, ValidationFinding, nearest
from rosic.core.robot.profile import Profile
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
    walker = SourceValidator(source, profile_rules(known_units() if units is None else units))
    walker.check(source.data, _form(), ())
    if walker.errors:
        return ReadProfile(None, walker.errors, [])
    profile = _with_skill_ids(msgspec.convert(source.data, Profile))
    better = [source.error(*finding) for finding in advice(profile)]
    return ReadProfile(profile, [], better)


@cache
def _form() -> inspect.Type:
    """Return what a profile must look like; worked out once, as that takes a while."""
    return inspect.type_info(Profile)


@cache
def known_units() -> UnitTable:
    """Return every unit ROSIC knows; compiled once, as that takes a while."""
    return compile_units()


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


def _reach_by(data: Data, kind: str) -> None:
    if isinstance(data, dict) and isinstance(data.get("link"), dict):
        data["link"]["kind"] = kind


def _with_skill_ids(profile: Profile) -> Profile:
    skills = {
        name: msgspec.structs.replace(skill, id=name) for name, skill in profile.skills.items()
    }
    return msgspec.structs.replace(profile, skills=skills)
