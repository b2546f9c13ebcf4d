"""From a container to a robot and back: asked for, confirmed, checked again, written down, done.

Where files go is a folder that the operator named, and the robot's own side, as its profile says.
What does not acknowledge is said not to; what does is compared with what was sent.
"""

from __future__ import annotations

import hashlib
import re
from contextlib import aclosing
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.container import file_messages as words
from rosic.container.file_types import SORTS, Sniffer, file_name
from rosic.container.files import IN_PIECES_FROM, content_of, pieces_of
from rosic.core.i18n import joined
from rosic.core.message import Attachment, Button, StreamedContent
from rosic.core.messages import ago
from rosic.core.policy.scope import FILES
from rosic.core.records import Decided
from rosic.core.robot.file_transfer import FileForRobot
from rosic.errors import (
    NotUnderstood,
    OutOfBounds,
    Refusal,
    RobotOffline,
    RobotStopped,
    RobotTaken,
    RobotUnreachable,
)
from rosic.features.files.background import TransferProgress, send_file
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import LEAVE
from rosic.organiser.why_stopped import may_resume

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping

    from rosic.container.files import StoredFile
    from rosic.contracts.robot import FileFolders
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.robot.file_transfer import Receipt
    from rosic.core.robot.profile import Files, Profile, RobotId
    from rosic.core.stop_registry import StopRegistry
    from rosic.features.files.background import BackgroundTransfer, Saying, Work
    from rosic.features.files.upload import Plain
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext
    from rosic.organiser.organiser import Organiser


# ---- robot outbox ----

# What robots give: looked at whole before it is handed on, and again while it goes.


class SeenFile(NamedTuple):
    """What a file is."""

    called: str
    media_type: str
    digest: bytes


class RobotOutbox:
    """Takes files out of the outboxes of all robots."""

    def __init__(self, folders: FileFolders, data_context: ContainerContext) -> None:
        self._folders = folders
        self._data_context = data_context

    async def seen(self, by: PrincipalId, robot: RobotId, own: str, size: int) -> SeenFile:
        """Find out what a robot's file is, and write down that it is handed on.

        Raises:
            Refusal: It is nothing that is handed on, or not as long as it was.
            RobotUnreachable: It cannot be read.
        """
        sniffer, digest, count = Sniffer(), hashlib.sha256(), 0
        async with aclosing(self._folders.read(robot, own)) as pieces:
            async for piece in pieces:
                sniffer.feed(piece)
                digest.update(piece)
                count += len(piece)
                if count > size:
                    break
        if count != size:
            raise NotUnderstood(words.CHANGED)
        sort = sniffer.sort(own)
        if sort is None:
            raise NotUnderstood(words.unknown(sorted(SORTS)))
        decided = Decided(
            act="file-from-robot",
            by=by,
            about=robot,
            at_ns=self._data_context.clock.wall_ns(),
            digest=digest.digest(),
        )
        async with self._data_context.changes.turn() as turn:
            await turn.write((decided,))
        return SeenFile(file_name(own, sort), sort.media_type, digest.digest())

    async def same(
        self, robot: RobotId, own: str, size: int, promised: bytes
    ) -> AsyncGenerator[bytes]:
        """Yield a file again.

        Raises:
            NotUnderstood: Before its last piece: it is another one now.
            RobotUnreachable: It cannot be read.
        """
        digest, count, held = hashlib.sha256(), 0, b""
        async with aclosing(self._folders.read(robot, own)) as pieces:
            async for piece in pieces:
                if held:
                    yield held
                held = piece
                digest.update(piece)
                count += len(piece)
                if count > size:
                    break
        if count != size or digest.digest() != promised:
            raise NotUnderstood(words.CHANGED)
        yield held


# ---- transfer ----

MOST_SHOWN: Final = 10
_TO: Final = re.compile(r"(.+) (?:to|an) (.*)")


class TransferWays(NamedTuple):
    """How files come to robots.

    Attributes:
        deliver: Hands one to the robot's side; see ``contracts.robot.deliver_of``.
        stops: Which robots are stopped.
    """

    folders: FileFolders
    deliver: Callable[[RobotId, FileForRobot], Awaitable[Receipt]]
    stops: StopRegistry


class FileTransfer:
    """The handler of ``/files send`` and ``/files from``."""

    def __init__(
        self,
        data_context: ContainerContext,
        organiser: Organiser,
        profiles: Mapping[RobotId, Profile],
        ways: TransferWays,
        plain: Plain,
        aside: BackgroundTransfer,
    ) -> None:
        self._data_context = data_context
        self._organiser = organiser
        self._profiles = profiles
        self._folders = ways.folders
        self._outboxes = RobotOutbox(ways.folders, data_context)
        self._deliver = ways.deliver
        self._stops = ways.stops
        self._plain = plain
        self._aside = aside

    def offer(self, principal: PrincipalId, filed: StoredFile) -> list[Button]:
        """Return a button for each robot that takes such a file from this person."""
        able = [
            robot
            for robot in sorted(self._data_context.visible(principal))
            if self._fits(robot, filed) and self._organiser.allows(principal, robot, FILES)
        ]
        return [
            Button(words.to_robot(self._profiles[r].shown), f"/files send {filed.name} to {r}")
            for r in able[:MOST_SHOWN]
        ]

    def _fits(self, robot: RobotId, filed: StoredFile) -> bool:
        takes = self._profiles[robot].files
        return (
            takes is not None
            and takes.takes
            and filed.sort in takes.accept
            and filed.size <= takes.max_mb * words.MB
        )

    # ---- there ----

    async def send(self, asked: CommandContext, rest: str) -> Reply:
        """Ask whether a file is to be put into a robot's inbox.

        Raises:
            Refusal: It may not, or does not fit. Nothing was done.
        """
        found = _TO.fullmatch(rest)
        if found is None:
            raise NotUnderstood(words.HOW, offers=("/files",))
        name, robot = found[1], self._robot(asked, found[2])
        filed = self._data_context.files.find(asked.caller.principal, name)
        self._check(asked.caller, robot, filed)
        shown = self._profiles[robot].shown
        ask = words.put_question if self._files_of(robot).inbox else words.deliver_question
        text = ask(filed.name, filed.size, filed.digest, shown)
        yes = Button(words.PUT, f"/files put {filed.id} {robot}")
        return asks_first(text, ((yes, Button(words.LEAVE_IT, LEAVE)),))

    async def put(self, asked: CommandContext, rest: str) -> Reply:
        """Put a file there, after a tap on the question; what counts is what is so now.

        Raises:
            Refusal: It was typed, or may not be done any more. Nothing was done.
        """
        file, _, robot = rest.partition(" ")
        principal, data_context = asked.caller.principal, self._data_context
        filed = next((one for one in data_context.files.of(principal) if one.id == file), None)
        if asked.inbound.nonce is None or filed is None or robot not in self._profiles:
            raise NotUnderstood(words.HOW, offers=("/files",))
        self._check(asked.caller, robot, filed)
        return await self._aside_if_large(
            asked,
            filed.size,
            partial(self._put, asked, filed, robot),
            partial(words.putting, filed.name, filed.size, self._profiles[robot].shown),
        )

    async def _put(
        self, asked: CommandContext, filed: StoredFile, robot: RobotId, progress: TransferProgress
    ) -> Reply:
        """Look once more, write down, put into the inbox, hand to the robot's side."""
        data_context, takes = self._data_context, self._files_of(robot)
        content = await content_of(data_context.container_store, filed) if takes.carries else b""
        async with data_context.changes.turn() as turn:
            self._check(asked.caller, robot, filed)  # a right may have ended meanwhile
            decided = Decided(
                act="file-to-robot",
                by=asked.caller.principal,
                about=robot,
                at_ns=data_context.clock.wall_ns(),
                digest=filed.digest,
            )
            await turn.write((decided,))
        shown = self._profiles[robot].shown
        if takes.inbox:
            pieces = progress.counted(pieces_of(data_context.container_store, filed))
            allowed = self._while_allowed(pieces, asked.caller, robot, filed)
            try:
                done = await self._folders.put(robot, filed.name, allowed, filed.digest)
            except RobotUnreachable as fault:
                raise RobotOffline(fault.sentence) from fault
            if not done:
                raise NotUnderstood(words.name_taken(filed.name, shown))
        if takes.deliver is None:
            return Reply(words.put_there(filed.name, filed.digest, shown))
        robot_file = FileForRobot(
            name=filed.name,
            path=self._folders.path(robot, filed.name),
            sort=filed.sort,
            size=filed.size,
            digest=filed.digest,
            content=content,
        )
        return Reply(await self._delivered(asked.caller, robot, filed, robot_file))

    async def _while_allowed(
        self, pieces: AsyncGenerator[bytes], caller: Caller, robot: RobotId, filed: StoredFile
    ) -> AsyncGenerator[bytes]:
        """Yield a file's pieces; after the last of them it appears, so it is asked once more.

        Raises:
            Refusal: It may not be there any more. Nothing is.
        """
        async with aclosing(pieces):
            async for piece in pieces:
                yield piece
        self._check(caller, robot, filed)

    async def _delivered(
        self, caller: Caller, robot: RobotId, filed: StoredFile, robot_file: FileForRobot
    ) -> str:
        """Hand it to the robot's side, once, and return what came of it."""
        shown = self._profiles[robot].shown
        try:
            self._check(caller, robot, filed)
            receipt = await self._deliver(robot, robot_file)
        except RobotUnreachable as fault:
            return joined(" ", [fault.sentence, words.perhaps(robot_file.name, shown)])
        except Refusal as why:
            if not robot_file.path:
                raise
            return words.taken_back(why.sentence, robot_file.name, shown)
        sentence = _received(robot_file, receipt, shown)
        return words.in_its_words(sentence, shown, receipt.words) if receipt.words else sentence

    def _check(self, caller: Caller, robot: RobotId, filed: StoredFile) -> None:
        profile = self._profiles[robot]
        takes = self._files_of(robot)
        self._organiser.check_unlocked(caller)
        self._organiser.check_word(caller, robot, FILES)
        if not takes.takes:
            raise NotUnderstood(words.takes_none(profile.shown))
        if filed.sort not in takes.accept:
            raise OutOfBounds(words.takes_others(profile.shown, filed.sort, takes.accept))
        if filed.size > takes.max_mb * words.MB:
            most = int(takes.max_mb * words.MB)
            raise OutOfBounds(words.too_large_for(profile.shown, filed.size, most))
        # What lies in an inbox may set a robot going: what holds for moving it holds for that.
        if self._stops[robot].latched:
            barred = self._stops.barred(robot)
            if barred is not None:
                raise barred
            may = may_resume(self._organiser, self._stops, caller.principal, robot)
            offers = (f"resume {robot}",) if may else ()
            raise RobotStopped(words.is_stopped(profile.shown), offers=offers)
        holder = self._organiser.holder(robot)
        if holder not in {None, caller.principal}:
            name = self._data_context.name(holder or "")
            raise RobotTaken(words.is_taken(profile.shown, name))
        outside = self._organiser.outside_slot(caller.principal, robot)
        if outside is not None:
            raise outside

    # ---- and back ----

    async def fetch(self, asked: CommandContext, rest: str) -> Reply:
        """List what a robot gives, or hand one file of it over.

        Raises:
            Refusal: They may not, there is none, or it is nothing that is handed on.
        """
        said, _, name = rest.partition(" ")
        robot = self._robot(asked, said)
        self._organiser.check_word(asked.caller, robot, FILES)
        if not self._files_of(robot).outbox:
            raise NotUnderstood(words.gives_none(self._profiles[robot].shown))
        try:
            if name:
                return await self._one(asked, robot, name)
            return await self._all(robot, asked.messenger.file_bytes)
        except RobotUnreachable as fault:
            raise RobotOffline(fault.sentence) from fault

    async def _all(self, robot: RobotId, most: int) -> Reply:
        found = await self._folders.names(robot, MOST_SHOWN)
        shown = self._profiles[robot].shown
        if not found:
            return Reply(words.gives_nothing_now(shown))
        now_ns = self._data_context.clock.wall_ns()
        lines = []
        for name, size, at_ns in found:
            line = words.given_line(_shown(name), size, ago((now_ns - at_ns) / 1e9))
            lines.append(line if size <= most else words.too_large_line(line))
        buttons = [
            Button(_shown(name), f"/files from {robot} {_shown(name)}")
            for name, size, _ in found
            if size <= most
        ]
        return Reply(words.gives(shown, lines), rows(buttons))

    async def _one(self, asked: CommandContext, robot: RobotId, name: str) -> Reply:
        found = await self._folders.names(robot, MOST_SHOWN)
        match = next((one for one in found if _shown(one[0]) == name.strip()), None)
        if match is None:
            raise NotUnderstood(words.no_such_file(name), offers=(f"/files from {robot}",))
        own, size, _ = match
        if size > asked.messenger.file_bytes:
            raise OutOfBounds(
                words.too_large_to_send(_shown(own), size, asked.messenger.file_bytes)
            )
        if size > IN_PIECES_FROM:
            return self._aside.begin(
                asked,
                partial(self._send_large, asked, robot, own, size),
                partial(words.sending, _shown(own), size),
            )
        seen = await self._outboxes.seen(asked.caller.principal, robot, own, size)
        same = self._outboxes.same(robot, own, size, seen.digest)
        content = b"".join([piece async for piece in same])
        text = words.handed(seen.called, len(content), seen.digest)
        return Reply(text, attachment=Attachment(seen.called, seen.media_type, content))

    async def _send_large(
        self, asked: CommandContext, robot: RobotId, own: str, size: int, progress: TransferProgress
    ) -> Reply:
        """Read it twice: to know what it is, and while it is sent."""
        seen = await self._outboxes.seen(asked.caller.principal, robot, own, size)
        pieces = StreamedContent(size, partial(self._outboxes.same, robot, own, size, seen.digest))
        attachment = Attachment(seen.called, seen.media_type, pieces=pieces)
        text = words.handed(seen.called, size, seen.digest)
        return await send_file(asked, self._plain, attachment, text, progress)

    async def _aside_if_large(
        self, asked: CommandContext, size: int, work: Work, saying: Saying
    ) -> Reply:
        return (
            self._aside.begin(asked, work, saying)
            if size > IN_PIECES_FROM
            else await work(TransferProgress())
        )

    # ---- which ----

    def _robot(self, asked: CommandContext, said: str) -> RobotId:
        wanted = " ".join(said.split()).casefold()
        for robot in sorted(self._data_context.visible(asked.caller.principal)):
            if wanted in {robot, self._profiles[robot].shown.casefold()}:
                return robot
        raise NotUnderstood(words.no_such_robot(said))

    def _files_of(self, robot: RobotId) -> Files:
        files = self._profiles[robot].files
        if files is None:
            raise NotUnderstood(words.takes_none(self._profiles[robot].shown))
        return files


def _received(robot_file: FileForRobot, receipt: Receipt, shown: str) -> str:
    if receipt.declined:
        return words.declined(robot_file.name, shown)
    if not receipt.received:
        return words.sent_to(robot_file.name, robot_file.digest, shown)
    if not receipt.digest:
        return words.received_unproved(robot_file.name, shown)
    if receipt.agrees(robot_file.digest):
        return words.received(robot_file.name, robot_file.digest, shown)
    return words.received_other(robot_file.name, robot_file.digest, receipt.digest, shown)


def _shown(name: str) -> str:
    """Return a name of somebody else's folder as it is shown and asked for."""
    return file_name(name, SORTS["text"]._replace(endings=(_ending(name),)))


def _ending(name: str) -> str:
    _, dot, ending = name.casefold().rpartition(".")
    return ending if dot and ending.isalnum() and ending.isascii() and len(ending) <= 8 else "txt"  # noqa: PLR2004
