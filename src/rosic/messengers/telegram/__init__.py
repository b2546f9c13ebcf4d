"""Telegram, by long polling: outbound connections only (docs/messengers/telegram.md)."""

from __future__ import annotations

from rosic.messengers.telegram.messenger import TelegramMessenger, telegram_messenger

__all__ = ["TelegramMessenger", "telegram_messenger"]
