"""How buttons are laid out beneath a message."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.message import Button

BUTTONS_A_ROW = 3
# What a phone held upright shows of all the labels in one row; it cuts off the rest.
LETTERS_A_ROW = 36


def rows(buttons: list[Button]) -> tuple[tuple[Button, ...], ...]:
    """Lay buttons out, as many a row as can be read."""
    laid: list[tuple[Button, ...]] = []
    row: tuple[Button, ...] = ()
    for button in buttons:
        wider = (*row, button)
        widest = max(len(one.label) for one in wider)  # all in a row are as wide as each other
        if row and (len(wider) > BUTTONS_A_ROW or widest * len(wider) > LETTERS_A_ROW):
            laid.append(row)
            wider = (button,)
        row = wider
    return (*laid, row) if row else tuple(laid)
