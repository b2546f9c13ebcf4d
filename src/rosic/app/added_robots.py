"""Robots that were added while a gateway ran: on the record, with their profiles.

A profile says what a machine is and names nobody, so it stands in the open part of the record:
erasing what a robot's container holds does not make the robot go.
"""

from __future__ import annotations

import logging
import re
from hashlib import blake2b
from typing import TYPE_CHECKING, Final, Protocol

import msgspec
from msgspec.structs import replace

from rosic.config.profile_validation import clash
from rosic.config.profiles import read_profile_text
from rosic.core import messages as core_words
from rosic.core.i18n import joined
from rosic.core.language.compiled import fold
from rosic.core.language.option_words import option_typed
from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.records import Fact
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access.admin_policy import FOR_GOOD_NS
from rosic.features.files.content import content_of
from rosic.features.fleet import added_robot_messages as words
from rosic.features.fleet.task_commands import ASSIGN
from rosic.gateway.commands import Reply, check_private

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.app.gateway_parts import RunningGateway
    from rosic.app.settings import GatewaySettings
    from rosic.config.profiles import ReadProfile
    from rosic.container.files import StoredFile
    from rosic.core.identity import PrincipalId
    from rosic.core.language import UnitTable
    from rosic.core.message import Button
    from rosic.core.robot.profile import Profile
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext
    from rosic.organiser.organiser import Organiser


# ---- robots added while a gateway ran ----

KIND: Final = "robot"
TEXT_BYTES: Final = 131_072
DIGEST_BYTES: Final = 16

log = logging.getLogger("rosic.fleet")


class ProfileDraft(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A profile as it was handed over; also the body of the fact.

    Attributes:
        text: What stands in the file.
        name: Of the file, without its folder, for saying where something is wrong.
        link: Reach the robot by this adapter, whatever the file says; empty: as it says.
    """

    text: str
    name: str
    link: str = ""

    @property
    def digest(self) -> bytes:
        """What stands for it in the log of decisions."""
        return blake2b(_encode(self), digest_size=DIGEST_BYTES).digest()


class AddRobotRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A robot that somebody wants to add.

    Attributes:
        role: In which it speaks with the other robots; empty: it does not.
    """

    draft: ProfileDraft
    role: str = ""


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(ProfileDraft).decode


def fact_of(robot: str, draft: ProfileDraft) -> Fact:
    """Return what makes a robot known to every later start."""
    return Fact(kind=KIND, key=robot, body=_encode(draft))


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
    """See that a robot cannot be taken for another: id, title, namespace.

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


DIGEST_LETTERS: Final = 16
AS: Final = "as"
_DIGEST: Final = re.compile(rf"[0-9a-f]{{{DIGEST_LETTERS}}}", re.IGNORECASE)


class RobotAdder(Protocol):
    """Adds robots to a gateway that runs."""

    async def check(self, draft: ProfileDraft, role: str = "") -> tuple[Profile, Sequence[str]]:
        """Return the robot of a profile that nobody would take for another, and advice about it.

        Raises:
            NotUnderstood: Everything that is wrong with it.
        """
        ...

    async def add(self, draft: ProfileDraft, by: PrincipalId, role: str = "") -> str:
        """Add a robot. Return what is said of it.

        Raises:
            Refusal: Why not. Nothing was changed.
        """
        ...


class AddRobotFromChat:
    """Adds robots for whoever may both assign tasks and give rights: rights reach it at once.

    Args:
        robot_adder: Adds them.
        data_context: Where people's files are.
        organiser: Says who may.
    """

    def __init__(
        self, robot_adder: RobotAdder, data_context: ContainerContext, organiser: Organiser
    ) -> None:
        self._robot_adder = robot_adder
        self._data_context = data_context
        self._organiser = organiser

    def offer(self, principal: PrincipalId, filed: StoredFile) -> list[Button]:
        """Return the button that adds a robot from a file that was sent, if it may be that."""
        mine = filed.name.casefold().endswith(words.SUFFIXES) and self._may(principal)
        return [words.add_button(filed.name)] if mine else []

    async def add(self, asked: CommandContext, said: str) -> Reply:
        """Show what a profile would add, or add what was shown.

        Args:
            asked: By whom.
            said: The name of a file of theirs; ``as`` a role, if the robot is to speak with the
                others; and the beginning of its digest once it was shown.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        check_private(asked)
        principal = asked.caller.principal
        if not self._may(principal):
            raise NotPermitted(words.MAY_NOT)
        name, role, shown = _read(said)
        if role and not self._may(principal, FOR_GOOD_NS):
            raise NotPermitted(words.ROLE_FOR_GOOD)
        filed = self._data_context.files.find(principal, name)
        draft = await self._draft(filed)
        profile, advice = await self._robot_adder.check(draft, role)
        _check_folders(profile)
        digest = filed.digest.hex()[:DIGEST_LETTERS]
        if not shown:
            asks = (words.would_add(profile), words.would_speak(filed.name, role))
            text = joined("\n", (*asks, core_words.help_for(profile), *advice))
            return Reply(text, words.confirm_buttons(filed.name, role, digest))
        if shown != digest:
            raise NotUnderstood(words.CHANGED, offers=(words.add_command(filed.name, role),))
        return Reply(await self._robot_adder.add(draft, principal, role), about=profile.id)

    def _may(self, principal: PrincipalId, at_ns: int | None = None) -> bool:
        organiser = self._organiser
        now_ns = organiser.wall_ns() if at_ns is None else at_ns
        return all(organiser.rights.holds(principal, FLEET, w, now_ns) for w in (ASSIGN, GRANT))

    async def _draft(self, filed: StoredFile) -> ProfileDraft:
        if filed.size > TEXT_BYTES:
            raise NotUnderstood(words.TOO_LONG)
        content = await content_of(self._data_context.container_store, filed)
        try:
            return ProfileDraft(text=content.decode("utf-8-sig"), name=filed.name)
        except UnicodeDecodeError:
            raise NotUnderstood(words.NO_TEXT) from None


def _read(said: str) -> tuple[str, str, str]:
    """Return the file, the role and the digest that were said; empty where they were not."""
    words_said, role, digest = said.split(), "", ""
    if len(words_said) > 1 and _DIGEST.fullmatch(words_said[-1]):
        digest = words_said.pop().casefold()
    *name, last_but_one, last = ("", "", *words_said)
    if any(name) and option_typed(last_but_one.casefold()) == AS and "." not in last:
        words_said, role = words_said[:-2], last
    return " ".join(words_said), role, digest


def newcomers_of(gateway: RunningGateway, robot_adder: RobotAdder) -> None:
    """Let robots be added from files, where files are kept."""
    data_feature = gateway.data_feature
    if data_feature.data_context is not None and data_feature.receiving is not None:
        newcomers = AddRobotFromChat(
            robot_adder, data_feature.data_context, gateway.rooms.organiser
        )
        gateway.features.fleet.robots.newcomer = newcomers.add
        data_feature.receiving.offer_too(newcomers.offer)


def _check_folders(profile: Profile) -> None:
    """See that a profile from a chat names no folder of this computer.

    Raises:
        NotPermitted: It does; whoever may that in a chat could write anywhere here.
    """
    files = profile.files
    if files is not None and (files.inbox or files.outbox):
        raise NotPermitted(words.names_folders(profile.shown))
