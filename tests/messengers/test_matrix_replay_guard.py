"""One place in a session belongs to one event, and nothing old is new, over restarts too."""

from __future__ import annotations

import sqlite3
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.replay_guard import (
    FILE,
    WINDOW,
    PlaceStanding,
    ReplayGuard,
    SessionPlace,
)

if TYPE_CHECKING:
    from pathlib import Path

ROOM, KEY, SESSION = "!room:example.org", "sender key", "session"
NAMES = (ROOM, KEY, SESSION)


def place(index: int, session: str = SESSION) -> SessionPlace:
    return SessionPlace(ROOM, KEY, session, index)


async def opened(folder: Path, **bounds: int) -> ReplayGuard:
    guard = ReplayGuard(folder, **bounds)
    await guard.open()
    guard.opened(*NAMES)
    return guard


async def test_another_run_knows_what_was_decrypted(tmp_path: Path) -> None:
    before = await opened(tmp_path)
    assert before.judge(place(7), "$one", 12).standing is PlaceStanding.NEW
    await before.settle()

    after = await opened(tmp_path)
    assert after.judge(place(7), "$one", 90) == (PlaceStanding.SAME, 12)
    assert after.judge(place(7), "$two", 90).standing is PlaceStanding.REPLAYED


async def test_the_first_event_keeps_its_place(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    for event in ("$one", "$two"):
        guard.judge(place(7), event, 12)
        await guard.settle()
    after = await opened(tmp_path)
    assert after.judge(place(7), "$one", 90).standing is PlaceStanding.SAME


async def test_what_comes_after_what_was_written_later_is_as_old_as_that(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    guard.judge(place(3), "$three", 1_000)
    guard.judge(place(5), "$five", 2_000)
    assert guard.judge(place(4), "$four", 90_000) == (PlaceStanding.HELD_BACK, 2_000)
    assert guard.judge(place(2), "$two", 90_000) == (PlaceStanding.HELD_BACK, 1_000)
    assert guard.judge(place(6), "$six", 90_000) == (PlaceStanding.NEW, 90_000)


async def test_what_comes_of_a_session_that_was_given_up_is_old(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    guard.judge(place(3), "$three", 1_000)
    guard.opened(ROOM, KEY, "newer")
    assert guard.judge(place(4), "$four", 1_500).standing is PlaceStanding.NEW
    guard.judge(place(0, "newer"), "$other", 2_000)
    await guard.settle()
    for one in (guard, await opened(tmp_path)):
        one.opened(ROOM, KEY, "newer")
        assert one.judge(place(5), "$five", 90_000) == (PlaceStanding.HELD_BACK, 2_000)


async def test_what_was_forgotten_is_never_new(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    for index in range(100_000):
        guard.judge(place(index), f"${index}", index)
    await guard.settle()
    for one in (guard, await opened(tmp_path)):
        old = one.judge(place(0), "$replayed", 200_000)
        assert (old.standing, old.is_late) == (PlaceStanding.FORGOTTEN, True)
        assert one.judge(place(99_999), "$replayed", 0).standing is PlaceStanding.REPLAYED
        assert one.judge(place(100_000), "$next", 200_000).standing is PlaceStanding.NEW
    with sqlite3.connect(tmp_path / FILE) as connection:
        assert connection.execute("SELECT count(*) FROM places").fetchone() == (WINDOW,)


async def test_what_is_remembered_of_all_sessions_is_bounded(tmp_path: Path) -> None:
    guard = await opened(tmp_path, places=20)
    for session in range(4):
        guard.opened(ROOM, KEY, f"session {session}")
        for index in range(10):
            guard.judge(place(index, f"session {session}"), f"${session}{index}", 1)
    await guard.settle()
    with sqlite3.connect(tmp_path / FILE) as connection:
        assert connection.execute("SELECT count(*) FROM places").fetchone()[0] <= 20
    assert guard.judge(place(5, "session 0"), "$replayed", 9).standing is PlaceStanding.FORGOTTEN


async def test_a_session_that_is_forgotten_gives_up_its_key(tmp_path: Path) -> None:
    guard = await opened(tmp_path, sessions=2)
    assert guard.opened(ROOM, KEY, "second") == []
    guard.judge(place(0), "$one", 1)
    assert guard.opened(ROOM, KEY, "third") == [(ROOM, KEY, "second")]
    assert not guard.is_known(ROOM, KEY, "second")
    assert guard.is_known(*NAMES)


async def test_a_look_notes_nothing(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    assert guard.judge(place(7), "$one", 12, note=False).standing is PlaceStanding.NEW
    assert guard.judge(place(7), "$two", 12).standing is PlaceStanding.NEW


async def test_what_cannot_be_written_is_said_and_kept(tmp_path: Path) -> None:
    guard = ReplayGuard(tmp_path / "away")
    guard.opened(*NAMES)
    guard.judge(place(7), "$one", 12)
    with pytest.raises(MessengerFault):
        await guard.settle()
    (tmp_path / "away").mkdir()
    await guard.settle()
    after = await opened(tmp_path / "away")
    assert after.judge(place(7), "$one", 12).standing is PlaceStanding.SAME


async def test_names_that_no_database_takes_are_taken(tmp_path: Path) -> None:
    guard = await opened(tmp_path)
    guard.opened(ROOM, "\ud800", "s" * 2_000_000)
    odd = SessionPlace(ROOM, "\ud800", "s" * 2_000_000, 2**32)
    assert guard.judge(odd, "$\udfff", 12).standing is PlaceStanding.NEW
    await guard.settle()


async def test_a_damaged_file_is_no_empty_one(tmp_path: Path) -> None:
    (tmp_path / FILE).write_bytes(b"no database" * 100)
    with pytest.raises(ConfigurationError):
        await ReplayGuard(tmp_path).open()
