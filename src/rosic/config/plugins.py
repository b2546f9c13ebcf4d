"""Adapters by name, from entry points: one of a stranger's is found like one of ours."""

from __future__ import annotations

import logging
from difflib import get_close_matches
from functools import cache
from gettext import GNUTranslations
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple, cast

from rosic.contracts.adapter import schema_of, stops_itself
from rosic.core.order_gate import OrderGate
from rosic.errors import ConfigurationError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.adapter import MessengerFactory, ProfileSchema, RobotFactory
    from rosic.contracts.clock import Clock
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.robot.profile import Profile


# ---- translations ----

# The catalogues that ship with ROSIC: ``rosic/locale/<language>/LC_MESSAGES/rosic.mo``.

LANGUAGES: Mapping[str, tuple[str, ...]] = {
    "en": ("English", "englisch"),
    "de": ("Deutsch", "German"),
}
"""What is spoken here: a code, and what people call the language; first, as it calls itself."""

log = logging.getLogger("rosic.languages")


@cache
def catalogue(code: str) -> Catalogue | None:
    """Return the catalogue of a language; None for English, and where it cannot be read."""
    if code == "en":
        return None
    compiled = files("rosic") / "locale" / code / "LC_MESSAGES" / "rosic.mo"
    try:
        with compiled.open("rb") as file:
            return GNUTranslations(file)
    except OSError:
        log.warning("the catalogue of %s cannot be read: sentences stay English", code)
        return None


def of_locale(locale: str) -> Catalogue | None:
    """Return the catalogue that goes with a locale: ``de_AT``; None for English and others."""
    code = locale.partition("_")[0].casefold()
    return catalogue(code) if code in LANGUAGES else None


def whose(authoriser: Authoriser, address: Address) -> PrincipalId | None:
    """Return who is at an address, for speaking to them in their language."""
    found = authoriser.directory.at(address)
    return None if found is None else found[0].id


# ---- plugins ----

MESSENGERS = "rosic.messengers"
ROBOTS = "rosic.robots"


class PluginFault(NamedTuple):
    """What is wrong with a robot, and where in its profile."""

    place: tuple[str, ...]
    sentence: str
    hint: str


class ProfileConflict(NamedTuple):
    """Two profiles that reach one robot, and what both name."""

    one: Profile
    other: Profile
    name: str

    @property
    def sentence(self) -> str:
        """What is wrong."""
        return (
            f"{self.one.id} and {self.other.id} reach one robot: both name {self.name}. "
            "A stop or a lock of one would not hold for the other."
        )


def messenger_factory(kind: str) -> MessengerFactory:
    """Return the factory of a kind of messenger.

    Raises:
        ConfigurationError: There is no such kind, or what it needs is not installed.
    """
    return cast("MessengerFactory", _load(MESSENGERS, kind, "messenger"))


def robot_factory(kind: str) -> RobotFactory:
    """Return the factory of a kind of robot link.

    Raises:
        ConfigurationError: There is no such kind, or what it needs is not installed.
    """
    return cast("RobotFactory", _load(ROBOTS, kind, "robot link"))


def check_robot_kind(kind: str) -> None:
    """Look whether a kind of robot link exists; what it needs may be missing on this machine.

    Raises:
        ConfigurationError: There is no such kind.
    """
    _find(ROBOTS, kind, "robot link")


def robot_kinds() -> tuple[str, ...]:
    """Return the kinds of robot links that are installed."""
    return tuple(sorted(_installed(ROBOTS)))


def profile_schema(kind: str) -> ProfileSchema | None:
    """Return what profiles of a kind of robot link say.

    Returns:
        None where that is not known: there is no such kind, or what it needs is not installed.
    """
    try:
        return schema_of(robot_factory(kind))
    except ConfigurationError:
        return None


def check_robot(profile: Profile, factory: RobotFactory, clock: Clock) -> Iterator[PluginFault]:
    """Say what would keep a robot from being made, or from being moved with a clear conscience.

    One law for every kind of link: what moves can be stopped and is measured at rest, or its
    profile says plainly that it is neither.

    Args:
        profile: Of the robot.
        factory: Of its kind.
        clock: For making it, which opens and begins nothing.
    """
    held = (profile.stops and profile.measures_rest) or stops_itself(factory)
    if profile.moves and not held and not profile.unstoppable:
        yield PluginFault(
            ("link", "kind"),
            f"{profile.shown} moves, and nothing here would stop it or measure that it rests: the "
            f"link {profile.link.kind!r} does not do it by itself.",
            "Give 'stop' and 'at_rest', or write unstoppable: true, and people are told.",
        )
    try:
        factory(profile, OrderGate(profile.id, n=0, fence=0, generation=0, latched=True), clock)
    except ConfigurationError as wrong:
        yield PluginFault(("link",), str(wrong), "")


def demand_good(profile: Profile, factory: RobotFactory, clock: Clock, where: str = "") -> None:
    """See that nothing keeps a robot from being made; see `check_robot`.

    Raises:
        ConfigurationError: The first thing that does.
    """
    for fault in check_robot(profile, factory, clock):
        raise ConfigurationError(fault.sentence, where=where, hint=fault.hint)


def shared_spaces(profiles: Iterable[Profile]) -> Iterator[str]:
    """Say which robots are reached in one namespace: what one is told, the other hears as well."""
    found: dict[str, list[str]] = {}
    for profile in profiles:
        if profile.link.namespace:
            found.setdefault(profile.link.namespace, []).append(profile.id)
    for space, robots in found.items():
        if len(robots) > 1:
            yield (
                f"{' and '.join(robots)} have one namespace, {space}: what one of them is told, "
                "the others hear as well."
            )


def same_robot(
    profiles: Iterable[Profile], schemas: Callable[[str], ProfileSchema | None] = profile_schema
) -> Iterator[ProfileConflict]:
    """Find the profiles that reach a robot which an earlier one of them reaches.

    Args:
        profiles: Of a fleet, in order.
        schemas: Returns what profiles of a kind say: that is asked which names are a robot's own.
    """
    owners: dict[str, Profile] = {}
    for profile in profiles:
        schema = schemas(profile.link.kind)
        known = schema is not None and isinstance(profile, schema.profile)
        names = sorted(set(schema.reaches(profile))) if schema is not None and known else []
        shared = next((name for name in names if name in owners), "")
        if shared:
            yield ProfileConflict(owners[shared], profile, shared)
        for name in names:
            owners.setdefault(name, profile)


def _find(group: str, kind: str, what: str) -> EntryPoint:
    found = _installed(group)
    if kind not in found:
        near = get_close_matches(kind, found, n=1)
        hint = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(sorted(found))}."
        raise ConfigurationError(f"There is no {what} of the kind {kind!r}.", hint=hint)
    return found[kind]


def _load(group: str, kind: str, what: str) -> object:
    entry = _find(group, kind, what)
    try:
        return entry.load()
    except AttributeError as broken:
        raise ConfigurationError(
            f"The {what} {kind!r} is not what its package says it is.",
            hint="Install that package again.",
        ) from broken
    except ModuleNotFoundError as missing:
        raise ConfigurationError(
            f"The {what} {kind!r} needs {missing.name}, which is not installed.",
            hint=f"Install it with: {how_to_install(kind)}",
        ) from missing


@cache
def _installed(group: str) -> dict[str, EntryPoint]:
    """Look once: reading what every installed package offers takes some 20 ms each time."""
    return {entry.name: entry for entry in entry_points(group=group)}
