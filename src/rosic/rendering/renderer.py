"""Who draws here, if anybody can: nothing of Pillow is loaded before the first picture."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.renderer import Renderer
    from rosic.core.robot.view import Drawing, Scene, Subject


def renderer() -> Renderer | None:
    """Return who draws; None where Pillow is not installed.

    Nothing of it is loaded before the first picture is drawn.
    """
    return None if find_spec("PIL") is None else _draw


def _draw(subject: Subject, *, low: bool = False, say: Callable[[str], str] = str) -> Drawing:
    draw = cast("Renderer", import_module("rosic.rendering.draw").draw)
    return draw(subject, low=low, say=say)


def jpeg_drawer() -> Callable[[Scene], bytes] | None:
    """Return what draws the frames of simulated cameras; None where Pillow is not installed."""
    return None if renderer() is None else lambda scene: _draw(scene, low=True).content
