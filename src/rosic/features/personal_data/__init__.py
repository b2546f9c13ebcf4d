"""What is kept of people: their settings, data, history and archives, and how it is erased."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.authoriser.directory import SOMEBODY
from rosic.container.messages import SETTINGS_DAMAGED
from rosic.container.preferences import IMPERIAL
from rosic.container.preferences import KIND as PREFERENCE
from rosic.core.identity import Principal
from rosic.core.language import skills_of
from rosic.errors import Refusal
from rosic.features.personal_data.commands import register_commands, take_over, tidy
from rosic.features.personal_data.erasure import ErasureCommands, ErasureQueries
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import Address, PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Fact, Record
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["PersonalDataFeature", "setup"]

PROVIDES: Final = ("history",)

PERSON = re.compile("p[0-9a-f]{16}")  # how ids of people look


class PersonalDataFeature(Feature):
    """What is kept of people, by their own settings.

    Attributes:
        erasing: Erases somebody.
        containers: What is kept.
    """

    def __init__(
        self, kernel: Kernel, containers: ContainerContext, erasing: ErasureCommands
    ) -> None:
        self.erasing, self.containers = erasing, containers
        self._preferences, self._policy = kernel.preferences, kernel.enforcer.policy
        self._languages = kernel.orders.chat_sender.languages
        self._reach = kernel.reach
        for principal in self._policy.grants_book.everybody():
            self._speak_to(principal)
        kernel.changes.keep(PREFERENCE, self._changed)

    def _changed(self, fact: Fact) -> None:
        """Let what people set for themselves count: a cap on their speed, words, units.

        Only a cap is of the rules: what somebody agreed to outlives a change of words.
        """
        before = self._preferences.limits(fact.key)
        self._preferences.apply(fact)
        self._speak_to(fact.key)
        if self._preferences.limits(fact.key) != before:
            self._policy.renew(fact.key)

    def _speak_to(self, principal: PrincipalId) -> None:
        kept = self._preferences.of(principal)
        imperial = kept.units == IMPERIAL
        self._languages.choose(principal, kept.language, imperial=imperial)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Let people's own speed hold for one more robot, after the rights reach it."""
        profile = newcomer.profile
        for principal in self._preferences.add_robot(profile.id, skills_of(profile)):
            self._policy.renew(principal)

    async def restore(self) -> None:
        """Finish what an erasure has left, and tell people whose settings cannot be read."""
        await self.erasing.finish()
        self._reach.tell(self._preferences.damaged(), SETTINGS_DAMAGED)

    async def each_minute(self) -> None:
        """Finish erasing whoever still had an order under way; keep what people often ask.

        Raises:
            RecordUnavailable: Not all could be written; the rest is tried the next time.
        """
        containers = self.containers
        if command_history := containers.command_history.unwritten():
            async with containers.changes.turn() as turn:
                await turn.write(command_history)
        if self.erasing.unfinished:
            await self.erasing.finish()

    async def each_day(self) -> None:
        """Forget what was kept as long as was said.

        Raises:
            RecordUnavailable: Not all was forgotten; the rest is tried the next time.
        """
        await tidy(self.containers, self.erasing)

    async def leave(self) -> None:
        """Keep what people often ask; at the end, and as far as it can be."""
        with suppress(Refusal):
            await self.each_minute()


def setup(kernel: Kernel) -> Feature:
    """Take over what is kept of people, and take the commands, where the record can keep it."""
    containers = kernel.containers
    if containers is None:
        return Feature()
    erasing = ErasureCommands(containers, _erasure_queries(kernel))
    history = register_commands(kernel.commands, containers, erasing)
    kernel.shared.history.provide(history)
    take_over(kernel.memory.facts, containers, erasing)
    kernel.access.forget_newcomer.bind(erasing.stranger)

    def end_archive(_principal: PrincipalId, address: Address) -> None:
        """Keep nothing more of what is said in an account that somebody has lost."""
        theirs = partial(_is_private_chat, kernel, address)
        kernel.changes.note(containers.archive.end_private(theirs))

    kernel.access.account_lost.connect(end_archive)
    return PersonalDataFeature(kernel, containers, erasing)


def _is_private_chat(kernel: Kernel, address: Address, chat: Chat) -> bool:
    """Whether a chat is an account's own: by the account's id, or as its messenger finds it."""
    if chat.platform != address.platform:
        return False
    found = (place.chat.id for place in kernel.reach.places_of(address))
    return chat.id in {address.account, *found}


def _erasure_queries(kernel: Kernel) -> ErasureQueries:
    rooms, access, enforcer = kernel.rooms, kernel.access, kernel.enforcer
    directory, invitations = rooms.authoriser.directory, access.enrolment.invitations

    def ends(principal: PrincipalId, by: PrincipalId) -> Iterable[Record]:
        good = (key for key in access.keys.of(principal) if key.revoked_ns is None)
        made = [i for i in invitations.open() if i.issuer == principal]
        is_set_up = access.two_factor.is_set_up(principal)
        return (
            *(r for i in made for r in invitations.withdraw(i.id, by)),
            *(access.two_factor.reset(principal, by) if is_set_up else ()),
            *enforcer.policy.grants_book.take(principal, by),
            *access.ahead(principal),
            *kernel.erasure.records(principal),
            *(r for key in good for r in access.keys.revoke(key.id, by).records),
        )

    def forget(principal: PrincipalId) -> None:
        directory.enrol(Principal(id=principal, name=SOMEBODY))
        rooms.authoriser.forget(principal)
        rooms.container.forget(principal)
        kernel.pipeline.command_history.forget(principal)

    async def ended(principal: PrincipalId) -> None:
        enforcer.enforce()
        await kernel.erasure.end(principal)

    def theirs(principal: PrincipalId, chat: Chat) -> bool:
        person = directory.person(principal)
        accounts = () if person is None else person.addresses
        return any(_is_private_chat(kernel, address, chat) for address in accounts)

    def in_use(robot: RobotId) -> str:
        holder = rooms.organiser.holder(robot)
        return directory.name(holder) if holder else rooms.linker.presence(robot).doing

    def stray(container: str) -> bool:
        asking = {a.pending.principal for a in access.enrolment.applicants.all()}
        newcomer = PERSON.fullmatch(container) is not None and container not in asking
        return newcomer and directory.person(container) is None

    return ErasureQueries(
        known=lambda who: directory.person(who) is not None,
        is_last_admin=access.is_only_admin,
        ends=ends,
        ended=ended,
        busy=kernel.pipeline.executor.busy,
        in_use=in_use,
        stray=stray,
        forget=forget,
        theirs=theirs,
    )
