"""The published vectors of RFC 4226 and RFC 6238, and what an authenticator app reads."""

from __future__ import annotations

from base64 import b32decode
from urllib.parse import parse_qs, unquote, urlsplit

import pytest

from rosic.authoriser.two_factor import (
    SECRET_BYTES,
    hotp,
    key_to_type,
    matching_steps,
    new_secret,
    otpauth_uri,
    step_at,
)
from rosic.testing.clock import SeededEntropy

RFC_SECRET = b"12345678901234567890"
# RFC 4226, appendix D
COUNTED = (
    "755224",
    "287082",
    "359152",
    "969429",
    "338314",
    "254676",
    "287922",
    "162583",
    "399871",
    "520489",
)
# RFC 6238, appendix B, SHA-1
TIMED = (
    (59, "94287082"),
    (1_111_111_109, "07081804"),
    (1_111_111_111, "14050471"),
    (1_234_567_890, "89005924"),
    (2_000_000_000, "69279037"),
    (20_000_000_000, "65353130"),
)


@pytest.mark.parametrize(("counter", "code"), list(enumerate(COUNTED)))
def test_rfc_4226(counter: int, code: str) -> None:
    assert hotp(RFC_SECRET, counter) == code


@pytest.mark.parametrize(("unix_s", "code"), TIMED)
def test_rfc_6238(unix_s: int, code: str) -> None:
    assert hotp(RFC_SECRET, step_at(unix_s * 10**9), digits=8) == code


@pytest.mark.parametrize(("shift", "found"), [(-2, ()), (-1, (99,)), (0, (100,)), (2, ())])
def test_one_step_to_either_side(shift: int, found: tuple[int, ...]) -> None:
    assert matching_steps(RFC_SECRET, hotp(RFC_SECRET, 100 + shift), 100) == found
    assert matching_steps(RFC_SECRET, hotp(RFC_SECRET, 101), 100) == (101,)


def test_the_beginning_of_time() -> None:
    assert matching_steps(RFC_SECRET, COUNTED[0], 0) == (0,)


def test_an_app_reads_what_was_meant() -> None:
    secret = new_secret(SeededEntropy())
    assert len(secret) == SECRET_BYTES == 20
    uri = otpauth_uri(secret, place="Lab: 3 & 4", account="Zoë Ada/1")
    parts = urlsplit(uri.reveal())
    asked = {name: values[0] for name, values in parse_qs(parts.query).items()}

    assert (parts.scheme, parts.netloc) == ("otpauth", "totp")
    assert unquote(parts.path) == "/Lab  3 & 4:Zoë Ada/1"
    assert asked.pop("issuer") == "Lab  3 & 4"
    assert asked == {"algorithm": "SHA1", "digits": "6", "period": "30", "secret": asked["secret"]}
    assert b32decode(asked["secret"]) == secret
    assert b32decode(key_to_type(secret).reveal().replace(" ", "")) == secret
    assert asked["secret"] not in f"{uri!r} {uri}"
