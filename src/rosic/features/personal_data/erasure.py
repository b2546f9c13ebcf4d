"""Erasing a person: rights first, then motion, then everything that names them or repeats them.

What stays: ids, numbers and digests in the record of commands and decisions.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.message import Chat
from rosic.core.records import Decided, Fact, Record
from rosic.core.robot.profile import RobotId
from rosic.errors import NotPermitted, NotUnderstood, RecordUnavailable, RobotBusy, StoreFault
from rosic.features.personal_data import messages as words

if TYPE_CHECKING:
    from rosic.gateway.container_context import ContainerContext

KIND: Final = "erased"
REST_WITHIN_S: Final = 10.0
LOOK_EVERY_S: Final = 0.1

log = logging.getLogger("rosic.personal_data")


class ErasureQueries(msgspec.Struct, frozen=True, kw_only=True):
    """What the other rooms do when somebody is erased; none of them waits but `ended`.

    Attributes:
        known: Whether there is somebody of that id.
        is_last_admin: Whether nobody else gives rights here.
        ends: Returns the records that end what the other rooms keep for somebody: keys, grants,
            times, waiting, invitations, second factors. Called with them and whoever lets it
            happen; it changes nothing.
        ended: Ends what they have in hand: leases and motion. Called when the records are in force.
        busy: Whether an order of theirs has not ended yet, or its end is not written down.
        in_use: Returns the name of whoever has a robot now, or what it does; empty: it is free.
        stray: Whether a container belongs to nobody who is known, or asks to come in.
        forget: Takes their name, addresses, sessions and choices out of memory.
        theirs: Whether a private chat is theirs.
    """

    known: Callable[[PrincipalId], bool]
    is_last_admin: Callable[[PrincipalId], bool]
    ends: Callable[[PrincipalId, PrincipalId], Iterable[Record]]
    ended: Callable[[PrincipalId], Awaitable[object]]
    busy: Callable[[PrincipalId], bool]
    in_use: Callable[[RobotId], str]
    stray: Callable[[str], bool]
    forget: Callable[[PrincipalId], object]
    theirs: Callable[[PrincipalId, Chat], bool]


class Erased(msgspec.Struct, frozen=True):
    """What came of it.

    Attributes:
        at_rest: Every order of theirs had ended when the key was shredded.
    """

    name: str
    at_rest: bool


class _Body(msgspec.Struct, frozen=True):
    """Body of the fact that somebody was erased; its key is their id.

    Attributes:
        done: Their key was shredded when nothing of theirs was under way any more.
    """

    at_ns: int
    done: bool


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(_Body).decode


class ErasureCommands:
    """Erases people; goes on after a restart where it was interrupted."""

    def __init__(self, data_context: ContainerContext, sides: ErasureQueries) -> None:
        self._data_context = data_context
        self._sides = sides
        self._bodies: dict[PrincipalId, _Body] = {}

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is done again."""
        try:
            self._bodies[fact.key] = _decode(fact.body)
        except msgspec.MsgspecError:
            self._bodies[fact.key] = _Body(0, done=False)

    def is_erased(self, principal: PrincipalId) -> bool:
        """Whether somebody was erased, or is about to be."""
        return principal in self._bodies

    def check(self, principal: PrincipalId, by: PrincipalId) -> None:
        """See that somebody can be erased.

        Raises:
            NotUnderstood: There is nobody of that id.
            NotPermitted: The last admin. Nothing was changed.
        """
        if not self._sides.known(principal) or self.is_erased(principal):
            raise NotUnderstood(words.NOBODY)
        if self._sides.is_last_admin(principal):
            own = principal == by
            name = self._data_context.name(principal)
            raise NotPermitted(words.LAST_ADMIN if own else words.last_admin(name))

    async def erase(self, principal: PrincipalId, by: PrincipalId) -> Erased:
        """Erase somebody: their rights end, their robots come to rest, their key is shredded.

        Args:
            principal: Whom.
            by: Who lets it happen: themselves, or the operator.

        Raises:
            NotUnderstood, NotPermitted: As `check`; nothing was changed.
            RecordUnavailable: The record cannot be written. Either nothing was changed, or their
                rights have ended and the rest is tried again, now and after every start; the
                sentence says which.
        """
        data_context = self._data_context
        async with data_context.changes.turn() as turn:
            self.check(principal, by)
            name = data_context.name(principal)
            await turn.write(self._records(principal, by))
        await self._sides.ended(principal)
        at_rest = await self._rested(principal)
        self._sides.forget(principal)
        try:
            await self._shred(principal, done=at_rest)
        except (StoreFault, RecordUnavailable) as fault:
            log.exception("somebody could not be erased from the record yet; it is tried again")
            raise RecordUnavailable(words.NOT_ERASED_YET) from fault
        return Erased(name, at_rest)

    def _records(self, principal: PrincipalId, by: PrincipalId) -> tuple[Record, ...]:
        """Return everything that ends at once, in one write."""
        data_context, now_ns = self._data_context, self._data_context.clock.wall_ns()
        return (
            Decided(act="erase", by=by, about=principal, at_ns=now_ns),
            Fact(kind=KIND, key=principal, body=_encode(_Body(now_ns, done=False))),
            *self._sides.ends(principal, by),
            *data_context.preferences.unset(principal),
            *data_context.shelf.end_all(principal),
            *data_context.command_history.end_all(principal),
            *data_context.files.end_all(principal),
            *data_context.archive.end_private(lambda chat: self._sides.theirs(principal, chat)),
        )

    async def _rested(self, principal: PrincipalId) -> bool:
        """Wait until nothing of theirs is under way: what is told later is sealed, too."""
        clock = self._data_context.clock
        until_ns = clock.monotonic_ns() + int(REST_WITHIN_S * 1e9)
        while self._sides.busy(principal):
            if clock.monotonic_ns() >= until_ns:
                return False
            await clock.sleep(LOOK_EVERY_S)
        await asyncio.sleep(0)
        return True

    async def _shred(self, principal: PrincipalId, *, done: bool) -> None:
        await self._data_context.container_store.shred(principal)
        if done:
            body = _encode(_Body(self._bodies[principal].at_ns, done=True))
            async with self._data_context.changes.turn() as turn:
                await turn.write((Fact(kind=KIND, key=principal, body=body),))

    @property
    def unfinished(self) -> bool:
        """Whether somebody's last order had not ended when their key was shredded."""
        return not all(body.done for body in self._bodies.values())

    async def stranger(self, principal: PrincipalId) -> None:
        """Shred what was kept of somebody who asked to come in and was not let in.

        What fails is logged; `strays` finds it again.
        """
        try:
            await self._data_context.container_store.shred(principal)
        except StoreFault:
            log.exception("what was kept of somebody not let in could not be erased yet")

    async def strays(self) -> int:
        """Shred what is left of people who were never let in. Return how many.

        Raises:
            StoreFault: Not all could be; the rest is tried the next time.
        """
        # Nobody comes in meanwhile: their container would be there before they are known.
        async with self._data_context.changes.turn():
            container_store = self._data_context.container_store
            found = [name for name in await container_store.containers() if self._sides.stray(name)]
            for name in found:
                await container_store.shred(name)
        return len(found)

    async def finish(self) -> int:
        """Shred again whatever was not done to the end: at the start, and as soon as it can be.

        Returns:
            How many were finished. What fails is logged and tried the next time.
        """
        finished = 0
        for principal, body in tuple(self._bodies.items()):
            if body.done:
                continue
            done = not self._sides.busy(principal)
            self._sides.forget(principal)  # at a start, their card was readable still
            try:
                await self._shred(principal, done=done)
            except (StoreFault, RecordUnavailable):
                log.exception("somebody could not be erased from the record yet")
            else:
                finished += done
        return finished

    async def erase_other(self, container: str, by: PrincipalId) -> None:
        """Erase the container of a robot or of a chat; a person's is erased by `erase`.

        Raises:
            NotUnderstood: It is a person's, or there is none.
            RobotBusy: Somebody has the robot now. Nothing was erased.
            RecordUnavailable: Not erased, or not wholly; doing it again is safe.
        """
        data_context = self._data_context
        chat = container.removeprefix("chat-")
        if container not in data_context.robots and chat not in data_context.archive.all():
            raise NotUnderstood(words.NO_SUCH_CONTAINER)
        used = self._sides.in_use(container) if container in data_context.robots else ""
        if used:
            raise RobotBusy(words.in_use(data_context.shown(container), used))
        now_ns = data_context.clock.wall_ns()
        ends = (
            data_context.shelf.end_all(container)
            if container in data_context.robots
            else data_context.archive.drop(chat)
        )
        async with data_context.changes.turn() as turn:
            decided = Decided(act="erase", by=by, about=container, at_ns=now_ns)
            await turn.write((decided, *ends))
        try:
            await data_context.container_store.shred(container)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault
