"""Pictures of a link: QR codes, through segno, for a chat and for a terminal."""

from __future__ import annotations

from io import BytesIO
from typing import Final

import segno

QUIET: Final = 4  # modules of light border that a reader expects
SCALE: Final = 8  # pixels a module
# A terminal is mostly dark, so the light modules are what is printed.
_HALVES: Final = {(0, 0): "█", (0, 1): "▀", (1, 0): "▄", (1, 1): " "}


def qr_png(text: str) -> bytes:
    """Return a PNG picture, black on white, with its border."""
    return drawn(qr_code(text))


def drawn(code: segno.QRCode) -> bytes:
    """Return the picture of a code that was made."""
    picture = BytesIO()
    code.save(picture, kind="png", scale=SCALE, border=QUIET, dark="#000", light="#fff")
    return picture.getvalue()


def qr_text(text: str) -> str:
    """Return lines for a terminal that shows light characters on dark: two modules a character."""
    rows = [tuple(row) for row in qr_code(text).matrix_iter(border=QUIET)]
    if len(rows) % 2:
        rows.append((0,) * len(rows[0]))
    return "\n".join(
        "".join(_HALVES[bool(upper), bool(lower)] for upper, lower in zip(*pair, strict=True))
        for pair in zip(rows[::2], rows[1::2], strict=True)
    )


def qr_code(text: str) -> segno.QRCode:
    """Return the code of a text: the longer half of making a picture."""
    return segno.make(text, micro=False, error="m")
