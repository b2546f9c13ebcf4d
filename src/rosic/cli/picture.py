"""A code at the terminal: a sentence, and a picture for a phone's camera."""

from __future__ import annotations

import sys


def show(sentence: str, payload: str, *, picture: bool = True) -> None:
    """Print a sentence, and what a camera reads.

    Args:
        sentence: Holds the code.
        payload: What the picture shows; empty: there is none.
        picture: False for a terminal that cannot draw, or a reader that is none.
    """
    print(sentence, flush=True)
    if payload and picture and _draws():
        from rosic.authoriser.qr import qr_text  # noqa: PLC0415 - only for whoever wants a picture

        print(qr_text(payload), flush=True)


def _draws() -> bool:
    """Whether the terminal's letters include blocks."""
    try:
        "\u2588\u2580\u2584".encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
