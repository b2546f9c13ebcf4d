"""Canonical JSON, and signatures over it.

Matrix specification v1.11, appendices: "Canonical JSON", "Signing JSON" and "Unpadded Base64".
A signature says only that whoever has a key said these words; whose key it is stands elsewhere.
"""

from __future__ import annotations

import binascii
import json
import re
from base64 import b64decode, b64encode
from typing import TYPE_CHECKING, Any, Final

from nacl.exceptions import CryptoError
from nacl.signing import SigningKey, VerifyKey

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

LARGEST: Final = 2**53 - 1
LONGEST: Final = 8_192
"""Nothing larger is signed here: the keys of a device take less than 1,000 bytes."""
DEEPEST: Final = 32
KEY_BYTES: Final = 32
SIGNATURE_BYTES: Final = 64
ED25519: Final = "ed25519"

_LEFT_OUT: Final = ("signatures", "unsigned")
_BASE64: Final = re.compile(r"[A-Za-z0-9+/]*")


class NotCanonical(ValueError):
    """This value has no canonical JSON, or one that is longer than anything that is signed."""


# ---- canonical JSON ----


def canonical_json(value: object) -> bytes:
    """Return the one way to write a value down: sorted keys, no white space, UTF-8, whole numbers.

    Appendices, "Canonical JSON". Keys are sorted by their code points.

    Raises:
        NotCanonical: It holds a fraction, a number beyond 2**53 - 1, half of a character, or
            something that is no JSON; or it is too deep or too long.
    """
    _check(value)
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), sort_keys=True)
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise NotCanonical("a text holds half of a character") from error


def _check(value: object) -> None:
    """Look at everything once, before anything is written: what a stranger sends has no end."""
    room = LONGEST
    waiting = [(value, 0)]
    while waiting:
        one, depth = waiting.pop()
        room -= _size(one)
        if room < 0 or depth > DEEPEST:
            raise NotCanonical("it is too long or too deep to be signed")
        waiting += [(part, depth + 1) for part in _parts(one)]


def _size(value: object) -> int:
    """Return the fewest bytes that a value takes by itself."""
    if value is None or isinstance(value, bool):
        return 4
    if isinstance(value, str):
        return len(value) + 2
    if isinstance(value, int):
        if not -LARGEST <= value <= LARGEST:
            raise NotCanonical("a number is beyond 2**53 - 1")
        return 1
    if isinstance(value, dict | list):
        return 2 + len(value)
    raise NotCanonical(f"{type(value).__name__} has no canonical JSON")


def _parts(value: object) -> Iterator[object]:
    if isinstance(value, dict):
        for key, part in value.items():
            if not isinstance(key, str):
                raise NotCanonical("a key is not a text")
            yield key
            yield part
    elif isinstance(value, list):
        yield from value


# ---- unpadded Base64 ----


def to_base64(data: bytes) -> str:
    """Return bytes as Matrix writes them: Base64 without the padding ("Unpadded Base64")."""
    return b64encode(data).decode().rstrip("=")


def from_base64(text: object, length: int) -> bytes | None:
    """Read exactly so many bytes; None if that is not what the text is.

    Each value has one spelling only: where a key is named by its Base64, another spelling of it
    would be another name for the same key.
    """
    if not isinstance(text, str) or not _BASE64.fullmatch(text):
        return None
    try:
        data = b64decode(text + "=" * (-len(text) % 4), validate=True)
    except binascii.Error:
        return None
    return data if len(data) == length and to_base64(data) == text else None


# ---- signatures ----


def public_part(key: SigningKey) -> str:
    """Return the public half of a key, as Matrix writes it."""
    return to_base64(bytes(key.verify_key))


def signed_part(value: Mapping[str, Any]) -> bytes:
    """Return what a signature is over: all but ``signatures`` and ``unsigned``.

    Raises:
        NotCanonical: It has no canonical JSON.
    """
    return canonical_json({name: part for name, part in value.items() if name not in _LEFT_OUT})


def with_signature(
    value: Mapping[str, Any], user: str, key_id: str, signature: str
) -> dict[str, Any]:
    """Return an object with one more signature; those that it has are kept ("Signing JSON")."""
    signatures = {name: dict(of) for name, of in value.get("signatures", {}).items()}
    signatures.setdefault(user, {})[key_id] = signature
    return {**value, "signatures": signatures}


def sign(value: Mapping[str, Any], user: str, key: SigningKey) -> dict[str, Any]:
    """Return an object signed with a key that is named by itself, as cross-signing keys are.

    Raises:
        NotCanonical: It has no canonical JSON.
    """
    signature = to_base64(key.sign(signed_part(value)).signature)
    return with_signature(value, user, f"{ED25519}:{public_part(key)}", signature)


def is_signed(value: Mapping[str, Any], user: str, name: str, public: str) -> bool:
    """Whether a user's key signed this object ("Checking for a Signature").

    Args:
        value: With its signatures, as it came.
        user: Under whom the signature must stand.
        name: Of the key: a device's id, or the Base64 of a cross-signing key.
        public: The key itself.
    """
    signature = from_base64(signature_of(value, user, name), SIGNATURE_BYTES)
    key = from_base64(public, KEY_BYTES)
    if signature is None or key is None:
        return False
    try:
        VerifyKey(key).verify(signed_part(value), signature)
    except (CryptoError, NotCanonical, ValueError):
        return False
    return True


def signature_of(value: Mapping[str, Any], user: str, name: str) -> object:
    """Return what stands where that signature would; None for nothing. Nothing is checked."""
    signatures = value.get("signatures")
    of_user = signatures.get(user) if isinstance(signatures, dict) else None
    return of_user.get(f"{ED25519}:{name}") if isinstance(of_user, dict) else None
