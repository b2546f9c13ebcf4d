"""What a clock on the wall shows: the time of the place, wherever its machine thinks it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.builder import latch_of, parts_of
from rosic.app.config import load_config
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from pathlib import Path

CONFIG = """
[gateway]
zone = "Asia/Kathmandu"
[[messenger]]
kind = "terminal"
[[robot]]
profile = "omni"
link = "memory"
"""
AT_NS = 1_700_000_000 * 10**9  # 22:13:20 in UTC


def test_times_on_cards_are_those_of_the_place(tmp_path: Path) -> None:
    path = tmp_path / "rosic.toml"
    path.write_text(CONFIG)
    config = load_config(path)

    parts = parts_of(config, latch_of(config), SystemClock(), SystemEntropy())

    assert parts.face(AT_NS) == "03:58:20"
