"""What a file is, and what it may be called: generated names, and contents that lie."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.container.file_types import LONGEST_NAME, SORTS, Sniffer, file_name, numbered

CONTENTS = {
    "png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
    "jpeg": b"\xff\xd8\xff\xe0\0\x10JFIF",
    "pdf": b"%PDF-1.7\n%\xe2\xe3",
    "pgm": b"P5\n# map of the hall\n384 384\n255\n\0\1\2",
    "zip": b"PK\x03\x04\x14\0",
    "gzip": b"\x1f\x8b\x08\0\0\0",
    "mcap": b"\x89MCAP0\r\n\x01",
    "db3": b"SQLite format 3\0\x10",
}
BAD = (
    "../../etc/passwd",
    "..\\..\\boot.ini",
    "/etc/shadow",
    "C:\\x\\y.txt",
    "a\0b.txt",
    "",
    ".",
    "..",
    "...",
    ".bashrc",
    "-rf",
    "x" * 300,
    "é" * 300 + ".txt",
    "\u202egnp.exe",
    "a\nb.txt",
    "a\rb",
    "CON",
    "con.txt",
    "nul.tar.gz",
    "a\u200bb.txt",
    "\ud800.txt",
    "$(reboot).txt",
    "`id`.txt",
    "a;b|c.txt",
    "~/x",
    "%2e%2e%2fx",
    "\uff58\uff0f\uff59.txt",
    "a" + "\u0301" * 400,
    "  spaced  out .txt ",
    "file.txt.",
)


def sort_of(content: bytes, name: str, step: int = 7) -> str:
    sniffer = Sniffer()
    for start in range(0, len(content), step):
        sniffer.feed(content[start : start + step])
    found = sniffer.sort(name)
    return "" if found is None else found.name


@pytest.mark.parametrize("kind", CONTENTS)
@pytest.mark.parametrize("name", ["", "x.txt", "x.exe", "x.png"])
def test_the_content_decides_not_the_name(kind: str, name: str) -> None:
    assert sort_of(CONTENTS[kind], name) == kind


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.yaml", "yaml"),
        ("a.YML", "yaml"),
        ("a.json", "json"),
        ("a.csv", "csv"),
        ("a.txt", "text"),
        ("page.html", "text"),
        ("run.sh", "text"),
        ("", "text"),
        ("a." + "y" * 40, "text"),
    ],
)
def test_a_text_is_what_its_ending_says_if_that_is_harmless(name: str, kind: str) -> None:
    assert sort_of("hall: 2 µm\n".encode(), name) == kind


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x7fELF\x02\x01",
        b"MZ\x90\0",
        b"a\0b",
        b"text\xff\xfe",
        b"\xe2\x82",
        b"ok" * 400 + b"\x1b[2J",
        b"x" * 2_000 + b"\0",
        b"\x89PN",
        b"\xfe\xff\0a",
    ],
)
def test_what_is_nothing_known_is_not_taken(content: bytes) -> None:
    assert sort_of(content, "notes.txt") == ""


def check(name: str, ending: str) -> None:
    assert name == unicodedata.normalize("NFKC", name)
    assert name.endswith(f".{ending}")
    assert 0 < len(name.encode()) <= LONGEST_NAME
    assert not set(name) & set('/\\\0\n\r<>:"|?*$`&;%')
    assert not name.startswith((".", "-", " "))
    assert all(unicodedata.category(c) not in {"Cc", "Cf", "Cs", "Zl", "Zp"} for c in name)
    assert name.partition(".")[0].casefold() not in {"con", "nul", "prn", "aux", ""}


@pytest.mark.parametrize("said", BAD)
@pytest.mark.parametrize("kind", ["png", "text", "zip"])
def test_no_bad_name_survives(said: str, kind: str) -> None:
    name = file_name(said, SORTS[kind])
    check(name, name.rpartition(".")[2])
    assert name.rpartition(".")[2] in SORTS[kind].endings


@given(st.text(alphabet=st.characters(), max_size=300))
def test_any_name_becomes_a_plain_one(said: str) -> None:
    name = file_name(said, SORTS["zip"])
    check(name, "zip")
    assert file_name(name, SORTS["zip"]) == name
    check(numbered(name, 12), "zip")


def test_a_good_name_stays() -> None:
    assert file_name("map of hall 2.PNG", SORTS["png"]) == "map of hall 2.PNG"
    assert file_name("Grüße an Ada.yaml", SORTS["yaml"]) == "Grüße an Ada.yaml"
    assert file_name("run.exe", SORTS["png"]) == "run.exe.png"
    assert numbered("map.png", 2) == "map (2).png"
