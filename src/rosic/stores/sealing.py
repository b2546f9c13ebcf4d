"""Personal content under lock: one key for each container, all of them wrapped by a root key.

Erasing a container is erasing its key. A sealed letter is bound to its container, its kind and
what it belongs to, so that nobody can put one in another's place.
"""

from __future__ import annotations

from nacl.bindings import (
    crypto_aead_xchacha20poly1305_ietf_decrypt as decrypt,
)
from nacl.bindings import (
    crypto_aead_xchacha20poly1305_ietf_encrypt as encrypt,
)
from nacl.exceptions import CryptoError
from nacl.utils import random

KEY_BYTES = 32
NONCE_BYTES = 24
FORM = b"\x01"  # first byte of everything sealed: which way it was sealed


class Unreadable(Exception):
    """Sealed under another key, belonging elsewhere, or damaged."""


class Key:
    """One container's key; never shown.

    Attributes:
        container: A principal's or a robot's id.
        wrapped: The key as it may be stored.
    """

    __slots__ = ("_binding", "_key", "container", "wrapped")

    def __init__(self, container: str, key: bytes, wrapped: bytes) -> None:
        self.container = container
        self.wrapped = wrapped
        self._key = key
        self._binding = binding(container)

    def seal(self, kind: bytes, subject: bytes, content: bytes) -> bytes:
        """Seal one letter.

        Args:
            kind: One byte.
            subject: What the letter belongs to.
            content: What it says.
        """
        nonce = random(NONCE_BYTES)
        sealed = encrypt(content, self._binding + kind + subject, nonce, self._key)
        return FORM + nonce + sealed

    def unseal(self, kind: bytes, subject: bytes, sealed: bytes) -> bytes:
        """Open one letter.

        Raises:
            Unreadable: It does not belong here, or it was changed.
        """
        return opened(sealed, self._binding + kind + subject, self._key)


class Root:
    """The root key; never shown."""

    __slots__ = ("_key",)

    def __init__(self, key: bytes) -> None:
        self._key = key

    def new_key(self, container: str) -> Key:
        """Make a key for a container."""
        key = fresh_key()
        nonce = random(NONCE_BYTES)
        wrapped = FORM + nonce + encrypt(key, b"key" + binding(container), nonce, self._key)
        return Key(container, key, wrapped)

    def unwrap(self, container: str, wrapped: bytes) -> Key:
        """Take a container's key out of what was stored.

        Raises:
            Unreadable: Wrapped by another root key, for another container, or damaged.
        """
        key = opened(wrapped, b"key" + binding(container), self._key)
        return Key(container, key, wrapped)


def fresh_key() -> bytes:
    """Return a key that nobody has."""
    return random(KEY_BYTES)


def binding(container: str) -> bytes:
    """Return the container as associated data; its length goes in, so that nothing can shift."""
    name = container.encode()
    return len(name).to_bytes(4, "big") + name


def opened(sealed: bytes, associated: bytes, key: bytes) -> bytes:
    """Open what was sealed.

    Raises:
        Unreadable: The key, the associated data or the content is not what it was.
    """
    if sealed[:1] != FORM:
        raise Unreadable("sealed in a way this version does not know")
    try:
        return decrypt(sealed[25:], associated, sealed[1:25], key)
    except (CryptoError, ValueError) as error:
        raise Unreadable("not sealed with this key, for this place") from error
