"""The one way in: a subject becomes a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.robot.view import Clip, Curve, Encoded, Grid, PathsView, PathView, Raster, Scene
from rosic.errors import NothingToSee
from rosic.rendering.charts import chart
from rosic.rendering.encoding import animation, exact, graphic, photograph, shrunk
from rosic.rendering.frames import decoded, raster
from rosic.rendering.maps import grid_map
from rosic.rendering.scenes import scene_image
from rosic.rendering.ways import way, ways_together

if TYPE_CHECKING:
    from PIL import Image

    from rosic.core.robot.view import Content, Drawing, Subject
    from rosic.rendering.style import Say

WITHIN, LOW_WITHIN = 1280, 360
CLIP_WITHIN, LOW_CLIP_WITHIN = 480, 240
MOST_FRAMES = 24
TALL = 0.625  # a scene's height for its width


def draw(subject: Subject, *, low: bool = False, say: Say = str) -> Drawing:
    """Draw; `rosic.contracts.renderer.Painter` says what is promised."""
    if isinstance(subject, Curve):
        return graphic(chart(subject, low=low, say=say), low=low)
    if isinstance(subject, PathView):
        return graphic(way(subject, low=low, say=say), low=low)
    if isinstance(subject, PathsView):
        return graphic(ways_together(subject, low=low, say=say), low=low)
    if isinstance(subject, Grid):
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
    if isinstance(content, Encoded):
        return shrunk(decoded(content, within), within)
    if isinstance(content, Raster):
        return shrunk(raster(content), within)
    if isinstance(content, Scene):
        return scene_image(content, within, round(within * TALL))
    return grid_map(content, low=within <= LOW_CLIP_WITHIN, say=say)


def portrait(scene: Scene, width: int, height: int) -> Drawing:
    """Draw a scene for a page, of any shape."""
    return exact(scene_image(scene, width, height))
