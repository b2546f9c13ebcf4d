"""Six digits from a shared secret and the time: HOTP (RFC 4226) and TOTP (RFC 6238)."""

from __future__ import annotations

import hmac
from base64 import b32encode
from typing import TYPE_CHECKING, Final
from urllib.parse import quote, urlencode

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.identity import PrincipalId
from rosic.core.message import Chat
from rosic.core.records import Record
from rosic.core.secret import Secret
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from rosic.contracts.clock import Entropy


# ---- HOTP (RFC 4226) and TOTP (RFC 6238) ----

STEP_S: Final = 30
STEP_NS: Final = STEP_S * SECOND_NS
DIGITS: Final = 6
SKEW_STEPS: Final = 1  # phones are rarely more than half a minute off
SECRET_BYTES: Final = 20  # RFC 4226 asks for the length of the hash


def new_secret(entropy: Entropy) -> bytes:
    """Return a secret for one person."""
    return entropy.token(SECRET_BYTES)


def hotp(secret: bytes, counter: int, *, digits: int = DIGITS) -> str:
    """Return the code of a counter (RFC 4226, SHA-1, which is what authenticator apps know)."""
    mac = hmac.digest(secret, counter.to_bytes(8, "big"), "sha1")
    start = mac[-1] & 0x0F
    number = int.from_bytes(mac[start : start + 4], "big") & 0x7FFF_FFFF
    return str(number % 10**digits).zfill(digits)


def step_at(wall_ns: int) -> int:
    """Return the number of the half minute in which a wall time lies."""
    return wall_ns // STEP_NS


def matching_steps(secret: bytes, code: str, step: int) -> tuple[int, ...]:
    """Return which steps around the present one have this code, oldest first.

    Every candidate is computed and compared in constant time, whatever the code.
    """
    given = code.encode()
    around = range(max(0, step - SKEW_STEPS), step + SKEW_STEPS + 1)
    found = [(n, hmac.compare_digest(hotp(secret, n).encode(), given)) for n in around]
    return tuple(n for n, same in found if same)


def otpauth_uri(secret: bytes, *, place: str, account: str) -> Secret:
    """Return what an authenticator app reads from a QR code.

    Args:
        secret: Never shown otherwise.
        place: Name of this lab, as the app shows it.
        account: Name of the person, as the app shows it.
    """
    # A colon would move the border between the two names.
    issuer, person = (quote(text.replace(":", " "), safe="") for text in (place, account))
    asked = {
        "secret": b32encode(secret).decode().rstrip("="),
        "issuer": place.replace(":", " "),
        "algorithm": "SHA1",
        "digits": str(DIGITS),
        "period": str(STEP_S),
    }
    return Secret(f"otpauth://totp/{issuer}:{person}?{urlencode(asked, quote_via=quote)}")


def key_to_type(secret: bytes) -> Secret:
    """Return the secret in groups of four letters, for a phone that cannot see the picture."""
    letters = b32encode(secret).decode().rstrip("=")
    return Secret(" ".join(letters[at : at + 4] for at in range(0, len(letters), 4)))


# ---- a person's phone ----


class TotpDevice(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the principal, its letter the secret.

    Attributes:
        last_step: The newest half minute whose code was used.
        since_ns: When it was set up; wall clock.
    """

    last_step: int
    since_ns: int


class TotpSetup(msgspec.Struct, frozen=True):
    """What a phone needs, once, until the first code has come back.

    Attributes:
        uri: For a QR picture.
        key: The same to be typed.
    """

    uri: Secret
    key: Secret

    @property
    def sentence(self) -> str:
        """Return what stands under the picture; it holds the secret."""
        return words.scan(self.key.reveal())


class TotpProof(msgspec.Struct, frozen=True):
    """A right code. It counts as soon as the records are written and applied, by `admit`.

    Attributes:
        sentence: For the person, once it counts.
    """

    principal: PrincipalId
    chat: Chat
    step: int
    records: tuple[Record, ...]
    sentence: str
