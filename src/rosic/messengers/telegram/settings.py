"""The table of a Telegram messenger in the configuration."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Mapping

API_BASE = "https://api.telegram.org/bot"
LONGEST_POLL_S = 4
"""A tap carries no time. A poll that is answered late may bring an old one, so an answer must come
within the 5 s after which a pause counts as a gap: 4 s of waiting, and 1 s for the way."""

_KNOWN = (
    "kind",
    "name",
    "token",
    "api_base",
    "local_mode",
    "local_folder",
    "proxy",
    "poll_timeout_s",
)
_TOKEN = re.compile(r"[0-9]{1,20}:[A-Za-z0-9_-]{1,100}")
_ADDRESS = re.compile(r"https?://[^\s/?#]+(?:/[^\s?#]*)?")
_PROXY = re.compile(r"(?:https?|socks5h?)://[^\s/?#]+/?")


class TelegramSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What one bot needs.

    Attributes:
        token: As BotFather gave it.
        api_base: Where the Bot API is, up to and including ``/bot``.
        proxy: May hold a password, so it is a secret too; None for a direct connection.
        poll_timeout_s: How long Telegram keeps an empty request open, 1 to 4 s.
        local_mode: The Bot API server is one's own and runs with ``--local``: files of up to
            2000 MB, which it leaves in its folder on this computer.
        local_folder: That folder. Nothing outside is read, whatever the server says.
    """

    token: Secret
    api_base: str = API_BASE
    proxy: Secret | None = None
    poll_timeout_s: int = 3
    local_mode: bool = False
    local_folder: str = ""

    @property
    def file_base(self) -> str:
        """Where files are downloaded from; the token follows."""
        return f"{self.api_base.removesuffix('bot')}file/bot"


def read_settings(name: str, settings: Mapping[str, Any]) -> TelegramSettings:
    """Check the table of the messenger ``name``.

    Raises:
        ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
    """
    for key in settings:
        if key not in _KNOWN:
            known = ", ".join(_KNOWN)
            raise ConfigurationError(
                f"The messenger {name} does not know the setting {key}.", hint=f"It knows: {known}."
            )
    api_base = _api_base(name, settings.get("api_base", API_BASE))
    return TelegramSettings(
        token=_token(name, settings.get("token")),
        api_base=api_base,
        proxy=_proxy(name, settings.get("proxy")),
        poll_timeout_s=_poll_timeout_s(name, settings.get("poll_timeout_s", 3)),
        local_mode=bool(settings.get("local_mode", False)),
        local_folder=_local_folder(name, settings, api_base),
    )


def _text(value: object) -> str:
    return value.reveal() if isinstance(value, Secret) else value if isinstance(value, str) else ""


def _token(name: str, value: object) -> Secret:
    text = _text(value).strip()
    if not text:
        raise ConfigurationError(
            f"The messenger {name} has no token.",
            hint='BotFather gives one; write token = { env = "NAME" } or { file = "PATH" }.',
        )
    if not _TOKEN.fullmatch(text):
        raise ConfigurationError(
            f"The token of the messenger {name} does not look like a Telegram token.",
            hint="It is a number, a colon and about 35 letters, as BotFather shows it.",
        )
    return Secret(text)


def _api_base(name: str, value: object) -> str:
    text = _text(value).rstrip("/")
    if not _ADDRESS.fullmatch(text):
        raise ConfigurationError(
            f"api_base of the messenger {name} is not an address.",
            hint=f"It looks like {API_BASE} or http://127.0.0.1:8081/bot.",
        )
    return text if text.endswith("/bot") else f"{text}/bot"


def _local_folder(name: str, settings: Mapping[str, Any], api_base: str) -> str:
    mode, folder = settings.get("local_mode", False), _text(settings.get("local_folder", ""))
    if type(mode) is not bool:
        raise ConfigurationError(f"local_mode of the messenger {name} must be true or false.")
    if not mode and not folder:
        return ""
    if not mode or api_base == API_BASE:
        raise ConfigurationError(
            f"The messenger {name} has a local Bot API server only in part.",
            hint="It needs api_base, local_mode = true and local_folder together.",
        )
    if not folder.startswith("/") or ".." in folder.split("/") or folder.strip("/") == "":
        raise ConfigurationError(
            f"local_folder of the messenger {name} is not a folder's full path.",
            hint="Name the folder that the Bot API server keeps its files in (its --dir).",
        )
    return folder.rstrip("/")


def _proxy(name: str, value: object) -> Secret | None:
    if value is None:
        return None
    text = _text(value)
    if not _PROXY.fullmatch(text):
        raise ConfigurationError(
            f"proxy of the messenger {name} is not an address.",
            hint="It looks like http://127.0.0.1:3128 or socks5://127.0.0.1:1080.",
        )
    return Secret(text)


def _poll_timeout_s(name: str, value: object) -> int:
    if type(value) is not int or not 1 <= value <= LONGEST_POLL_S:
        raise ConfigurationError(
            f"poll_timeout_s of the messenger {name} must be a whole number from 1 to"
            f" {LONGEST_POLL_S}.",
            hint="A tap on a button carries no time, so a longer wait could hide an old tap.",
        )
    return value
