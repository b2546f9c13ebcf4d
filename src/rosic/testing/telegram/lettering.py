"""How wide letters are, and where lines break: without a font, the same on every machine.

The widths are those of Helvetica, which Arial and Liberation Sans share. A drawing that also says
how long each line is meant to be looks right in any other font.
"""

from __future__ import annotations

import unicodedata
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

ELLIPSIS: Final = "\u2026"

# Thousandths of the letter size.
_WIDTHS: Final = {
    letter: width
    for width, letters in (
        (191, "'"),
        (222, "ijl\u2018\u2019"),
        (260, "|"),
        (278, " !,./:;I[\\]ft\u00b7\u00a0"),
        (333, "()-`r\u201c\u201d\u00b2\u00b3"),
        (334, "{}"),
        (350, "\u2022"),
        (355, '"'),
        (389, "*"),
        (400, "\u00b0"),
        (469, "^"),
        (500, "Jcksvxyz"),
        (549, "\u2264\u2265"),
        (556, "#$0123456789?L_abdeghnopqu\u2013\u20ac"),
        (584, "+<=>~\u00b1\u00d7"),
        (611, "FTZ\u00df"),
        (667, "&ABEKPSVXY"),
        (722, "CDHNRUw"),
        (778, "GOQ"),
        (833, "Mm"),
        (889, "%"),
        (944, "W"),
        (1000, "\u2014\u2026\u2190\u2191\u2192\u2193"),
        (1015, "@"),
    )
    for letter in letters
}
_USUAL: Final = 570
_WIDE: Final = 1000


def width_of(text: str, size: float) -> float:
    """Return how wide a text is, in the unit of the letter size."""
    return sum(map(_width, text)) * size / 1000


def _width(letter: str) -> int:
    known = _WIDTHS.get(letter)
    if known is not None:
        return known
    if unicodedata.combining(letter) or unicodedata.category(letter) in {"Cf", "Cc"}:
        return 0
    if unicodedata.east_asian_width(letter) in {"W", "F"}:
        return _WIDE
    base = unicodedata.normalize("NFD", letter)[0]
    return _WIDTHS.get(base, _USUAL)


def wrapped(text: str, size: float, most: float) -> list[str]:
    """Return a text as lines no wider than ``most``.

    Lines break at spaces; a word that is wider than a line breaks anywhere. White space at the
    beginning of a line of the text stays.
    """
    return [line for said in text.split("\n") for line in _broken(said, size, most)]


def _broken(text: str, size: float, most: float) -> Iterator[str]:
    line = text[: len(text) - len(text.lstrip())]
    begun = False
    for whole in text.split():
        word = whole
        wider = f"{line} {word}" if begun else f"{line}{word}"
        if begun and width_of(wider, size) > most:
            yield line
            wider = word
        while len(wider) > 1 and width_of(wider, size) > most:
            at = _fits(wider, size, most)
            yield wider[:at]
            wider = wider[at:]
        line, begun = wider, True
    yield line


def _fits(text: str, size: float, most: float) -> int:
    """Return how many letters of a text fit; one does in any case."""
    at = 1
    while at < len(text) and width_of(text[: at + 1], size) <= most:
        at += 1
    return at


def cut(text: str, size: float, most: float) -> str:
    """Return a text on one line, with an ellipsis where it had to be cut off."""
    text = " ".join(text.split())
    if width_of(text, size) <= most:
        return text
    kept = _fits(text, size, most - width_of(ELLIPSIS, size))
    return text[:kept].rstrip() + ELLIPSIS
