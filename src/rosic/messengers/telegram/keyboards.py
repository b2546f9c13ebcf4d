"""Buttons under a message, as Telegram takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from telegram import InlineKeyboardButton, InlineKeyboardMarkup

from rosic.errors import MessengerFault
from rosic.messengers.telegram import text as texts

if TYPE_CHECKING:
    from rosic.core.message import Outbound

NONCE_BYTES: Final = 64


def keyboard_of(outbound: Outbound) -> InlineKeyboardMarkup | None:
    """Return the buttons under a message; None where there are none.

    Raises:
        MessengerFault: Telegram would take one of them from nobody. Nothing was sent.
    """
    if not outbound.buttons:
        return None
    for button in (button for row in outbound.buttons for button in row):
        if not 1 <= len(button.nonce.encode()) <= NONCE_BYTES or not button.label.strip():
            raise MessengerFault("A button without a label or a usable nonce. Nothing was sent.")
    rows = [
        [
            InlineKeyboardButton(
                texts.shorten(button.label, texts.LABEL_UNITS), callback_data=button.nonce
            )
            for button in row
        ]
        for row in outbound.buttons
    ]
    return InlineKeyboardMarkup(rows)
