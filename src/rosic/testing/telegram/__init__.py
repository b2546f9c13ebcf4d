"""A strict stand-in for Telegram's Bot API.

It refuses what Telegram refuses, in Telegram's words, and writes down what a correct client does
not do. Embedded: `async with FakeTelegram() as server:`. As a program: `python -m
rosic.testing.telegram`, driven over HTTP through `Control`. The behaviour is described in
docs/fake-bot-api.md.
"""

from __future__ import annotations

import sys

from rosic.errors import how_to_install

try:
    from rosic.testing.telegram.client import Control
    from rosic.testing.telegram.refusals import ApiError, ControlError
    from rosic.testing.telegram.server import DEFAULT_TOKEN, FakeTelegram
    from rosic.testing.telegram.settings import Limits, Settings
except ModuleNotFoundError as missing:
    if missing.name != "aiohttp":
        raise
    sentence = f"The stand-in for Telegram needs aiohttp: {how_to_install('testing')}."
    if sys.argv[:1] == ["-m"]:  # `python -m rosic.testing.telegram` looks for the program here
        raise SystemExit(sentence) from None
    raise ModuleNotFoundError(sentence, name=missing.name) from None

__all__ = [
    "DEFAULT_TOKEN",
    "ApiError",
    "Control",
    "ControlError",
    "FakeTelegram",
    "Limits",
    "Settings",
]
