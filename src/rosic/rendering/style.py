"""How our own pictures look: one ink, one accent, one way to write."""

from __future__ import annotations

import unicodedata
from functools import lru_cache
from importlib.resources import files
from io import BytesIO
from typing import TYPE_CHECKING, TypeAlias

from PIL import Image, ImageDraw, ImageFont

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.robot.view import Colour

Say: TypeAlias = "Callable[[str], str]"
"""Returns a sentence as whoever will look reads it."""
PAPER: Colour = (255, 255, 255)
INK: Colour = (31, 41, 51)
FAINT: Colour = (123, 135, 148)
RULE: Colour = (226, 231, 237)
ACCENT: Colour = (38, 102, 214)
ACCENT_SOFT: Colour = (211, 225, 248)
ALERT: Colour = (207, 63, 63)
GOOD: Colour = (36, 142, 91)
SEVERAL: tuple[Colour, ...] = (
    ACCENT,
    ALERT,
    GOOD,
    (138, 75, 175),
    (196, 117, 12),
    (17, 130, 145),
)
"""One for each of several; from the seventh on they come again."""
FINER = 2  # drawn so many times larger, then made smaller: smooth edges
LONGEST_TEXT = 80
UNWRITTEN = "?"
# Its letters are larger than those of the other font in the same size.
WIDER = 0.92

# ---- fonts ----
# Both come along, so that every machine draws the same, whatever is installed there.

Font: TypeAlias = "ImageFont.FreeTypeFont | ImageFont.ImageFont"


def font(words: str, size: float) -> Font:
    """Return the font that a line is written in.

    It is the one that comes with Pillow, which has the letters of English and no others; with any
    other letter the whole line is in one that has those of Latin, Greek and Cyrillic scripts.
    """
    return _pillows(size) if words.isascii() else _wider(size * WIDER)


@lru_cache(maxsize=32)
def _pillows(size: float) -> Font:
    return ImageFont.load_default(size)


@lru_cache(maxsize=32)
def _wider(size: float) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(BytesIO(_wider_file()), size, layout_engine=ImageFont.Layout.BASIC)


@lru_cache(maxsize=1)
def _wider_file() -> bytes:
    return (files("rosic.rendering") / "fonts" / "DejaVuSans.ttf").read_bytes()


@lru_cache(maxsize=2048)
def _written(letter: str) -> str:
    """Return a letter as it can be written: itself, without its marks, or a question mark."""
    if letter.isascii() or letter.isspace() or _has(letter):
        return letter
    plain = unicodedata.normalize("NFKD", letter)
    return "".join([part for part in plain if part.isascii() or _has(part)]) or UNWRITTEN


def _has(letter: str) -> bool:
    """Whether the wider font has a letter: what it lacks leaves the paper as it is."""
    return _wider(14).getmask(letter).getbbox() is not None


class Sheet:
    """A sheet of paper, measured in pixels of the finished picture.

    Attributes:
        width, height: Of the finished picture.
    """

    def __init__(self, width: int, height: int, paper: Colour = PAPER, *, say: Say = str) -> None:
        self.width = width
        self.height = height
        self._say = say
        self._image = Image.new("RGB", (width * FINER, height * FINER), paper)
        self._pen = ImageDraw.Draw(self._image)

    def line(self, points: list[tuple[float, float]], colour: Colour, width: float = 1.0) -> None:
        """Draw through points."""
        if len(points) > 1:
            self._pen.line(_finer(points), fill=colour, width=round(width * FINER), joint="curve")

    def dashed(self, y: float, left: float, right: float, colour: Colour) -> None:
        """Draw a dashed level line."""
        x = left
        while x < right:
            self.line([(x, y), (min(x + 6, right), y)], colour, 1.5)
            x += 11

    def area(
        self, points: list[tuple[float, float]], colour: Colour, edge: Colour | None = None
    ) -> None:
        """Fill a polygon."""
        if len(points) > 2:  # noqa: PLR2004 - fewer enclose nothing
            self._pen.polygon(_finer(points), fill=colour, outline=edge, width=FINER)

    def dot(self, at: tuple[float, float], radius: float, colour: Colour, edge: Colour) -> None:
        """Draw a disc with an edge."""
        (x, y), r = at, radius
        box = _finer([(x - r, y - r), (x + r, y + r)])
        self._pen.ellipse(box, fill=colour, outline=edge, width=2 * FINER)

    def text(
        self,
        at: tuple[float, float],
        words: str,
        *,
        size: float = 14,
        colour: Colour = INK,
        anchor: str = "la",
    ) -> float:
        """Write one line; ``anchor`` as Pillow has it. Return how wide it is."""
        (x, y), plain = at, readable(self._say(words))
        face = font(plain, size * FINER)
        self._pen.text((x * FINER, y * FINER), plain, fill=colour, font=face, anchor=anchor)
        return face.getlength(plain) / FINER

    def paste(self, image: Image.Image, box: tuple[int, int, int, int]) -> None:
        """Put a picture into a box, its pixels kept sharp."""
        left, top, right, bottom = (value * FINER for value in box)
        sized = image.resize((right - left, bottom - top), Image.Resampling.NEAREST)
        self._image.paste(sized, (left, top))

    def finished(self) -> Image.Image:
        """Return the picture."""
        return self._image.reduce(FINER)


def readable(words: str) -> str:
    """Return one line that a font can write, of bounded length."""
    plain = "".join(letter if letter.isprintable() else " " for letter in words)
    if len(plain) > LONGEST_TEXT:
        plain = f"{plain[: LONGEST_TEXT - 3]}..."
    if plain.isascii():
        return plain
    return "".join(map(_written, unicodedata.normalize("NFC", plain)))


def _finer(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [(x * FINER, y * FINER) for x, y in points]
