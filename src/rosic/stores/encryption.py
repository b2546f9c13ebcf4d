"""Personal content under lock: one key for each container, all of them wrapped by a root key.

Erasing a container is erasing its key. A sealed letter is bound to its container, its kind and
what it belongs to, so that nobody can put one in another's place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nacl import _sodium
from nacl.bindings import (
    crypto_aead_xchacha20poly1305_ietf_decrypt as decrypt,
)
from nacl.exceptions import CryptoError
from nacl.utils import random

if TYPE_CHECKING:
    from collections.abc import Iterator

KEY_BYTES = 32
NONCE_BYTES = 24
TAG_BYTES = 16
FORM = b"\x01"  # first byte of everything sealed: which way it was sealed

NONCES = 64  # drawn at once
ROOM_BYTES = 4096  # what is longer than nearly every letter

# PyNaCl's own function formats six messages for errors that do not happen, which takes three times
# as long as the sealing. What is sealed here is opened by PyNaCl's own function, below.
sodium: Any = _sodium.lib
ffi: Any = _sodium.ffi
encrypt = sodium.crypto_aead_xchacha20poly1305_ietf_encrypt


class DecryptionError(Exception):
    """Sealed under another key, belonging elsewhere, or damaged."""


class Sealer:
    """Seals with any key. For one thread at a time: its room and its nonces are used again."""

    __slots__ = ("_nonces", "_room", "_view")

    def __init__(self) -> None:
        self._nonces = nonces()
        self._room = ffi.new("unsigned char[]", ROOM_BYTES + TAG_BYTES)
        self._view = ffi.buffer(self._room)

    def seal(self, content: bytes, associated: bytes, key: bytes) -> bytes:
        """Seal something, bound to what is associated with it.

        Raises:
            ValueError: The key has not the length of a key.
        """
        if len(key) != KEY_BYTES:
            raise ValueError("not a key")
        nonce, size, room, view = next(self._nonces), len(content), self._room, self._view
        if size > ROOM_BYTES:
            room = ffi.new("unsigned char[]", size + TAG_BYTES)
            view = ffi.buffer(room)
        null = ffi.NULL
        encrypt(room, null, content, size, associated, len(associated), null, nonce, key)
        sealed: bytes = view[: size + TAG_BYTES]
        return FORM + nonce + sealed


def nonces() -> Iterator[bytes]:
    """Yield nonces, each once. Drawn many at a time, for each draw is a call to the system."""
    while True:
        pool = random(NONCES * NONCE_BYTES)
        for start in range(0, len(pool), NONCE_BYTES):
            yield pool[start : start + NONCE_BYTES]


class ContainerKey:
    """One container's key; never shown.

    Attributes:
        container: A principal's or a robot's id.
        wrapped: The key as it may be stored.
    """

    __slots__ = ("_binding", "_key", "_sealer", "container", "wrapped")

    def __init__(self, container: str, key: bytes, wrapped: bytes, sealer: Sealer) -> None:
        self.container = container
        self.wrapped = wrapped
        self._key = key
        self._sealer = sealer
        self._binding = binding(container)

    def seal(self, kind: bytes, subject: bytes, content: bytes) -> bytes:
        """Seal one letter.

        Args:
            kind: One byte.
            subject: What the letter belongs to.
            content: What it says.
        """
        return self._sealer.seal(content, self._binding + kind + subject, self._key)

    def unseal(self, kind: bytes, subject: bytes, sealed: bytes) -> bytes:
        """Open one letter.

        Raises:
            DecryptionError: It does not belong here, or it was changed.
        """
        return opened(sealed, self._binding + kind + subject, self._key)


class RootKey:
    """The root key; never shown. For one thread at a time, and so are the keys it gives."""

    __slots__ = ("_key", "_sealer")

    def __init__(self, key: bytes) -> None:
        self._key = key
        self._sealer = Sealer()

    def new_key(self, container: str) -> ContainerKey:
        """Make a key for a container."""
        key = fresh_key()
        wrapped = self._sealer.seal(key, b"key" + binding(container), self._key)
        return ContainerKey(container, key, wrapped, self._sealer)

    def unwrap(self, container: str, wrapped: bytes) -> ContainerKey:
        """Take a container's key out of what was stored.

        Raises:
            DecryptionError: Wrapped by another root key, for another container, or damaged.
        """
        key = opened(wrapped, b"key" + binding(container), self._key)
        return ContainerKey(container, key, wrapped, self._sealer)


def fresh_key() -> bytes:
    """Return a key that nobody has."""
    return random(KEY_BYTES)


def binding(text: str) -> bytes:
    """Return a name as associated data; its length goes in, so that nothing can shift."""
    name = text.encode()
    return len(name).to_bytes(4, "big") + name


def place_of_fact(kind: str, key: str) -> bytes:
    """Return what the letter of a fact belongs to."""
    return binding(kind) + key.encode()


def opened(sealed: bytes, associated: bytes, key: bytes) -> bytes:
    """Open what was sealed.

    Raises:
        DecryptionError: The key, the associated data or the content is not what it was.
    """
    if sealed[:1] != FORM:
        raise DecryptionError("sealed in a way this version does not know")
    try:
        return decrypt(sealed[25:], associated, sealed[1:25], key)
    except (CryptoError, ValueError) as error:
        raise DecryptionError("not sealed with this key, for this place") from error
