"""The parts of an event's content that what comes and what goes share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import msgspec

if TYPE_CHECKING:
    from collections.abc import Mapping

LONGEST_ADDRESS: Final = 512


class EncryptedFile(msgspec.Struct, frozen=True, omit_defaults=True):
    """Where a file lies, and how it is decrypted; without a key it lies there in the open.

    Attributes:
        url: ``mxc://...``.
        key: AES-256, base64url without padding.
        iv: Base64 without padding.
        sha256: Of what lies there.
    """

    url: str
    key: str = ""
    iv: str = ""
    sha256: str = ""


def relation(content: Mapping[str, Any]) -> tuple[str, str]:
    """Return how an event relates to another, and to which; empty for neither."""
    link = content.get("m.relates_to")
    if not isinstance(link, dict):
        return "", ""
    kind, target = link.get("rel_type"), link.get("event_id")
    if not isinstance(kind, str) or not isinstance(target, str):
        return "", ""
    return kind, target


def enclosed_id(content: Mapping[str, Any]) -> str:
    """Return what fetches the file of a content; empty where it has none that is well-formed."""
    held = content.get("file")
    if not isinstance(held, dict):
        return _written(EncryptedFile(_address(content.get("url"))))
    key, hashes = held.get("key"), held.get("hashes")
    if not isinstance(key, dict) or not isinstance(hashes, dict):
        return ""
    parts = [key.get("k"), held.get("iv"), hashes.get("sha256")]
    texts = [part for part in parts if isinstance(part, str) and part]
    if len(texts) < len(parts):
        return ""
    return _written(EncryptedFile(_address(held.get("url")), *texts))


def enclosed_file(text: str) -> EncryptedFile | None:
    """Return what `enclosed_id` wrote; None for what it did not."""
    try:
        return msgspec.json.decode(text, type=EncryptedFile)
    except msgspec.MsgspecError:
        return None


def _written(file: EncryptedFile) -> str:
    return msgspec.json.encode(file).decode() if file.url else ""


def _address(value: object) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_ADDRESS:
        return ""
    return value if value.startswith("mxc://") else ""
