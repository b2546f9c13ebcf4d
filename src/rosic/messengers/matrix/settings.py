"""What one Matrix account needs, read from its table in the configuration."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Mapping

_KNOWN: Final = (
    "kind",
    "name",
    "homeserver",
    "user",
    "password",
    "token",
    "folder",
    "device_name",
    "require_verified",
    "trust_on_first_use",
)
_ADDRESS: Final = re.compile(
    r"(?P<scheme>https?)://(?P<host>\[[0-9A-Fa-f:]+\]|[^\s/?#:@]+)(?::\d{1,5})?"
)
_LOOPBACK: Final = re.compile(r"localhost|127(?:\.\d{1,3}){3}|\[::1\]")
USER: Final = re.compile(r"@[^\s:@]{1,200}:[^\s@/?#]{1,200}")
"""An account's id (https://spec.matrix.org/latest/appendices/#user-identifiers); old ones hold more
signs than new ones may."""
LONGEST_NAME: Final = 100


class MatrixSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What one account needs.

    Attributes:
        homeserver: Where its client-server API is; nothing but https, except on this computer.
        user: ``@bot:example.org``.
        password: It may be left out where a token is given; with one, a device that was signed
            out signs in again by itself.
        token: An access token of a device that is signed in already.
        folder: Its keys and sessions live there. Whoever reads it reads everything that was said.
        device_name: What people see among the account's devices.
        require_verified: Nothing moves unless what asks for it came from a verified device, in an
            encrypted room. A stop always counts.
        trust_on_first_use: Whoever's keys are seen first counts as verified, until they change.
    """

    homeserver: str
    user: str
    password: Secret | None = None
    token: Secret | None = None
    folder: Path
    device_name: str = "ROSIC"
    require_verified: bool = True
    trust_on_first_use: bool = False


def read_settings(name: str, settings: Mapping[str, Any]) -> MatrixSettings:
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
    password, token = _secret(settings.get("password")), _secret(settings.get("token"))
    if password is None and token is None:
        raise ConfigurationError(
            f"The messenger {name} has no password and no token.",
            hint='Write password = { env = "NAME" } or password = { file = "PATH" }.',
        )
    return MatrixSettings(
        homeserver=_homeserver(name, settings.get("homeserver")),
        user=_user(name, settings.get("user")),
        password=password,
        token=token,
        folder=_folder(name, settings.get("folder")),
        device_name=_device_name(name, settings.get("device_name", "ROSIC")),
        require_verified=_flag(name, settings, "require_verified", default=True),
        trust_on_first_use=_flag(name, settings, "trust_on_first_use", default=False),
    )


def _text(value: object) -> str:
    return value.reveal() if isinstance(value, Secret) else value if isinstance(value, str) else ""


def _secret(value: object) -> Secret | None:
    text = _text(value).strip()
    return Secret(text) if text else None


def _homeserver(name: str, value: object) -> str:
    text = _text(value).rstrip("/")
    found = _ADDRESS.fullmatch(text)
    if found is None:
        raise ConfigurationError(
            f"homeserver of the messenger {name} is not an address.",
            hint="It looks like https://matrix.example.org, without a path.",
        )
    if found["scheme"] == "http" and not _LOOPBACK.fullmatch(found["host"]):
        raise ConfigurationError(
            f"homeserver of the messenger {name} is reached without encryption.",
            hint="Write https://; http:// is for a homeserver on this computer only.",
        )
    return text


def _user(name: str, value: object) -> str:
    text = _text(value)
    if not USER.fullmatch(text):
        raise ConfigurationError(
            f"user of the messenger {name} is not an account of Matrix.",
            hint="It looks like @robots:example.org.",
        )
    return text


def _folder(name: str, value: object) -> Path:
    text = _text(value)
    if not text.strip():
        raise ConfigurationError(
            f"The messenger {name} has no folder for its keys.",
            hint='Write folder = "PATH"; keep it as safe as a password, and back it up.',
        )
    if not Path(text).is_absolute():
        raise ConfigurationError(
            f"folder of the messenger {name} is not a folder's full path.",
            hint="Its keys must be found from wherever the gateway is started.",
        )
    return Path(text)


def _device_name(name: str, value: object) -> str:
    text = _text(value).strip()
    if not text or len(text) > LONGEST_NAME or not text.isprintable():
        raise ConfigurationError(
            f"device_name of the messenger {name} must be a short name on one line."
        )
    return text


def _flag(name: str, settings: Mapping[str, Any], key: str, *, default: bool) -> bool:
    value = settings.get(key, default)
    if type(value) is not bool:
        raise ConfigurationError(f"{key} of the messenger {name} must be true or false.")
    return value
