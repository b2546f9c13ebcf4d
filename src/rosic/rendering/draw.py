"""The one way in: a subject becomes a picture."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from PIL import Image

from rosic.core.i18n import said
from rosic.core.robot.view import (
    Clip,
    CompressedFrame,
    Drawing,
    OccupancyMap,
    PathsView,
    PathView,
    RawFrame,
    Scene,
    TimeSeries,
)
from rosic.errors import NothingToSee
from rosic.rendering.charts import chart
from rosic.rendering.frames import decoded, raster
from rosic.rendering.maps import grid_map
from rosic.rendering.paths import way, ways_together
from rosic.rendering.scenes import scene_image

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.view import Content, Subject
    from rosic.rendering.style import Say


# ---- encoding ----

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
        buffer,
        "GIF",
        save_all=True,
        append_images=frames[1:],
        loop=0,
        duration=max(20, round(every_s * 1000)),
        optimize=False,
    )
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


# ---- drawing a subject ----

WITHIN, LOW_WITHIN = 1280, 360
CLIP_WITHIN, LOW_CLIP_WITHIN = 480, 240
MOST_FRAMES = 24
TALL = 0.625  # a scene's height for its width


def draw(subject: Subject, *, low: bool = False, say: Say = str) -> Drawing:
    """Draw; `rosic.contracts.renderer.Renderer` says what is promised."""
    if isinstance(subject, TimeSeries):
        return graphic(chart(subject, low=low, say=say), low=low)
    if isinstance(subject, PathView):
        return graphic(way(subject, low=low, say=say), low=low)
    if isinstance(subject, PathsView):
        return graphic(ways_together(subject, low=low, say=say), low=low)
    if isinstance(subject, OccupancyMap):
        return graphic(grid_map(subject, low=low, say=say), low=low)
    if isinstance(subject, Clip):
        return _clip(subject, low=low, say=say)
    return photograph(_still(subject, LOW_WITHIN if low else WITHIN, say), low=low)


def _clip(clip: Clip, *, low: bool, say: Say) -> Drawing:
    if not clip.frames:
        raise NothingToSee(said("There is nothing to draw yet."))
    within = LOW_CLIP_WITHIN if low else CLIP_WITHIN
    images = [_still(frame, within, say) for frame in clip.frames[:MOST_FRAMES]]
    return animation(images, clip.every_s, low=low)


def _still(content: Content, within: int, say: Say) -> Image.Image:
    if isinstance(content, CompressedFrame):
        return shrunk(decoded(content, within), within)
    if isinstance(content, RawFrame):
        return shrunk(raster(content), within)
    if isinstance(content, Scene):
        return scene_image(content, within, round(within * TALL))
    return grid_map(content, low=within <= LOW_CLIP_WITHIN, say=say)


def portrait(scene: Scene, width: int, height: int) -> Drawing:
    """Draw a scene for a page, of any shape."""
    return exact(scene_image(scene, width, height))
