from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.config.source_map import SIZE_LIMIT_BYTES
from rosic.config.yaml_source import read_yaml
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.config.source_map import SourceMap

BOMB = "a: &a [x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


def read(folder: Path, content: str | bytes) -> SourceMap:
    path = folder / "omni.yaml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_yaml(path)


def test_a_line_is_known_for_every_key_and_item(tmp_path: Path) -> None:
    source = read(tmp_path, "id: omni\nskills:\n  move:\n    words:\n      - go\n      - [a, b]\n")
    assert source.data == {"id": "omni", "skills": {"move": {"words": ["go", ["a", "b"]]}}}
    assert source.lines == {
        ("id",): 1,
        ("skills",): 2,
        ("skills", "move"): 3,
        ("skills", "move", "words"): 4,
        ("skills", "move", "words", 0): 5,
        ("skills", "move", "words", 1): 6,
        ("skills", "move", "words", 1, 0): 6,
        ("skills", "move", "words", 1, 1): 6,
    }


def test_what_has_no_line_is_placed_where_it_would_stand(tmp_path: Path) -> None:
    source = read(tmp_path, "id: omni\nskills:\n  move: {}\n")
    assert source.where(("skills", "move", "title")).endswith("omni.yaml:3")
    assert source.where(("link", "kind")).endswith("omni.yaml")


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("7", 7),
        ("-0.5", -0.5),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("010", 10),
        ("true", True),
        ("False", False),
        ("~", None),
        ("", None),
        # What YAML 1.1 turns into something else stays what was written.
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("12:30", "12:30"),
        ("2026-11-21", "2026-11-21"),
        ("0x1F", "0x1F"),
        ("1_000", "1_000"),
        ('"7"', "7"),
        ("'true'", "true"),
        ("$force", "$force"),
        ('"%"', "%"),
    ],
)
def test_a_value_is_what_it_looks_like(written: str, meant: object, tmp_path: Path) -> None:
    value = read(tmp_path, f"key: {written}\n").data["key"]
    assert value == meant
    assert type(value) is type(meant)


@pytest.mark.parametrize(
    ("content", "line", "sentence"),
    [
        ("", None, "The file is empty."),
        ("# only a remark\n", None, "The file is empty."),
        ("a: 1\nb: [1, 2\nc: 3\n", 3, "This is not YAML: expected ',' or ']'"),
        ("a: 1\n\tb: 2\n", 2, "This is not YAML: found character '\\t' that cannot start any"),
        ("a: 1\nunit: %\n", 2, "This is not YAML: found character '%' that cannot start any"),
        ("a: b: c\n", 1, "This is not YAML: mapping values are not allowed here."),
        ("a: 1\nb: 2\na: 3\n", 3, "'a' stands here twice. The first is on line 1."),
        ("x: {a: 1, a: 1}\n", 1, "'a' stands here twice."),
        ("a: 1\nb: .nan\n", 2, ".nan is not a finite number."),
        ("a: .inf\n", 1, ".inf is not a finite number."),
        ("a: -.INF\n", 1, "-.INF is not a finite number."),
        ("a: 1e999\n", 1, "1e999 is not a finite number."),
        (f"a: {'9' * 400}\n", 1, "This number is too long."),
        ("a: &x [1]\nb: 2\n", 1, "Anchors and aliases (& and *) are not used here."),
        ("a: 1\n<<: *x\n", 2, "Anchors and aliases (& and *) are not used here."),
        (BOMB, 1, "Anchors and aliases (& and *) are not used here."),
        ("a: 1\nb: !!python/object/apply:os.system [ls]\n", 2, "Tags (!) are not used here."),
        ("a: !!int 7\n", 1, "Tags (!) are not used here."),
        ("a: 1\n? [x]\n: 2\n", 2, "A key must be a word, not a list or a table."),
        ("a: 1\n---\nb: 2\n", 2, "A second document begins here. Keep one robot a file."),
        ("a: " + "[" * 10_000, 1, "The file is too large or too deeply nested for a profile."),
        ("a: [" + "1," * 30_000 + "]", 1, "The file is too large or too deeply nested"),
        ('a: "\\ud800"\n', 1, "This text holds half a character."),
        (b"a: 1\nb: \xff\n", 2, "The file is not UTF-8 text. Save it as UTF-8."),
        (b"a: 1\nb: \x07\n", 2, "The file holds a character that YAML does not allow."),
        (b"a" * (SIZE_LIMIT_BYTES + 1), None, "The file is larger than 1 MiB."),
    ],
)
def test_what_is_no_profile_is_said(
    content: str | bytes, line: int | None, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigurationError) as raised:
        read(tmp_path, content)
    where = f"{tmp_path / 'omni.yaml'}" + (f":{line}" if line else "")
    assert raised.value.where == where
    assert str(raised.value).startswith(f"{where}: {sentence}")
    assert "\n" not in str(raised.value)


def test_a_file_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="There is no such file"):
        read_yaml(tmp_path / "none.yaml")
    with pytest.raises(ConfigurationError, match="This is a folder, not a file"):
        read_yaml(tmp_path)
    with pytest.raises(ConfigurationError, match="The file cannot be read"):
        read_yaml(tmp_path / "null\0.yaml")


def test_a_mark_at_the_beginning_is_no_text(tmp_path: Path) -> None:
    assert read(tmp_path, b"\xef\xbb\xbfid: omni\n").data == {"id": "omni"}


PIECES = st.sampled_from(
    [
        *("a", "b: ", "- ", "\n", "  ", "{", "}", "[", "]", ", ", ": ", "&x ", "*x", "!t ", "'"),
        *('"', "#", "|", ">", "? ", "---\n", "...\n", "%", "\\", "1e9", ".nan", "\t", "é"),
        *("\x00", "\ufeff"),
    ]
)


@given(st.one_of(st.lists(PIECES, max_size=30).map("".join), st.text(max_size=60)))
def test_any_text_is_data_or_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        source = read_yaml(path)
    except ConfigurationError as error:
        where = [error.where]
    else:
        where = [source.where(place) for place in source.lines]
    assert all(one.startswith(str(path)) for one in where)
