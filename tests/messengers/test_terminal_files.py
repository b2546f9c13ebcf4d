"""A terminal says where it put a file in the language of whoever reads it."""

from __future__ import annotations

from shutil import rmtree

from rosic.config.plugins import catalogue
from rosic.core.message import Attachment, Chat, Outbound
from rosic.gateway.delivery.translation import translated
from rosic.messengers.terminal import TerminalMessenger
from rosic.testing.clock import ManualClock
from tests.messengers.test_terminal import Script


async def test_where_a_file_lies_is_said_in_the_readers_language() -> None:
    script = Script()
    messenger = TerminalMessenger(clock=ManualClock(), screen=script)
    file = Attachment("omni.jpg", "image/jpeg", b"...")
    told = Outbound(chat=Chat("terminal", "1000"), text="omni, Kamera", attachment=file)
    await messenger.send(translated(told, catalogue("de")))
    await messenger.send(translated(told, None))
    german, english = script.shown
    assert german.startswith("omni, Kamera\nEs liegt in /")
    assert english.startswith("omni, Kamera\nIt lies in /")
    folder = messenger.downloads.folder
    assert folder is not None
    assert sorted(file.name for file in folder.iterdir()) == ["omni-1.jpg", "omni.jpg"]
    rmtree(folder)
    assert messenger.downloads.folder is None
