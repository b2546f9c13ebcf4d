"""Algorithm 6 of the paper as it ran it: a real account writes a group's messages into a file.

A gateway does better by `/archive`, sealed and with an end: see docs/paper.md.
"""

from __future__ import annotations

import asyncio
import os
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rosic.app import runtime
from rosic.bench.accounts import NO_NETWORK, telethon_client
from rosic.bench.report import BenchReport, machine
from rosic.container.export import archive_line
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from rosic.bench.recorder import BenchRecorder

FILE: Final = "messages.txt"
"""As the paper calls it by default."""
SECONDS: Final = 60.0
WAITED: Final = "from Telegram's date until it is in the file"
METHOD: Final = (
    "Algorithm 6 as the paper ran it: messages of a group, as an account sees them by Telethon, "
    "appended to a file, a line each, for {seconds:g} s or until the connection ends. Telegram "
    "dates to a whole second, so a time may be up to a second too long."
)
NO_GROUP: Final = "Name the group: --group LINK_OR_ID."
WRITTEN: Final = "{messages} messages are in {path}."


class GroupWriter:
    """Appends messages to a file that its owner alone reads.

    Attributes:
        waited_ns: Of each message, from its date until it was in the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.waited_ns: list[int] = []

    async def heard(self, event: Any) -> None:  # noqa: ANN401 - of Telethon
        """Lines 5 to 7 of the algorithm.

        Raises:
            OSError: It cannot be written.
        """
        sender = await event.get_sender()
        name = getattr(sender, "username", None) or ""
        line = archive_line(str(event.sender_id), name, event.raw_text)
        file = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        with os.fdopen(file, "a", encoding="utf-8") as text:
            text.write(f"{line}\n")
        waited = datetime.now(UTC) - event.date
        self.waited_ns.append(max(0, int(waited.total_seconds() * 1e9)))


async def follow(
    client: Any,  # noqa: ANN401 - of Telethon
    group: str,
    writer: GroupWriter,
    seconds: float,
) -> None:
    """Write what is said in a group for so long, or until the client is disconnected.

    Raises:
        ConfigurationError: It cannot connect.
        OSError: A message could not be written; what was written before is there.
    """
    from telethon.events import NewMessage  # noqa: PLC0415 - an extra

    loop = asyncio.get_running_loop()
    failed: asyncio.Future[None] = loop.create_future()

    async def heard(event: Any) -> None:  # noqa: ANN401 - of Telethon
        try:
            await writer.heard(event)
        except OSError as trouble:
            if not failed.done():
                failed.set_exception(trouble)

    try:
        await client.start()
    except Exception as trouble:  # a library's own, of many kinds
        raise ConfigurationError(NO_NETWORK.format(why=trouble)) from trouble
    client.add_event_handler(heard, NewMessage(chats=int(group) if _is_id(group) else group))
    gone = asyncio.ensure_future(client.run_until_disconnected())
    try:
        await asyncio.wait({gone, failed}, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
        if failed.done():
            failed.result()
    finally:
        failed.cancel()
        with suppress(asyncio.CancelledError):
            await client.disconnect()
        gone.cancel()


def _is_id(group: str) -> bool:
    return group.lstrip("-").isdecimal()


def measure(
    recorder: BenchRecorder, *, group: str = "", file: Path = Path(FILE), seconds: float = 0.0
) -> BenchReport:
    """Write the file, and say how late each message was in it.

    Args:
        recorder: Hears how far it is.
        group: Its link, name or id.
        file: Where the messages go.
        seconds: For so long; 0: a minute.

    Raises:
        ConfigurationError: Something is not set, not installed, or nobody answers.
        OSError: A message could not be written.
    """
    if not group:
        raise ConfigurationError(NO_GROUP)
    seconds = seconds or SECONDS
    writer = GroupWriter(file)
    with recorder.turn(WAITED) as turn:
        try:
            runtime.run(follow(telethon_client(), group, writer, seconds))
        finally:
            if writer.waited_ns:
                turn.saw(len(writer.waited_ns) / seconds, writer.waited_ns)
    return BenchReport(
        machine=machine(),
        method=METHOD.format(seconds=seconds),
        cases=recorder.cases(tails=True),
        findings=(WRITTEN.format(messages=len(writer.waited_ns), path=file),),
    )
