"""Keyboards under messages (https://core.telegram.org/bots/api#inlinekeyboardmarkup)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosic.testing.telegram.refusals import bad_request

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject

MARKUPS: dict[str, frozenset[str]] = {
    "inline_keyboard": frozenset({"inline_keyboard"}),
    "keyboard": frozenset(
        {
            "keyboard",
            "is_persistent",
            "resize_keyboard",
            "one_time_keyboard",
            "input_field_placeholder",
            "selective",
        }
    ),
    "remove_keyboard": frozenset({"remove_keyboard", "selective"}),
    "force_reply": frozenset({"force_reply", "input_field_placeholder", "selective"}),
}
"""The four markups by the field that tells them apart, with all their fields."""

ACTIONS = frozenset(
    {
        "url",
        "callback_data",
        "web_app",
        "login_url",
        "switch_inline_query",
        "switch_inline_query_current_chat",
        "switch_inline_query_chosen_chat",
        "copy_text",
        "callback_game",
        "pay",
    }
)
"""Exactly one of these (https://core.telegram.org/bots/api#inlinekeyboardbutton)."""

DECORATION = frozenset({"text", "icon_custom_emoji_id", "style", "disabled"})
MAX_CALLBACK_BYTES = 64
MAX_BUTTONS = 100
"""Telegram's docs are silent; more than 100 buttons are refused by common experience."""


def checked(markup: JsonObject | None, *, inline_only: bool = False) -> JsonObject | None:
    """Return a markup ready to be kept, or None for an empty one.

    Raises:
        ApiError: 400.
    """
    if not markup:
        return None
    kind = next((name for name in MARKUPS if name in markup), None)
    if kind is None:
        raise bad_request("object expected as reply markup")
    if unknown := set(markup) - MARKUPS[kind]:
        # Telegram ignores unknown fields; a correct client sends none.
        raise bad_request(f"can't parse reply keyboard markup: unknown field {min(unknown)!r}")
    if kind == "inline_keyboard":
        rows = _rows(markup["inline_keyboard"], "inline_keyboard")
        cleaned = [[_inline_button(button) for button in row] for row in rows]
        return {"inline_keyboard": [row for row in cleaned if row]} if any(cleaned) else None
    if inline_only:
        # https://core.telegram.org/bots/api#editmessagetext takes an inline keyboard only.
        raise bad_request("inline keyboard expected")
    if kind == "keyboard":
        _rows(markup["keyboard"], "keyboard")
    return markup


def buttons(markup: JsonObject | None) -> list[JsonObject]:
    """Return the buttons of an inline keyboard, row after row."""
    return [button for row in (markup or {}).get("inline_keyboard", []) for button in row]


def _rows(rows: object, field: str) -> list[list[Any]]:
    if not isinstance(rows, list):
        raise bad_request(f'field "{field}" must be of type Array')
    if not all(isinstance(row, list) for row in rows):
        raise bad_request(f'field "{field}" must be an Array of Arrays')
    if sum(len(row) for row in rows) > MAX_BUTTONS:
        raise bad_request("REPLY_MARKUP_TOO_LONG")
    return rows


def _inline_button(button: object) -> JsonObject:
    prefix = "can't parse inline keyboard button: "
    if not isinstance(button, dict):
        raise bad_request(prefix + "InlineKeyboardButton must be an Object")
    text = button.get("text")
    if not isinstance(text, str):
        raise bad_request(prefix + 'Can\'t find field "text"')
    if not text.strip():
        raise bad_request("BUTTON_TEXT_INVALID")
    actions = ACTIONS & set(button)
    if not actions:
        raise bad_request(prefix + "Text buttons are unallowed in the inline keyboard")
    if len(actions) > 1 or set(button) - ACTIONS - DECORATION:
        raise bad_request("BUTTON_TYPE_INVALID")
    _check_action(button)
    return button


def _check_action(button: JsonObject) -> None:
    """`callback_data` has 1-64 bytes; a URL names http, https or tg (inlinekeyboardbutton)."""
    if "callback_data" in button:
        data = button["callback_data"]
        if not isinstance(data, str) or not 1 <= len(data.encode()) <= MAX_CALLBACK_BYTES:
            raise bad_request("BUTTON_DATA_INVALID")
    if "url" in button and not str(button["url"]).startswith(("http://", "https://", "tg://")):
        raise bad_request(
            f"inline keyboard button URL '{button['url']}' is invalid: Wrong HTTP URL"
        )
