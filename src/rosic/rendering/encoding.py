"""From a picture in memory to bytes of bounded size."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from PIL import Image

from rosic.core.i18n import said
from rosic.core.robot.view import Drawing
from rosic.errors import NothingToSee

if TYPE_CHECKING:
    from collections.abc import Sequence

MOST_BYTES = 4_000_000
QUALITIES = (82, 65, 45, 30)
LOW_QUALITIES = (40, 25)
COLOURS, LOW_COLOURS = 128, 48


def photograph(image: Image.Image, *, low: bool) -> Drawing:
    """Return a JPEG."""
    plain = _without_alpha(image)
    for quality in LOW_QUALITIES if low else QUALITIES:
        buffer = io.BytesIO()
        plain.save(buffer, "JPEG", quality=quality, optimize=True)
        if buffer.tell() <= MOST_BYTES:
            return Drawing("image/jpeg", buffer.getvalue(), *image.size)
    raise NothingToSee(said("The picture is too large to send."))


def graphic(image: Image.Image, *, low: bool) -> Drawing:
    """Return a PNG of few colours: lines, letters and flat areas."""
    few = image.quantize(32 if low else 192, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, "PNG", optimize=True)
    if buffer.tell() > MOST_BYTES:
        return photograph(image, low=low)
    return Drawing("image/png", buffer.getvalue(), *image.size)


def exact(image: Image.Image) -> Drawing:
    """Return a PNG of all colours there are."""
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return Drawing("image/png", buffer.getvalue(), *image.size)


def animation(images: Sequence[Image.Image], every_s: float, *, low: bool) -> Drawing:
    """Return a GIF that repeats; all frames share the colours of the first."""
    colours = LOW_COLOURS if low else COLOURS
    first = _without_alpha(images[0]).quantize(colours, method=Image.Quantize.MEDIANCUT)
    frames = [first]
    for image in images[1:]:
        same = _without_alpha(image).resize(first.size) if image.size != first.size else image
        frames.append(_without_alpha(same).quantize(palette=first))
    buffer = io.BytesIO()
    first.save(
        buffer, "GIF", save_all=True, append_images=frames[1:], loop=0,
        duration=max(20, round(every_s * 1000)), optimize=False,
    )  # fmt: skip
    if buffer.tell() > MOST_BYTES:
        raise NothingToSee(said("The clip is too large to send. Ask for it with low."))
    return Drawing("image/gif", buffer.getvalue(), *first.size)


def shrunk(image: Image.Image, within: int) -> Image.Image:
    """Return a picture of at most so many pixels a side."""
    scale = within / max(image.size)
    if scale >= 1:
        return image
    size = (max(1, round(image.width * scale)), max(1, round(image.height * scale)))
    return image.resize(size, Image.Resampling.LANCZOS)


def _without_alpha(image: Image.Image) -> Image.Image:
    if image.mode != "RGBA":
        return image.convert("RGB")
    white = Image.new("RGBA", image.size, (255, 255, 255, 255))
    return Image.alpha_composite(white, image).convert("RGB")
