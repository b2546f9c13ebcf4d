"""Frames of robots: what is good is shown, everything else is refused with a sentence."""

from __future__ import annotations

import io
from array import array

import pytest
from PIL import Image

from rosic.core.robot.view import CompressedFrame, Drawing, RawFrame
from rosic.errors import NothingToSee
from rosic.rendering import frames
from rosic.rendering.draw import draw

RED, BLUE = (250, 5, 5), (5, 5, 250)


def opened(drawing: Drawing) -> Image.Image:
    image = Image.open(io.BytesIO(drawing.content))
    assert Image.MIME[image.format or ""] == drawing.media_type
    assert image.size == (drawing.width, drawing.height)
    return image.convert("RGB")


def encoded(kind: str, size: tuple[int, int] = (64, 48), mode: str = "RGB") -> CompressedFrame:
    buffer = io.BytesIO()
    Image.new(mode, size, RED if mode == "RGB" else 3000).save(buffer, kind)
    return CompressedFrame(buffer.getvalue())


def near(one: object, other: tuple[int, int, int]) -> bool:
    assert isinstance(one, tuple)
    return all(abs(a - b) < 25 for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
def test_a_compressed_frame_is_shown(kind: str) -> None:
    assert near(opened(draw(encoded(kind))).getpixel((20, 20)), RED)


@pytest.mark.parametrize(
    ("encoding", "pixel"),
    [
        ("rgb8", RED),
        ("bgr8", RED[::-1]),
        ("rgba8", (*RED, 255)),
        ("bgra8", (*RED[::-1], 255)),
        ("8UC3", RED[::-1]),
    ],
)
def test_bare_pixels_have_the_right_colours(encoding: str, pixel: tuple[int, ...]) -> None:
    row = bytes(pixel) * 8 + b"pad"
    shown = opened(draw(RawFrame(8, 8, encoding, len(row), row * 8)))
    assert near(shown.getpixel((4, 4)), RED)


def test_the_last_row_may_come_without_its_padding() -> None:
    row = bytes(RED) * 8 + b"pad"
    draw(RawFrame(8, 8, "rgb8", len(row), (row * 8)[:-3]))


@pytest.mark.parametrize("big_endian", [False, True])
def test_depth_is_bright_where_it_is_near_and_black_where_it_is_unknown(
    *, big_endian: bool
) -> None:
    depths = array("H", [0] * 20 + [500] * 20 + [4000] * 24)
    if big_endian:
        depths.byteswap()
    frame = RawFrame(64, 64, "16UC1", 128, depths.tobytes() * 64, big_endian)
    shown = opened(draw(frame))
    unknown, close, far = (shown.getpixel((x, 30)) for x in (8, 30, 55))
    assert near(unknown, (0, 0, 0))
    assert near(close, (255, 255, 255))
    assert near(far, (frames.FAINTEST,) * 3)


def test_a_deep_png_is_shown_as_depth() -> None:
    assert opened(draw(encoded("PNG", mode="I;16"))).size == (64, 48)


@pytest.mark.parametrize("low", [False, True])
def test_a_large_frame_becomes_small(*, low: bool) -> None:
    drawing = draw(encoded("JPEG", (2000, 1000)), low=low)
    assert drawing.width == (360 if low else 1280)
    assert drawing.width == 2 * drawing.height


def test_low_quality_is_less() -> None:
    noise = Image.effect_noise((800, 600), 60)
    buffer = io.BytesIO()
    noise.save(buffer, "PNG")
    frame = CompressedFrame(buffer.getvalue())
    assert len(draw(frame, low=True).content) * 8 < len(draw(frame).content)


WRONG: dict[str, CompressedFrame | RawFrame] = {
    "no picture at all": CompressedFrame(b"hello"),
    "nothing": CompressedFrame(b""),
    "half a jpeg": CompressedFrame(encoded("JPEG", (640, 480)).data[:700]),
    "half a png": CompressedFrame(encoded("PNG", (640, 480)).data[:80]),
    "another format": encoded("GIF"),
    "too many bytes": CompressedFrame(bytes(frames.MOST_BYTES + 1)),
    "a bomb": encoded("PNG", (5000, 5000)),
    "unknown encoding": RawFrame(8, 8, "bayer_rggb8", 8, bytes(64)),
    "too short": RawFrame(8, 8, "mono8", 8, bytes(55)),
    "too long": RawFrame(8, 8, "mono8", 8, bytes(65)),
    "narrow rows": RawFrame(8, 8, "rgb8", 8, bytes(64)),
    "empty": RawFrame(0, 8, "mono8", 0, b""),
    "huge": RawFrame(100_000, 100_000, "mono8", 100_000, b""),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_refused_with_a_sentence(what: str) -> None:
    with pytest.raises(NothingToSee, match=r"^(The frame|I cannot show) .*\.$"):
        draw(WRONG[what])
