"""An export on its way to whoever asked: as a file, or as much of it as a message can say."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.message import Attachment
from rosic.features.personal_data import messages as words
from rosic.gateway.builtin_commands import Reply

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.gateway.office import CommandContext

ROOM: Final = 3_400  # characters of an export that fit into a message, with what is said about it
MEDIA: Final[Mapping[str, str]] = {
    "ics": "text/calendar",
    "jsonl": "application/x-ndjson",
    "txt": "text/plain",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}


def handed_over(asked: CommandContext, name: str, content: str | bytes, command: str) -> Reply:
    """Return the file where the messenger sends files so large, else the newest lines of it.

    Args:
        asked: Who asked, through which messenger.
        name: Of the file.
        content: What is in it.
        command: How the operator gets it all.
    """
    if not content:
        return Reply(words.NOTHING_KEPT)
    whole = content.encode() if isinstance(content, str) else content
    if len(whole) <= asked.messenger.file_bytes:
        media = MEDIA.get(name.rpartition(".")[2], "application/octet-stream")
        attachment = Attachment(name, media, whole)
        return Reply(words.handed_over(name, len(whole)), attachment=attachment)
    if isinstance(content, bytes):
        return Reply(words.too_large_a_file(len(whole), command))
    return Reply(newest(content.splitlines(), ROOM, command))


def newest(lines: Sequence[str], room: int, command: str) -> str:
    """Return the newest lines that fit into a message, and what to do about the rest."""
    shown: list[str] = []
    for line in reversed(lines):
        room -= len(line) + 1
        if room < 0:
            shown.append(words.rest_left_out(len(lines) - len(shown), command))
            break
        shown.append(line)
    return joined("\n", [words.NO_FILES_HERE, *reversed(shown)])
