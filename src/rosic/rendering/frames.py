"""Frames as robots send them: looked at before they are opened, and opened small if possible."""

from __future__ import annotations

import io
from array import array
from typing import TYPE_CHECKING

from PIL import Image, UnidentifiedImageError

from rosic.core.i18n import said
from rosic.errors import NothingToSee

if TYPE_CHECKING:
    from rosic.core.robot.view import CompressedFrame, RawFrame

FORMATS = ("JPEG", "PNG")
MOST_BYTES = 16_000_000
MOST_PIXELS = 16_000_000
# Encoding: bytes a pixel, and how Pillow calls it.
PLAIN = {
    "rgb8": (3, "RGB", "RGB"),
    "bgr8": (3, "RGB", "BGR"),
    "rgba8": (4, "RGBA", "RGBA"),
    "bgra8": (4, "RGBA", "BGRA"),
    "mono8": (1, "L", "L"),
    "8UC1": (1, "L", "L"),
    "8UC3": (3, "RGB", "BGR"),
}
DEEP = frozenset({"16UC1", "mono16"})
DEEP_BYTES = 2
FAINTEST = 40  # what is farthest is still seen; black is where nothing was measured


def decoded(frame: CompressedFrame, within: int) -> Image.Image:
    """Open a compressed frame.

    Args:
        frame: JPEG or PNG.
        within: Pixels a side that are wanted; a larger one may be opened smaller.

    Raises:
        NothingToSee: Neither of the two, broken, or too large.
    """
    if len(frame.data) > MOST_BYTES:
        raise NothingToSee(
            _too_large(f"{len(frame.data) / 1e6:.0f} MB", f"{MOST_BYTES // 10**6} MB")
        )
    try:
        with Image.open(io.BytesIO(frame.data), formats=FORMATS) as image:
            _check_size(*image.size)
            image.draft("RGB", (within, within))
            image.load()
            return _deep_or_plain(image)
    except UnidentifiedImageError:
        raise NothingToSee(said("The frame is neither a JPEG nor a PNG picture.")) from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise NothingToSee(_too_large("far more", f"{MOST_PIXELS // 10**6} megapixels")) from None
    except (OSError, ValueError, SyntaxError, EOFError) as error:
        raise NothingToSee(said("The frame is broken: it cannot be opened.")) from error


def _deep_or_plain(image: Image.Image) -> Image.Image:
    if image.mode.startswith("I"):
        return _depth(image)
    return image.convert("RGBA" if "A" in image.mode or "transparency" in image.info else "RGB")


def raster(frame: RawFrame) -> Image.Image:
    """Make a picture of bare pixels.

    Raises:
        NothingToSee: An encoding that is not known, too large, or not as large as it says.
    """
    _check_size(frame.width, frame.height)
    if frame.encoding in DEEP:
        return _deep(frame)
    if frame.encoding not in PLAIN:
        known = ", ".join((*PLAIN, *sorted(DEEP)))
        raise NothingToSee(
            said(
                "I cannot show frames encoded as {encoding}; only {known}.",
                encoding=frame.encoding[:32] or "nothing",
                known=known,
            )
        )
    size, mode, raw = PLAIN[frame.encoding]
    data = _rows(frame, size)
    return Image.frombuffer(
        mode, (frame.width, frame.height), data, "raw", raw, frame.step_bytes, 1
    )


def _deep(frame: RawFrame) -> Image.Image:
    data = _rows(frame, DEEP_BYTES)
    raw = "I;16B" if frame.big_endian else "I;16"
    image = Image.frombuffer(
        raw, (frame.width, frame.height), data, "raw", raw, frame.step_bytes, 1
    )
    return _depth(image)


def _depth(image: Image.Image) -> Image.Image:
    """Show near as bright, far as dark, unknown as black."""
    known = image.convert("I")
    low, high = _range(known)
    if high <= low:
        low = high - 1.0
    scale = (255.0 - FAINTEST) / (high - low)
    grey = known.point(lambda v: v * -scale + (255.0 + low * scale)).convert("L")
    nothing = known.point(lambda v: v * 255.0).convert("L").point(lambda v: 255 if v else 0)
    return Image.composite(grey, Image.new("L", grey.size, 0), nothing).convert("RGB")


def _range(image: Image.Image) -> tuple[float, float]:
    """Return the least and the greatest of what was measured."""
    small = image.resize((min(image.width, 320), min(image.height, 240)), Image.Resampling.NEAREST)
    values = sorted(v for v in array("i", small.tobytes()) if v > 0)
    if not values:
        return 0.0, 1.0
    # A few stray points must not turn the rest black.
    return float(values[len(values) // 100]), float(values[-1 - len(values) // 100])


def _rows(frame: RawFrame, size: int) -> bytes:
    if frame.step_bytes < frame.width * size:
        raise NothingToSee(said("The frame is broken: its rows are too short."))
    wanted = frame.step_bytes * frame.height
    # The last row may come without its padding.
    least = wanted - frame.step_bytes + frame.width * size
    if not least <= len(frame.data) <= wanted:
        raise NothingToSee(
            said(
                "The frame is broken: {found} bytes where {wanted} should be.",
                found=f"{len(frame.data):,}",
                wanted=f"{wanted:,}",
            )
        )
    return frame.data.ljust(wanted, b"\0")


def _check_size(width: int, height: int) -> None:
    if width < 1 or height < 1:
        raise NothingToSee(said("The frame is empty."))
    if width * height > MOST_PIXELS:
        raise NothingToSee(_too_large(f"{width} x {height}", f"{MOST_PIXELS // 10**6} megapixels"))


def _too_large(found: str, most: str) -> str:
    return said("The frame is too large to show: {found}, at most {most}.", found=found, most=most)
