"""From a container to a robot and back: asked for, confirmed, checked again, written down, done.

Where files go is a folder that the operator named. A folder does not acknowledge: it is said so.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Protocol

from rosic.container import words_files as words
from rosic.container.sorts import SORTS, Sniffer, file_name
from rosic.container.words_container import age
from rosic.core.authority import FILES
from rosic.core.message import Attachment, Button, Outbound
from rosic.core.record import Decided
from rosic.errors import (
    MessengerFault,
    NotUnderstood,
    OutOfBounds,
    RobotOffline,
    RobotStopped,
    RobotTaken,
    RobotUnreachable,
)
from rosic.pipeline.desk import Reply, rows
from rosic.pipeline.files.reading import content_of
from rosic.pipeline.replies import LEAVE

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.container.drawer import Filed
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.robot import Files, Profile, RobotId
    from rosic.organiser.organiser import Organiser
    from rosic.pipeline.containers.parts import Holdings
    from rosic.pipeline.files.receiving import Plain
    from rosic.pipeline.office import Asked

MOST_SHOWN: Final = 10
SHOWN_FROM_BYTES: Final = 1_000_000


class Folders(Protocol):
    """Inboxes and outboxes; `rosic.robots.folders`. Each raises RobotUnreachable."""

    async def put(self, robot: RobotId, name: str, content: bytes, digest: bytes) -> bool:
        """Put a file there, whole; False when there is one of that name."""
        ...

    async def names(self, robot: RobotId, most: int) -> tuple[tuple[str, int, int], ...]:
        """Return name, size and time (ns) of what there is, the newest first."""
        ...

    async def get(self, robot: RobotId, name: str, most: int) -> bytes | None:
        """Return a file's content; None when it is larger."""
        ...


class Handing:
    """The clerk of ``/files send`` and ``/files from``."""

    def __init__(
        self,
        holdings: Holdings,
        organiser: Organiser,
        profiles: Mapping[RobotId, Profile],
        folders: Folders,
        plain: Plain,
        stopped: Callable[[RobotId], bool],
    ) -> None:
        self._holdings = holdings
        self._organiser = organiser
        self._profiles = profiles
        self._folders = folders
        self._plain = plain
        self._stopped = stopped

    def offer(self, principal: PrincipalId, filed: Filed) -> list[Button]:
        """Return a button for each robot that takes such a file from this person."""
        able = [
            robot
            for robot in sorted(self._holdings.visible(principal))
            if self._fits(robot, filed) and self._organiser.allows(principal, robot, FILES)
        ]
        return [
            Button(words.to_robot(self._profiles[r].shown), f"/files send {filed.name} to {r}")
            for r in able[:MOST_SHOWN]
        ]

    def _fits(self, robot: RobotId, filed: Filed) -> bool:
        takes = self._profiles[robot].files
        return (
            takes is not None
            and bool(takes.inbox)
            and filed.sort in takes.accept
            and filed.size <= takes.max_mb * words.MB
        )

    # ---- there ----

    async def send(self, asked: Asked, rest: str) -> Reply:
        """Ask whether a file is to be put into a robot's inbox.

        Raises:
            Refusal: It may not, or does not fit. Nothing was done.
        """
        name, _, said = rest.rpartition(" to ")
        if not name:
            raise NotUnderstood(words.HOW, offers=("/files",))
        robot = self._robot(asked, said)
        filed = self._holdings.files.find(asked.caller.principal, name)
        self._check(asked.caller, robot, filed)
        shown = self._profiles[robot].shown
        text = words.put_question(filed.name, filed.size, filed.digest, shown)
        yes = Button(words.PUT, f"/files put {filed.id} {robot}")
        return Reply(text, ((yes, Button(words.LEAVE_IT, LEAVE)),))

    async def put(self, asked: Asked, rest: str) -> Reply:
        """Put a file there, after a tap on the question; what counts is what is so now.

        Raises:
            Refusal: It was typed, or may not be done any more. Nothing was done.
        """
        file, _, robot = rest.partition(" ")
        principal, holdings = asked.caller.principal, self._holdings
        filed = next((one for one in holdings.files.of(principal) if one.id == file), None)
        if asked.inbound.nonce is None or filed is None or robot not in self._profiles:
            raise NotUnderstood(words.HOW, offers=("/files",))
        self._check(asked.caller, robot, filed)
        shown = self._profiles[robot].shown
        await self._show(asked, filed, shown)
        content = await content_of(holdings.vault, filed)
        async with holdings.changes.turn() as turn:
            self._check(asked.caller, robot, filed)  # a right may have ended meanwhile
            now_ns = holdings.clock.wall_ns()
            decided = Decided(
                act="file-to-robot", by=principal, about=robot, at_ns=now_ns, digest=filed.digest
            )
            await turn.write((decided,))
        try:
            done = await self._folders.put(robot, filed.name, content, filed.digest)
        except RobotUnreachable as fault:
            raise RobotOffline(fault.sentence) from fault
        if not done:
            raise NotUnderstood(words.name_taken(filed.name, shown))
        return Reply(words.put_there(filed.name, filed.digest, shown))

    async def _show(self, asked: Asked, filed: Filed, shown: str) -> None:
        """Say that something large is on its way, in the message that asked."""
        if filed.size < SHOWN_FROM_BYTES or not asked.messenger.edits or not asked.inbound.under:
            return
        text = self._plain(asked.inbound, words.putting(filed.name, filed.size, shown))
        with suppress(MessengerFault):
            outbound = Outbound(chat=asked.inbound.chat, text=text)
            await asked.messenger.edit(asked.inbound.under, outbound)

    def _check(self, caller: Caller, robot: RobotId, filed: Filed) -> None:
        profile = self._profiles[robot]
        takes = self._files_of(robot)
        self._organiser.check_files(caller, robot)
        if not takes.inbox:
            raise NotUnderstood(words.takes_none(profile.shown))
        if filed.sort not in takes.accept:
            raise OutOfBounds(words.takes_others(profile.shown, filed.sort, takes.accept))
        if filed.size > takes.max_mb * words.MB:
            most = int(takes.max_mb * words.MB)
            raise OutOfBounds(words.too_large_for(profile.shown, filed.size, most))
        # What lies in an inbox may set a robot going: what holds for moving it holds for that.
        if self._stopped(robot):
            raise RobotStopped(words.is_stopped(profile.shown), offers=(f"resume {robot}",))
        holder = self._organiser.holder(robot)
        if holder not in {None, caller.principal}:
            name = self._holdings.name(holder or "")
            raise RobotTaken(words.is_taken(profile.shown, name))

    # ---- and back ----

    async def fetch(self, asked: Asked, rest: str) -> Reply:
        """List what a robot gives, or hand one file of it over.

        Raises:
            Refusal: They may not, there is none, or it is nothing that is handed on.
        """
        said, _, name = rest.partition(" ")
        robot = self._robot(asked, said)
        self._organiser.check_files(asked.caller, robot)
        if not self._files_of(robot).outbox:
            raise NotUnderstood(words.gives_none(self._profiles[robot].shown))
        try:
            return await (self._one(asked, robot, name) if name else self._all(robot))
        except RobotUnreachable as fault:
            raise RobotOffline(fault.sentence) from fault

    async def _all(self, robot: RobotId) -> Reply:
        found = await self._folders.names(robot, MOST_SHOWN)
        shown = self._profiles[robot].shown
        if not found:
            return Reply(words.gives_nothing_now(shown))
        now_ns = self._holdings.clock.wall_ns()
        lines = [
            words.given_line(_shown(name), size, age((now_ns - at_ns) / 1e9))
            for name, size, at_ns in found
        ]
        buttons = [
            Button(_shown(name), f"/files from {robot} {_shown(name)}") for name, _, _ in found
        ]
        return Reply(words.gives(shown, lines), rows(buttons))

    async def _one(self, asked: Asked, robot: RobotId, name: str) -> Reply:
        found = await self._folders.names(robot, MOST_SHOWN)
        match = next((own for own, _, _ in found if _shown(own) == name.strip()), None)
        if match is None:
            raise NotUnderstood(words.no_such_file(name), offers=(f"/files from {robot}",))
        most = asked.messenger.file_bytes
        content = await self._folders.get(robot, match, most)
        if content is None:
            size = next(size for own, size, _ in found if own == match)
            raise OutOfBounds(words.too_large_to_send(_shown(match), size, most))
        sniffer = Sniffer()
        sniffer.feed(content)
        sort = sniffer.sort(match)
        if sort is None:
            raise NotUnderstood(words.unknown(sorted(SORTS)))
        digest = hashlib.sha256(content).digest()
        now_ns = self._holdings.clock.wall_ns()
        async with self._holdings.changes.turn() as turn:
            by = asked.caller.principal
            decided = Decided(
                act="file-from-robot", by=by, about=robot, at_ns=now_ns, digest=digest
            )
            await turn.write((decided,))
        called = file_name(match, sort)
        text = words.handed(called, len(content), digest)
        return Reply(text, attachment=Attachment(called, sort.media_type, content))

    # ---- which ----

    def _robot(self, asked: Asked, said: str) -> RobotId:
        wanted = " ".join(said.split()).casefold()
        for robot in sorted(self._holdings.visible(asked.caller.principal)):
            if wanted in {robot, self._profiles[robot].shown.casefold()}:
                return robot
        raise NotUnderstood(words.no_such_robot(said))

    def _files_of(self, robot: RobotId) -> Files:
        files = self._profiles[robot].files
        if files is None:
            raise NotUnderstood(words.takes_none(self._profiles[robot].shown))
        return files


def _shown(name: str) -> str:
    """Return a name of somebody else's folder as it is shown and asked for."""
    return file_name(name, SORTS["text"]._replace(endings=(_ending(name),)))


def _ending(name: str) -> str:
    _, dot, ending = name.casefold().rpartition(".")
    return ending if dot and ending.isalnum() and ending.isascii() and len(ending) <= 8 else "txt"  # noqa: PLR2004
