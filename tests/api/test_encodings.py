"""The forms of rosbridge's messages, read by libraries that others have written."""

from __future__ import annotations

import io
import math
from array import array
from base64 import b64decode
from typing import Any

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as some
from PIL import Image

from rosic.api.rosbridge.encodings import cbor, png

TEXTS = some.text(some.characters(exclude_categories=["Cs"]))
SIMPLE = (
    some.none()
    | some.booleans()
    | some.integers(-(2**63), 2**64 - 1)
    | some.floats(allow_nan=False)
    | TEXTS
    | some.binary()
)
VALUES = some.recursive(
    SIMPLE, lambda some_of: some.lists(some_of) | some.dictionaries(TEXTS, some_of), max_leaves=40
)
FORMS = {64: "B", 69: "H", 70: "I", 71: "Q", 72: "b", 77: "h", 78: "i", 79: "q", 85: "f", 86: "d"}
"""Of the tags of RFC 8746 whose numbers are little-endian, as `array` calls them."""


@given(VALUES)
def test_what_is_written_in_cbor_is_read_as_it_was(value: object) -> None:
    assert cbor2.loads(cbor(value)) == value


def test_no_number_and_what_is_no_text_are_written_too() -> None:
    assert math.isnan(cbor2.loads(cbor(math.nan)))
    assert cbor2.loads(cbor("a\ud800b")) == "a?b"


@pytest.mark.parametrize(("tag", "form"), FORMS.items())
def test_lists_of_numbers_are_packed_as_the_standard_has_it(tag: int, form: str) -> None:
    values = array(form, [0, 1, 100])
    written: Any = cbor2.loads(cbor({"data": values}))["data"]
    assert written.tag == tag
    read = array(form)
    read.frombytes(written.value)  # this machine is little-endian, as every one that tests run on
    assert read == values


@given(some.binary(max_size=4_000))
def test_the_pixels_of_a_picture_are_the_text(content: bytes) -> None:
    with Image.open(io.BytesIO(b64decode(png(content)))) as picture:
        pixels = picture.convert("RGB").tobytes()
    assert pixels[: len(content)] == content
    assert set(pixels[len(content) :]) <= {ord("\n")}
