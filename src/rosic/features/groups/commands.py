"""The commands about channels and topics, as they are declared."""

from __future__ import annotations

from typing import Final

from rosic.core.i18n import said
from rosic.core.language.command import Command, MenuAudience, MenuEntry

COMMANDS: Final = (
    Command(
        name="topic",
        summary=said("Say which robot this topic is about"),
        menu=MenuEntry(400, MenuAudience.TOPICS),
    ),
    Command(
        name="channel",
        summary="what a channel shows",
    ),
)
