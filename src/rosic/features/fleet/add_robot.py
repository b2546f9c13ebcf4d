"""``/robot add FILE``: a robot that nobody knows yet, from a profile that somebody has sent."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.container.files import content_of
from rosic.core import messages as core_words
from rosic.core.i18n import joined
from rosic.core.language.keywords import option_typed
from rosic.core.policy.compiled import FOR_GOOD_NS
from rosic.core.policy.scope import FLEET, GRANT
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.fleet import added_robot_messages as words
from rosic.features.fleet.task_commands import ASSIGN
from rosic.gateway.commands import Reply, asks_first, check_private
from rosic.gateway.robot_registry import TEXT_BYTES, ProfileDraft

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.files import StoredFile
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.message import Button
    from rosic.core.robot.profile import Profile
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.robot_registry import RobotAdder
    from rosic.organiser.organiser import Organiser

DIGEST_LETTERS: Final = 16
AS: Final = "as"
_DIGEST: Final = re.compile(rf"[0-9a-f]{{{DIGEST_LETTERS}}}", re.IGNORECASE)


class AddRobotFromChat:
    """Adds robots for whoever may both assign tasks and give rights: rights reach it at once.

    Args:
        robot_adder: Returns who adds them.
        data_context: Where people's files are.
        organiser: Says who may.
    """

    def __init__(
        self,
        robot_adder: Callable[[], RobotAdder],
        data_context: ContainerContext,
        organiser: Organiser,
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
        name, role, shown = _read(said)
        self._check_right(principal, role)
        filed = self._data_context.files.find(principal, name)
        draft = await self._draft(filed)
        profile, advice = await self._robot_adder().check(draft, role)
        _check_folders(profile)
        digest = filed.digest.hex()[:DIGEST_LETTERS]
        if not shown:
            asks = (words.would_add(profile), words.would_speak(filed.name, role))
            text = joined("\n", (*asks, core_words.help_for(profile), *advice))
            return asks_first(text, words.confirm_buttons(filed.name, role, digest))
        if shown != digest:
            raise NotUnderstood(words.CHANGED, offers=(words.add_command(filed.name, role),))
        added = await self._robot_adder().add(
            draft, principal, partial(self._check_still, asked.caller, role), role
        )
        return Reply(added, about=profile.id)

    def _check_right(self, principal: PrincipalId, role: str) -> None:
        if not self._may(principal):
            raise NotPermitted(words.MAY_NOT)
        if role and not self._may(principal, FOR_GOOD_NS):
            raise NotPermitted(words.ROLE_FOR_GOOD)

    def _check_still(self, caller: Caller, role: str) -> None:
        self._organiser.check_unlocked(caller)
        self._check_right(caller.principal, role)

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


def _check_folders(profile: Profile) -> None:
    """See that a profile from a chat names no folder of this computer.

    Raises:
        NotPermitted: It does; whoever may that in a chat could write anywhere here.
    """
    files = profile.files
    if files is not None and (files.inbox or files.outbox):
        raise NotPermitted(words.names_folders(profile.shown))
