"""``/record omni 5 min``: a file of what was asked of a robot beside what moved, for Foxglove."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.container import file_messages
from rosic.container.files import attachment_of
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.language.compiled import fold
from rosic.core.language.time_tokens import length_said
from rosic.core.message import Button, Outbound
from rosic.core.robot.view import ViewKind
from rosic.errors import (
    MessengerFault,
    NothingToSee,
    NotUnderstood,
    OutOfBounds,
    RecordUnavailable,
    Refusal,
    TooManyRequests,
)
from rosic.features.recording import messages as words
from rosic.features.recording.keeper import RecordingKeeper
from rosic.features.recording.service import RecordingEnd
from rosic.gateway.commands import Reply, check_private

if TYPE_CHECKING:
    from rosic.container.files import StoredFile
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.recording.service import Recording, RecordingService
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.feature import Kernel

RECORD: Final = "record"
COMMANDS: Final = (
    Command(
        name=RECORD,
        aliases=("aufzeichnen",),
        typed=said("/record"),
        summary=said("A file of what was asked of it beside what moved"),
        explained=True,
        help=HelpEntry(HelpPage.SEE, 97),
    ),
)

DEFAULT_S: Final = 60.0
LONGEST_S: Final = 1_800.0
SEND_WITHIN_S: Final = 120.0
END: Final = frozenset({"end", "ende", "beenden"})
BESIDE: Final = frozenset({"with", "and", "mit", "und", "for", "the", "its"})
CAMERA: Final = frozenset({"camera", "pictures", "kamera", "bilder", "bildern"})
_ENDS: Final = ".,;:!?"
_ENDED: Final = {
    RecordingEnd.TIME: words.complete,
    RecordingEnd.ASKED: words.ended_by_you,
    RecordingEnd.UNSEEN: words.not_seen_any_more,
    RecordingEnd.FULL: words.full,
}


class RecordingCommands:
    """The handler of people's own recordings; in private alone, as the file is for them alone.

    Attributes:
        keeper: Keeps what was recorded.
    """

    def __init__(
        self, kernel: Kernel, containers: ContainerContext, service: RecordingService
    ) -> None:
        self.keeper = RecordingKeeper(kernel, containers)
        self._kernel = kernel
        self._containers = containers
        self._service = service
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    def register(self, commands: CommandRegistry) -> None:
        """Take the command."""
        commands.register(RECORD, self.record)

    async def record(self, asked: CommandContext) -> Reply:
        """Begin a recording, or end one.

        Raises:
            Refusal: Why not; nothing was begun.
        """
        check_private(asked)
        text = asked.rest.strip().rstrip(_ENDS)
        who = asked.caller.principal
        if not text:
            return Reply(words.HOW)
        first = fold(text.split()[0])
        nameless = first in END or first[:1].isdigit()
        robot, rest = self._kernel.naming.robot(asked, RECORD, text, nameless=nameless)
        said_words = [fold(word) for word in rest.split()]
        shown = self._kernel.rooms.profiles[robot].shown
        if said_words and said_words[0] in END and len(said_words) == 1:
            return self._end(who, robot, shown)
        for_s, pictures = _read(said_words)
        if pictures and not self._kernel.rooms.profiles[robot].offers(ViewKind.PICTURE):
            raise NothingToSee(words.no_camera(shown))
        return await self._begin(asked, robot, for_s, pictures=pictures)

    def _end(self, who: PrincipalId, robot: RobotId, shown: str) -> Reply:
        recording = self._service.find(who, robot)
        if recording is None:
            raise NotUnderstood(words.none_of(shown), offers=(f"/{RECORD} {robot}",))
        recording.end(RecordingEnd.ASKED)
        return Reply("")  # the file is the answer

    async def _begin(
        self, asked: CommandContext, robot: RobotId, for_s: float, *, pictures: bool
    ) -> Reply:
        who, shown = asked.caller.principal, self._kernel.rooms.profiles[robot].shown
        self._check_possible(who, robot, for_s)
        file = await self.keeper.begin(asked, robot)
        try:
            self._check_possible(who, robot, for_s)  # others have begun meanwhile
        except Refusal:
            await self.keeper.drop(file.id)
            raise
        recording = self._service.begin(who, (robot,), file.write, file.most_bytes)
        task = self._tasks.begin(self._record(asked, recording, file.id, for_s, pictures=pictures))
        task.add_done_callback(lambda _: self._service.drop(recording))
        text = words.begun(shown, for_s, pictures=pictures)
        end = Button(said("End it now"), f"/{RECORD} {robot} end")
        return Reply(text, ((end,),), about=robot)

    def _check_possible(self, who: PrincipalId, robot: RobotId, for_s: float) -> None:
        if self._service.find(who, robot) is not None:
            shown = self._kernel.rooms.profiles[robot].shown
            raise TooManyRequests(words.already(shown), retry_after_s=for_s)
        self._service.check_possible()

    async def _record(
        self,
        asked: CommandContext,
        recording: Recording,
        file: str,
        for_s: float,
        *,
        pictures: bool,
    ) -> None:
        who, [robot] = recording.principal, recording.robots
        try:
            why = await self._service.run(recording, for_s, pictures=pictures)
        except asyncio.CancelledError:  # whoever it was for is being erased
            await self.keeper.drop(file)
            raise
        if why is RecordingEnd.CLOSED:
            return  # it is made whole at the next start
        shown = self._kernel.rooms.profiles[robot].shown
        if who in self._kernel.rooms.organiser.locked or not self._is_known(who):
            await self.keeper.drop(file)
            return
        if why in {RecordingEnd.UNWRITTEN, RecordingEnd.FAILED}:
            kept = await self.keeper.rescue(file)
            text = words.broken(shown, "" if kept is None else kept.name)
            self._say(asked, text)
            return
        try:
            kept = await self.keeper.finish(file)
        except RecordUnavailable:
            self._say(asked, words.broken(shown, ""))
            return
        if kept is not None:
            await self._hand_over(asked, kept, _ENDED[why](shown, recording.size))

    def _is_known(self, who: PrincipalId) -> bool:
        return self._kernel.rooms.authoriser.directory.has_good_key(who)

    async def _hand_over(self, asked: CommandContext, kept: StoredFile, text: str) -> None:
        """Send a file to whoever recorded it; what cannot be sent stays among their files."""
        most = asked.messenger.file_bytes
        if kept.size > most:
            too_large = file_messages.too_large_to_send(kept.name, kept.size, most)
            self._say(asked, words.kept(text, too_large, kept.name))
            return
        inbound, plain = asked.inbound, self._kernel.pipeline.plain
        try:
            attachment = await attachment_of(self._containers.container_store, kept)
            sent = Outbound(chat=inbound.chat, text=plain(inbound, text), attachment=attachment)
            async with asyncio.timeout(SEND_WITHIN_S):
                await asked.messenger.send(sent)
        except (MessengerFault, RecordUnavailable, TimeoutError):
            self._say(asked, words.kept(text, words.NOT_SENT, kept.name))
            return
        with suppress(RecordUnavailable):  # it lies there, then, until they delete it
            await self.keeper.drop(kept.id)

    def _say(self, asked: CommandContext, text: str) -> None:
        reply = Reply(text, anew=True)
        self._kernel.pipeline.answer(asked.messenger, asked.inbound, asked.caller, reply)


def _read(said_words: list[str]) -> tuple[float, bool]:
    """Return how long, and whether with pictures.

    Raises:
        NotUnderstood: Something else was said.
        OutOfBounds: It is no time, or too long.
    """
    rest = [word for word in said_words if word not in BESIDE]
    pictures = any(word in CAMERA for word in rest)
    timed = [word for word in rest if word not in CAMERA]
    if not timed:
        return DEFAULT_S, pictures
    for_s, used = length_said(timed)
    if used != len(timed):
        raise NotUnderstood(words.HOW, offers=(f"/{RECORD}",))
    if not 1 <= for_s <= LONGEST_S:
        raise OutOfBounds(words.length_bounds(LONGEST_S))
    return for_s, pictures
