"""A file from a phone into a container, to a robot's inbox, and a log back, over the real way."""

from __future__ import annotations

import base64
import hashlib
import os
from typing import TYPE_CHECKING

from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

MAP = b"P5\n# hall 2\n700 700\n255\n" + os.urandom(490_000)


async def send_file(place: Lab, user: int, name: str, content: bytes) -> int:
    sent = base64.b64encode(content).decode()
    return int(await place.control.call("send_file", chat=user, user=user, name=name, content=sent))


async def test_a_file_is_kept_given_back_and_survives_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        number = await send_file(place, place.bo, "../hall.pgm", MAP)
        kept = await place.reads(place.bo, "hall.pgm (pgm, 490 KB) is kept", to=number)
        assert hashlib.sha256(MAP).hexdigest() in kept["text"]
        await send_file(place, place.bo, "run.exe", b"MZ\x90\0" * 99)
        await place.reads(place.bo, "none of the kinds")
        assert not any(MAP[-64:] in f.read_bytes() for f in place.data.rglob("*") if f.is_file())
        gateway.kill()
        await place.start()
        await place.ask(place.bo, "/files", "hall.pgm: pgm, 490 KB")
        await place.ask(place.ada, "/files", "no file of yours")
        back = await place.ask(place.bo, "/files get hall.pgm", "hall.pgm, 490 KB")
        held = await place.control.call("file", file_id=back["document"]["file_id"])
        assert base64.b64decode(held) == MAP
        assert place.acted() == 0
