"""Pictures that a phone can read: the same squares in the chat and in the terminal."""

from __future__ import annotations

import struct
import zlib

import pytest
import segno

from rosic.authoriser.invite_codes import QUIET, SCALE, qr_png, qr_text

LINK = "https://t.me/lab_robots_bot?start=7K3M-Q0ZD"
URI = "otpauth://totp/lab:Ada?secret=" + "A" * 32 + "&issuer=lab&algorithm=SHA1&digits=6&period=30"


def squares_of_png(picture: bytes) -> list[list[int]]:
    """Read a one-bit PNG back: 1 is dark, one entry a module."""
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    width, height, depth, colour = struct.unpack(">IIBB", picture[16:26])
    assert (depth, colour) in {(1, 0), (1, 3)}
    data, at = b"", 8
    while at < len(picture):
        (length,) = struct.unpack(">I", picture[at : at + 4])
        if picture[at + 4 : at + 8] == b"IDAT":
            data += picture[at + 8 : at + 8 + length]
        at += 12 + length
    lines, size = zlib.decompress(data), -(-width // 8)
    rows, above = [], bytes(size)
    for y in range(height):
        how, line = lines[y * (size + 1)], lines[y * (size + 1) + 1 : (y + 1) * (size + 1)]
        assert how in {0, 2}  # as it is, or as the difference to the line above
        above = bytes((a + b) % 256 for a, b in zip(line, above, strict=True)) if how else line
        rows.append(above)
    return [
        [1 - (rows[y][x // 8] >> (7 - x % 8) & 1) for x in range(SCALE // 2, width, SCALE)]
        for y in range(SCALE // 2, height, SCALE)
    ]


def squares_of_text(text: str) -> list[list[int]]:
    halves = {"█": (0, 0), "▀": (0, 1), "▄": (1, 0), " ": (1, 1)}
    rows = []
    for line in text.splitlines():
        rows.append([halves[character][0] for character in line])
        rows.append([halves[character][1] for character in line])
    return rows


@pytest.mark.parametrize("text", [LINK, URI, "join 7K3M-Q0ZD"])
def test_both_pictures_show_the_code_with_its_border(text: str) -> None:
    code = segno.make(text, micro=False, error="m")
    wanted = [[int(dark) for dark in row] for row in code.matrix_iter(border=QUIET)]
    assert squares_of_png(qr_png(text)) == wanted
    shown = squares_of_text(qr_text(text))
    assert shown[: len(wanted)] == wanted
    assert shown[len(wanted) :] in ([], [[0] * len(wanted[0])])
    assert not any(wanted[0])


def test_a_terminal_of_eighty_columns_shows_it() -> None:
    for text in (LINK, URI):
        lines = qr_text(text).splitlines()
        assert len({len(line) for line in lines}) == 1
        assert len(lines[0]) < 80
    assert len(qr_text(LINK).splitlines()) < 24


def test_another_text_is_another_picture() -> None:
    assert qr_png(LINK) != qr_png(LINK[:-1] + "E")
