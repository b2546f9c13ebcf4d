"""One place in a session belongs to one event, over restarts too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.replay_guard import FILE, ReplayGuard

if TYPE_CHECKING:
    from pathlib import Path

PLACE = ("sender key", "session", 7)


async def test_another_run_knows_what_was_decrypted(tmp_path: Path) -> None:
    before = ReplayGuard(tmp_path)
    await before.open()
    with pytest.raises(KeyError):
        before[PLACE]
    before[PLACE] = ("$one", 12)
    await before.settle()

    after = ReplayGuard(tmp_path)
    await after.open()
    assert after[PLACE] == ("$one", 12)


async def test_the_first_event_keeps_its_place(tmp_path: Path) -> None:
    guard = ReplayGuard(tmp_path)
    for event in ("$one", "$two"):
        guard[PLACE] = (event, 12)
        await guard.settle()
    after = ReplayGuard(tmp_path)
    await after.open()
    assert after[PLACE] == ("$one", 12)


async def test_what_is_remembered_is_bounded(
    tmp_path: Path,
) -> None:
    guard = ReplayGuard(tmp_path, most=3)
    for place in range(5):
        guard["key", "session", place] = (f"${place}", place)
    await guard.settle()
    after = ReplayGuard(tmp_path, most=3)
    await after.open()
    for kept in (guard, after):
        assert kept["key", "session", 2] == ("$2", 2)
        with pytest.raises(KeyError):
            kept["key", "session", 1]


async def test_what_cannot_be_written_is_said_and_kept(tmp_path: Path) -> None:
    guard = ReplayGuard(tmp_path / "away")
    guard[PLACE] = ("$one", 12)
    with pytest.raises(MessengerFault):
        await guard.settle()
    (tmp_path / "away").mkdir()
    await guard.settle()
    after = ReplayGuard(tmp_path / "away")
    await after.open()
    assert after[PLACE] == ("$one", 12)


async def test_a_damaged_file_is_no_empty_one(tmp_path: Path) -> None:
    (tmp_path / FILE).write_bytes(b"no database" * 100)
    with pytest.raises(ConfigurationError):
        await ReplayGuard(tmp_path).open()
