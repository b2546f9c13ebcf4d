"""What the page about seeing says is what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from rosic.config.profiles import check_profile
from rosic.features.media import render_queue, snapshot, telemetry_buffer
from rosic.rendering import draw, frames
from rosic.robots.ros2 import camera_map

TEXT = (Path(__file__).parents[2] / "docs" / "robots" / "seeing.md").read_text("utf-8")


def test_the_profile_that_is_shown_is_good(tmp_path: Path) -> None:
    (block,) = re.findall(r"^```yaml\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
    file = tmp_path / "rover.yaml"
    file.write_text(block)
    assert [str(error) for error in check_profile(file)] == []


def test_the_figures_are_right() -> None:
    assert (render_queue.AT_ONCE, render_queue.DRAWN_AT_ONCE) == (4, 2)
    assert (render_queue.LIMIT.burst, 1 / render_queue.LIMIT.per_s) == (10.0, 5.0)
    assert (snapshot.CLIP_COST, snapshot.CLIP_FRAMES, draw.CLIP_WITHIN) == (4.0, 14, 480)
    assert (draw.WITHIN, draw.MOST_BYTES) == (1280, 4_000_000)
    assert (frames.MOST_PIXELS, frames.MOST_BYTES) == (16_000_000, 16_000_000)
    assert (telemetry_buffer.KEPT, telemetry_buffer.EVERY_S, telemetry_buffer.WAY_POINTS) == (
        600,
        1.0,
        600,
    )
    assert (camera_map.FIRST_WITHIN_S, camera_map.AHEAD_S, camera_map.OLDEST_S) == (
        5.0,
        1.0,
        86_400.0,
    )


def test_every_encoding_is_named() -> None:
    for name in (*frames.PLAIN, *frames.DEEP):
        assert f"`{name}`" in TEXT
