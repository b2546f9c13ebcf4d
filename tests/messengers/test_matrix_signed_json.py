from __future__ import annotations

import json
from base64 import b64decode
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nacl.signing import SigningKey

from rosic.messengers.matrix.signed_json import (
    DEEPEST,
    LARGEST,
    NotCanonical,
    canonical_json,
    from_base64,
    is_signed,
    public_part,
    sign,
    signed_part,
    to_base64,
)

SEED = b64decode("YJDBA9Xnr2sVqXD9Vj7XVUnmFZcZrlw8Md7kMW+3XA1=")
"""Of the specification's appendix "Cryptographic Test Vectors"."""
USER = "@ada:example.org"


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ({}, "{}"),
        ({"one": 1, "two": "Two"}, '{"one":1,"two":"Two"}'),
        ({"b": "2", "a": "1"}, '{"a":"1","b":"2"}'),
        ({"本": 2, "日": 1}, '{"日":1,"本":2}'),
        ({"a": "日本語"}, '{"a":"日本語"}'),
        ({"a": "\u65e5"}, '{"a":"日"}'),
        ({"a": None}, '{"a":null}'),
        ({"a": -0}, '{"a":0}'),
        ({"a": [True, False, [], {}]}, '{"a":[true,false,[],{}]}'),
        ({"a": '\x00\x1f"\\\b\f\n\r\t/\x7f'}, '{"a":"\\u0000\\u001f\\"\\\\\\b\\f\\n\\r\\t/\x7f"}'),
        ({"\uffff": 1, "\U0001f600": 2}, '{"\uffff":1,"\U0001f600":2}'),
        ({"a": LARGEST, "b": -LARGEST}, f'{{"a":{LARGEST},"b":{-LARGEST}}}'),
    ],
)
def test_a_value_is_written_in_one_way(value: object, written: str) -> None:
    assert canonical_json(value).decode() == written


@pytest.mark.parametrize(
    "value",
    [
        {"a": 1.0},
        {"a": float("nan")},
        {"a": 2**53},
        {"a": -(2**53)},
        {1: "a"},
        {"a": "\ud800"},
        {"\ud800": 1},
        {"a": b"bytes"},
        {"a": (1, 2)},
        {"a": "x" * 70_000},
        {"a": [0] * 70_000},
    ],
)
def test_what_has_no_canonical_form_is_refused(value: object) -> None:
    with pytest.raises(NotCanonical):
        canonical_json(value)


@pytest.mark.parametrize("deep", [DEEPEST + 1, 100_000])
def test_what_is_nested_without_end_is_refused(deep: int) -> None:
    value: object = 1
    for _ in range(deep):
        value = [value]

    with pytest.raises(NotCanonical):
        canonical_json(value)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-LARGEST, LARGEST) | st.text(max_size=20),
    lambda part: (
        st.lists(part, max_size=4) | st.dictionaries(st.text(max_size=8), part, max_size=4)
    ),
    max_leaves=20,
)


@given(JSON)
def test_it_means_what_it_meant_and_has_one_form(value: object) -> None:
    try:
        written = canonical_json(value)
    except NotCanonical:
        return
    assert json.loads(written) == value
    assert canonical_json(json.loads(written)) == written


@pytest.mark.parametrize(
    ("value", "signature"),
    [
        (
            {},
            "K8280/U9SSy9IVtjBuVeLr+HpOB4BQFWbg+UZaADMtTdGYI7Geitb76LTrr5QV/7Xg4ahLwYGYZzuHGZKM5ZAQ",
        ),
        (
            {"one": 1, "two": "Two"},
            "KqmLSbO39/Bzb0QIYE82zqLwsA+PDzYIpIRA2sRQ4sL53+sN6/fpNSoqE7BP7vBZhG6kYdD13EIMJpvhJI+6Bw",
        ),
    ],
)
def test_signatures_are_those_of_the_specification(value: dict[str, Any], signature: str) -> None:
    key = SigningKey(SEED)
    assert to_base64(key.sign(signed_part(value)).signature) == signature

    shown = {**value, "signatures": {"domain": {"ed25519:1": signature}}, "unsigned": {"age": 1}}
    assert is_signed(shown, "domain", "1", public_part(key))


def test_a_signature_holds_for_these_words_by_this_key_under_this_name_alone() -> None:
    key, other = SigningKey.generate(), SigningKey.generate()
    name, signed = public_part(key), sign({"a": 1}, USER, key)
    assert is_signed(signed, USER, name, name)

    assert not is_signed({**signed, "a": 2}, USER, name, name)
    assert not is_signed({**signed, "b": 1}, USER, name, name)
    assert not is_signed(signed, USER, name, public_part(other))
    assert not is_signed(signed, "@eve:example.org", name, name)
    assert not is_signed(signed, USER, public_part(other), name)


def test_signing_keeps_signatures_that_were_there_and_changes_nothing_else() -> None:
    one, two = SigningKey.generate(), SigningKey.generate()
    before = sign({"a": 1}, USER, one)
    both = sign(before, USER, two)

    assert len(before["signatures"][USER]) == 1
    assert is_signed(both, USER, public_part(one), public_part(one))
    assert is_signed(both, USER, public_part(two), public_part(two))


@pytest.mark.parametrize(
    "signatures",
    [
        None,
        [],
        "x",
        {},
        {USER: None},
        {USER: []},
        {USER: {"ed25519:K": None}},
        {USER: {"ed25519:K": 7}},
        {USER: {"ed25519:K": ""}},
        {USER: {"ed25519:K": "A" * 86 + "=="}},
        {USER: {"ed25519:K": "A" * 85}},
        {USER: {"ed25519:K": "\u00e9" * 86}},
    ],
)
def test_what_is_no_signature_is_none(signatures: object) -> None:
    key = public_part(SigningKey.generate())
    assert not is_signed({"signatures": signatures}, USER, "K", key)


def test_a_key_that_is_no_key_has_signed_nothing() -> None:
    signed = sign({"a": 1}, USER, SigningKey.generate())
    for public in ("", "A", "A" * 43 + "=", "A" * 43, "-" * 43):
        assert not is_signed(signed, USER, public, public)


def test_bytes_have_one_spelling() -> None:
    text = to_base64(b"\xff" * 32)
    assert from_base64(text, 32) == b"\xff" * 32

    others = (text + "=", text[:-1] + "9", " " + text, text.replace("/", "_"), text + "\n")
    assert [from_base64(other, 32) for other in others] == [None] * len(others)
    assert from_base64(text, 31) is None
    assert from_base64(7, 32) is None
