"""From a container to a robot, after a tap, and back; nothing by itself, or for who may not."""

from __future__ import annotations

import asyncio
import hashlib
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.container.files import pieces_of
from rosic.core.robot.profile import Slots
from rosic.robots.ros2.profile import Ros2Files
from tests.features.files.test_upload import MAP, NOTE, send
from tests.features.personal_data.data_gateway import Ward, a_ward
from tests.gateway.place import ADA, BO, FLEET, VI
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator
    from pathlib import Path


@asynccontextmanager
async def place(
    folder: Path, slots: Slots = Slots.RESPECTED, **changed: object
) -> AsyncIterator[Ward]:
    """Open a gateway whose omni takes pictures and notes."""
    for name in ("in", "out"):
        (folder / name).mkdir()
    files = Ros2Files(
        accept=("png", "yaml"), max_mb=1, inbox=str(folder / "in"), outbox=str(folder / "out")
    )
    omni, *others = FLEET
    fleet = (replace(omni, files=replace(files, **changed), slots=slots), *others)
    async with a_ward(fleet=fleet) as ward:
        yield ward


def held(folder: Path) -> set[str]:
    return {path.name for path in (folder / "in").iterdir()}


async def asked(ward: Ward, line: str, account: str = ADA) -> str:
    before = len(ward.chat.told)
    await ward.say(line, account=account, chat=account)
    await more_than(ward, before)
    return "\n".join(told.outbound.text for told in list(ward.chat.told)[before:])


async def more_than(ward: Ward, told: int) -> None:
    """Wait until more was told than before: disks take real time."""
    async with asyncio.timeout(60 * pace()):
        while len(ward.chat.told) <= told:
            await asyncio.sleep(0.005)
            await ward.quiet()


async def tapped(ward: Ward, label: str, account: str = ADA) -> str:
    button, under = ward.button(label)
    before = len(ward.chat.told)
    said = await ward.tap(button, under, account)
    await more_than(ward, before)
    for _ in range(20):  # disks take real time
        await asyncio.sleep(0.005)
        await ward.quiet()
    return said + "\n" + ward.last()[1].text


async def test_a_file_goes_to_a_robot_after_a_question(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward)
        question = await tapped(ward, "Send it to omni")
        assert "Put map.png (600 KB) into the inbox of omni?" in question
        assert hashlib.sha256(MAP).hexdigest() in question
        assert held(tmp_path) == set(), "put there before it was confirmed"
        said = await tapped(ward, "Put it there")
        assert "map.png lies in the inbox of omni" in said
        assert "gives no receipt" in said
        assert (tmp_path / "in" / "map.png").read_bytes() == MAP
        (decided,) = [d for d in await ward.kept.decisions(9) if d.act == "file-to-robot"]
        assert (decided.by, decided.about) == (ward.id_of(ADA), "omni")
        assert decided.digest == hashlib.sha256(MAP).digest()
        assert ward.acted() == 0


@pytest.mark.parametrize("line", ["stop omni", "/lock Bo"])
async def test_what_ends_while_a_file_is_written_keeps_it_from_the_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    """It lies under a name that nobody looks at until the last moment, and is asked once more."""
    async with place(tmp_path) as ward:

        def ended() -> bool:
            stops, locks = ward.gateway.rooms.stops, ward.gateway.access.locks
            return stops["omni"].latched or locks.locked(ward.id_of(BO))

        async def pieces(*of: Any) -> AsyncGenerator[bytes]:  # noqa: ANN401 - handed on
            ward.chat.say(line, account=ADA, chat=ADA)
            async with asyncio.timeout(60 * pace()):
                while not ended():  # noqa: ASYNC110 - nobody is told
                    await asyncio.sleep(0.005)
            async for piece in pieces_of(*of):
                yield piece

        monkeypatch.setattr("rosic.features.files.transfer.pieces_of", pieces)
        await send(ward, account=BO)
        await asked(ward, "/files send map.png to omni", BO)
        told = await tapped(ward, "Put it there", BO)
        assert held(tmp_path) == set(), told
        assert "lies in the inbox" not in told


@pytest.mark.parametrize("slots", [Slots.RESPECTED, Slots.NONE])
async def test_no_file_goes_to_a_robot_in_the_time_of_somebody_else(
    tmp_path: Path, slots: Slots
) -> None:
    """What lies in an inbox may set a robot going, so a slot counts as it does for motion."""
    async with place(tmp_path, slots) as ward:
        await send(ward, account=BO)
        await asked(ward, "/files send map.png to omni", BO)
        calendar, now_ns = ward.gateway.rooms.organiser.calendar, ward.clock.wall_ns()
        async with ward.gateway.access.changes.turn() as turn:
            await turn.write(calendar.book(ward.id_of(ADA), "omni", now_ns, 60, "test"))
        told = await tapped(ward, "Put it there", BO)
        assert bool(held(tmp_path)) == (slots is Slots.NONE), told
        assert ("omni is taken by Ada until" in told) == (slots is Slots.RESPECTED)


async def test_no_file_goes_to_a_robot_that_has_to_be_booked_first(tmp_path: Path) -> None:
    async with place(tmp_path, Slots.REQUIRED) as ward:
        await send(ward, account=BO)
        told = await asked(ward, "/files send map.png to omni", BO)
        assert "omni has to be booked first" in told


async def test_a_question_is_good_once_and_for_its_asker(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward)
        await asked(ward, "/files send map.png to omni")
        button, under = ward.button("Put it there")
        await ward.tap(button, under, BO)
        await ward.quiet()
        assert held(tmp_path) == set()
        await tapped(ward, "Put it there")
        assert held(tmp_path) == {"map.png", "map.png.sha256"}
        for name in held(tmp_path):
            (tmp_path / "in" / name).unlink()
        await ward.tap(button, under, ADA)
        await asyncio.sleep(0.05)
        assert held(tmp_path) == set()


async def test_what_a_button_says_cannot_be_typed(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward)
        (filed,) = ward.data_context.files.of(ward.id_of(ADA))
        await asked(ward, f"/files put {filed.id} omni")
        assert held(tmp_path) == set()


async def test_what_was_asked_about_is_what_goes(tmp_path: Path) -> None:
    """Another file of the same name, kept meanwhile, is not what the tap was about."""
    async with place(tmp_path) as ward:
        await send(ward)
        await asked(ward, "/files send map.png to omni")
        await asked(ward, "/files delete map.png")
        await send(ward, content=MAP + b"other")
        await tapped(ward, "Put it there")
        assert held(tmp_path) == set()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("log.zip", b"PK\x03\x04abc", "omni takes png or yaml, and this is zip"),
        ("map.png", MAP, "files of up to 500 KB; this has 600 KB"),
    ],
)
async def test_a_robot_takes_what_its_profile_says(
    tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    async with place(tmp_path, max_mb=0.5) as ward:
        await send(ward, name, content)
        assert said in await asked(ward, f"/files send {name} to omni")
        with pytest.raises(AssertionError):
            ward.button("Put it there")


async def test_who_may_not_move_files_moves_none(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        (tmp_path / "out" / "run.log").write_bytes(b"x\n")
        await send(ward, account=VI)
        for line in ("/files send map.png to omni", "/files from omni", "/files from omni run.log"):
            said = await asked(ward, line, VI)
            assert "inbox" not in said
            assert "run.log:" not in said
        with pytest.raises(AssertionError):
            ward.button("Send it to omni")


async def test_a_right_that_has_ended_meanwhile_does_not_count(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward, account=BO)
        await asked(ward, "/files send map.png to omni", BO)
        await ward.revoke("Bo")
        await tapped(ward, "Put it there", BO)
        assert held(tmp_path) == set()


async def test_a_stopped_robot_and_one_of_somebody_else_get_none(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward)
        await ward.say("omni wave", account=BO, chat=BO)
        assert "Bo has omni now" in await asked(ward, "/files send map.png to omni")
        await ward.say("stop omni", account=BO, chat=BO)
        assert "omni is stopped" in await asked(ward, "/files send map.png to omni")
        assert held(tmp_path) == set()


async def test_a_robot_that_is_out_of_the_fleet_gets_none_and_nobody_is_told_to_resume_it(
    tmp_path: Path,
) -> None:
    async with place(tmp_path) as ward:
        await send(ward)
        await ward.say("/robot retire omni")
        told = await asked(ward, "/files send map.png to omni")
        assert "omni is retired, so it stays stopped." in told
        assert not ward.last()[1].buttons
        assert held(tmp_path) == set()


async def test_a_name_that_is_there_is_not_replaced(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        (tmp_path / "in" / "a.yaml").write_bytes(b"before")
        await send(ward, "a.yaml", NOTE)
        await asked(ward, "/files send a.yaml to omni")
        assert "There is a a.yaml in the inbox" in await tapped(ward, "Put it there")
        assert (tmp_path / "in" / "a.yaml").read_bytes() == b"before"


async def test_an_inbox_that_is_gone_is_said(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward, "a.yaml", NOTE)
        await asked(ward, "/files send a.yaml to omni")
        (tmp_path / "in").rmdir()
        assert "inbox cannot be written now" in await tapped(ward, "Put it there")


async def test_robots_without_files_say_so(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        await send(ward, "a.yaml", NOTE)
        assert "kuka1 takes no files." in await asked(ward, "/files send a.yaml to kuka1")
        assert "You see no robot" in await asked(ward, "/files send a.yaml to ../../etc")
        assert "Send me a photo" in await asked(ward, "/files send a.yaml")


# ---- back ----


async def given(ward: Ward, name: str) -> tuple[str, bytes] | None:
    """Return the file that omni gives under a name."""
    await asked(ward, f"/files from omni {name}")
    attachment = ward.last()[1].attachment
    return None if attachment is None else (attachment.name, attachment.content)


async def test_a_robots_files_come_back(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        assert "omni has no file for you now." in await asked(ward, "/files from omni")
        (tmp_path / "out" / "run 3.log").write_bytes(b"started\n")
        (tmp_path / "out" / "bad\u202e.log").write_bytes(b"started\n")
        (tmp_path / "out" / "core").write_bytes(b"\x7fELF\0")
        (tmp_path / "out" / "link.log").symlink_to("/etc/hostname")
        said = await asked(ward, "/files from omni")
        assert "run 3.log: 8 bytes" in said
        assert "\u202e" not in said
        assert "link" not in said
        assert await given(ward, "run 3.log") == ("run 3.log", b"started\n")
        assert await given(ward, "bad.log") == ("bad.log", b"started\n")
        assert "none of the kinds" in await asked(ward, "/files from omni core.txt")
        for name in ("../in/x", "link.log", "/etc/passwd", "core.txt"):
            assert await given(ward, name) is None
        acts = [d.act for d in await ward.kept.decisions(9)]
        assert acts.count("file-from-robot") == 2


async def test_too_large_a_file_of_a_robot_is_refused(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        (tmp_path / "out" / "run.log").write_bytes(b"a" * 1_000_001)
        said = await asked(ward, "/files from omni run.log")
        assert "I can send files of up to 1.0 MB here" in said
