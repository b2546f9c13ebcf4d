"""Robots that were added while a gateway ran: on the record, with their profiles.

A profile says what a machine is and names nobody, so it stands in the open part of the record:
erasing what a robot's container holds does not make the robot go.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec
from msgspec.structs import replace

from rosic.config.plugins import same_robot
from rosic.config.profile_validation import clash
from rosic.config.profiles import read_profile_text
from rosic.core.language.compiled import fold
from rosic.core.records import Fact
from rosic.errors import NotUnderstood
from rosic.features.fleet import added_robot_messages as words
from rosic.gateway.robot_registry import TEXT_BYTES, ProfileDraft

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.app.settings import GatewaySettings
    from rosic.config.profiles import ReadProfile
    from rosic.core.language import UnitTable
    from rosic.core.robot.profile import Profile


# ---- robots added while a gateway ran ----

KIND: Final = "robot"

log = logging.getLogger("rosic.fleet")


class AddRobotRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A robot that somebody wants to add.

    Attributes:
        role: In which it speaks with the other robots; empty: it does not.
    """

    draft: ProfileDraft
    role: str = ""


_decode = msgspec.msgpack.Decoder(ProfileDraft).decode


def fact_of(robot: str, draft: ProfileDraft) -> Fact:
    """Return what makes a robot known to every later start."""
    return Fact(kind=KIND, key=robot, body=draft.encoded())


def read_draft(draft: ProfileDraft, units: UnitTable) -> ReadProfile:
    """Read a profile as ``rosic robot check`` does. Never raises."""
    return read_profile_text(draft.text, draft.name, units, link=draft.link)


def check_draft(draft: ProfileDraft, units: UnitTable) -> tuple[Profile, Sequence[str]]:
    """Return the robot of a profile, and what could be better about it.

    Raises:
        NotUnderstood: Everything that is wrong with it, each in a line.
    """
    if len(draft.text.encode(errors="replace")) > TEXT_BYTES:
        raise NotUnderstood(words.TOO_LONG)
    read = read_draft(draft, units)
    if read.profile is None:
        raise NotUnderstood(words.wrong(map(str, read.errors)))
    for alert in read.profile.alerts:
        if alert.author:
            raise NotUnderstood(words.names_somebody(alert.name, alert.author))
    return read.profile, tuple(map(str, read.advice))


def check_distinct(newcomer: Profile, known: Iterable[Profile]) -> None:
    """See that a robot is not here already, and cannot be taken for another: id, title, names.

    Raises:
        NotUnderstood: Whose it is already.
    """
    space = newcomer.link.namespace.strip("/")
    for robot in known:
        if robot.id == newcomer.id:
            raise NotUnderstood(words.same_id(robot.id))
        if {newcomer.id, fold(newcomer.shown)} & {robot.id, fold(robot.shown)}:
            raise NotUnderstood(words.same_title(newcomer.shown, robot.id))
        if space and robot.link.namespace.strip("/") == space:
            raise NotUnderstood(words.same_namespace(newcomer.link.namespace, robot.shown))
        for found in same_robot((robot, newcomer)):
            raise NotUnderstood(words.same_robot(robot.shown, newcomer.shown, found.name))


def with_added(
    configured: tuple[Profile, ...], facts: Iterable[Fact], units: UnitTable
) -> tuple[Profile, ...]:
    """Return the robots of a configuration, and those that were added since.

    What the configuration names it decides about. A robot that cannot be read any more, or taken
    for another, is left out and logged: it stops nobody from starting.
    """
    ids = {profile.id for profile in configured}
    added = [one for one in (_recalled(fact, units) for fact in facts) if one is not None]
    wanted = [profile for profile in added if profile.id not in ids]
    for profile in added:
        if profile.id in ids:
            log.info("%s is in the configuration now, which decides about it", profile.id)
    twice = {found.other.id: found for found in same_robot((*configured, *wanted))}
    for found in twice.values():
        log.warning("%s, added earlier, is left out: %s", found.other.id, found.sentence)
    wanted = [profile for profile in wanted if profile.id not in twice]
    if not wanted or not clash((*configured, *wanted), units):
        return (*configured, *wanted)
    good = list(configured)
    for profile in wanted:
        if why := clash((*good, profile), units):
            log.warning("%s, added earlier, is left out: %s", profile.id, why)
        else:
            good.append(profile)
    return tuple(good)


def settings_with_added(
    settings: GatewaySettings, facts: Iterable[Fact], units: UnitTable
) -> GatewaySettings:
    """Return the settings of a gateway with the robots that were added since; see `with_added`.

    An added robot is asked as often as any that the configuration says nothing else about.
    """
    robots, limit = with_added(settings.profiles, facts, units), settings.robot_limit
    limits = dict(settings.robot_limits)
    if limit is not None:
        limits.update((robot.id, limit) for robot in robots[len(settings.profiles) :])
    return replace(settings, profiles=robots, robot_limits=limits)


def _recalled(fact: Fact, units: UnitTable) -> Profile | None:
    if not fact.body:
        return None
    try:
        profile = check_draft(_decode(fact.body), units)[0]
    except (msgspec.MsgspecError, NotUnderstood) as why:
        log.warning("%s, added earlier, is left out: %s", fact.key, why)
        return None
    return profile if profile.id == fact.key else None
