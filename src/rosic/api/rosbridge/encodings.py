"""The other two forms in which rosbridge sends messages: CBOR, and the pixels of a PNG."""

from __future__ import annotations

import struct
import sys
import zlib
from array import array
from base64 import b64encode
from math import ceil, isqrt
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

# ---- CBOR (RFC 8949), with packed lists of numbers (RFC 8746, little-endian) ----

_FLOATS: Final[Mapping[str, int]] = {"f": 85, "d": 86}
_UNSIGNED: Final = {1: 64, 2: 69, 4: 70, 8: 71}
_SIGNED: Final = {1: 72, 2: 77, 4: 78, 8: 79}
_LIMITS: Final = ((1 << 8, 24, ">BB"), (1 << 16, 25, ">BH"), (1 << 32, 26, ">BI"))


def cbor(value: Any) -> bytes:  # noqa: ANN401 - whatever a message holds
    """Return a value in CBOR.

    Args:
        value: Mappings, lists, packed arrays, text, bytes, numbers, yes or no, nothing.
    """
    parts: list[bytes] = []
    _put(value, parts)
    return b"".join(parts)


def _put(value: Any, parts: list[bytes]) -> None:  # noqa: ANN401 - likewise
    if isinstance(value, str):
        encoded = value.encode("utf-8", "replace")
        parts += (_head(3, len(encoded)), encoded)
    elif isinstance(value, dict):
        parts.append(_head(5, len(value)))
        for name, each in value.items():
            _put(name, parts)
            _put(each, parts)
    elif isinstance(value, array):
        parts += _packed(value)
    elif isinstance(value, list | tuple):
        parts.append(_head(4, len(value)))
        for each in value:
            _put(each, parts)
    elif isinstance(value, bytes):
        parts += (_head(2, len(value)), value)
    else:
        parts.append(_simple(value))


def _simple(value: Any) -> bytes:  # noqa: ANN401 - likewise
    if value is None:
        return b"\xf6"
    if isinstance(value, bool):
        return b"\xf5" if value else b"\xf4"
    if isinstance(value, int):
        return _head(0, value) if value >= 0 else _head(1, -1 - value)
    return b"\xfb" + struct.pack(">d", value)


def _packed(values: array[Any]) -> tuple[bytes, ...]:
    code, size = values.typecode, values.itemsize
    tag = _FLOATS.get(code) or (_UNSIGNED if code.isupper() else _SIGNED)[size]
    if sys.byteorder != "little":  # packed lists are little-endian here
        values = array(code, values)
        values.byteswap()
    content = values.tobytes()
    return (_head(6, tag), _head(2, len(content)), content)


def _head(major: int, number: int) -> bytes:
    first = major << 5
    if number < 24:  # noqa: PLR2004 - as RFC 8949 has it
        return bytes((first | number,))
    for limit, extra, form in _LIMITS:
        if number < limit:
            return struct.pack(form, first | extra, number)
    return struct.pack(">BQ", first | 27, number)


# ---- PNG ----

_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"


def png(content: bytes) -> str:
    """Return a text as the pixels of a picture, in base64; ends with line feeds until it is full.

    The picture is as nearly square as it can be, of 8 bits each of red, green and blue.
    """
    width = max(1, isqrt(len(content) // 3))
    height = max(1, ceil(len(content) / 3 / width))
    row = width * 3
    content = content.ljust(row * height, b"\n")
    lines = b"".join(b"\0" + content[at : at + row] for at in range(0, len(content), row))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    whole = _SIGNATURE + b"".join(
        _chunk(kind, body)
        for kind, body in ((b"IHDR", header), (b"IDAT", zlib.compress(lines, 1)), (b"IEND", b""))
    )
    return b64encode(whole).decode()


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
