"""What a robot sees and where it went, asked for in a chat of a real `rosic run`."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any

import pytest

from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

image = pytest.importorskip(
    "PIL.Image", reason="pictures need Pillow: pip install 'rosic[pictures]'"
)
TWO = tuple(f'[[robot]]\nprofile = "{name}"\nlink = "simulated"' for name in ("omni", "kuka1"))
# What is asked, what is written beneath, how the file comes.
SIGHTS = (
    ("/picture omni", "omni, camera, ", "photo"),
    ("/picture omni low", "low quality", "photo"),
    ("/clip omni", "omni, clip of ", "animation"),
    ("/map omni", "omni, map, ", "photo"),
    ("/chart omni battery", "omni, battery over ", "photo"),
    ("/path omni", "omni, way of the last order (move", "photo"),
    ("/trajectory omni", "omni, way of the last order (move", "photo"),
)
EACH_WITHIN_S = 30.0


async def seen(place: Lab, asked: str, caption: str, kind: str) -> Any:  # noqa: ANN401
    """Ask for a picture; return it, opened, once it stands beneath the question."""
    shown = await place.ask(place.bo, asked, caption, within_s=EACH_WITHIN_S)
    assert " ago" in shown["text"], "its age is not said"
    media = shown[kind]
    assert media, f"{asked}: no {kind} in {shown}"
    file = media[-1] if kind == "photo" else media
    content = base64.b64decode(await place.control.call("file", file_id=file["file_id"]))
    return image.open(io.BytesIO(content))


async def test_everything_that_can_be_seen_is_shown_with_robot_and_age(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=TWO) as place:
        await place.start()
        await place.ask(place.bo, "omni move 0.5 m", "done ")
        sizes: dict[str, int] = {}
        for asked, caption, kind in SIGHTS:
            picture = await seen(place, asked, caption, kind)
            sizes[asked] = picture.width * picture.height
            if kind == "animation":
                assert picture.n_frames > 1, "a clip that does not move"
        assert sizes["/picture omni low"] < sizes["/picture omni"]
        assert await place.control.violations() == []


async def test_a_picture_leads_to_the_next_by_its_buttons_and_nobody_else_sees_one(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=TWO) as place:
        await place.start()
        first = await place.ask(place.bo, "/picture omni", "camera", within_s=EACH_WITHIN_S)
        labels = [button["text"] for row in first["buttons"] for button in row]
        assert labels == ["Again", "Clip", "Lower quality"]
        await place.control.tap(place.bo, place.bo, first["message_id"], "Lower quality")
        await place.reads(place.bo, "low quality", within_s=EACH_WITHIN_S)
        stranger = await place.control.create_user("Cy")
        await place.ask(stranger, "/picture omni", "I do not know you yet")
        assert not [m for m in await place.control.messages(stranger) if m["photo"]]
