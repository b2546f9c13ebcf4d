from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosic.config.toml_source import read_toml
from rosic.errors import ConfigurationError
from tests.config.test_config_errors import TOKEN

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rosic.config.source_map import SourceMap
    from rosic.contracts.file_rules import Place

WRITTEN = '''\
title = "a # b"   # 1
[gateway]
"odd key" = 1
a.b.'c d' = 2
lines = """
one " two
three"""
next = [ # 8
  1, # 9
  { x = "}", y = [1,
     2] }, # 10 and 11
]

[[robot]]
profile = "omni"
[robot.more]
deep = '\\'

[[robot]]
profile = """x"""""
[[robot.arm]]
n = 1
[[robot.arm]]
n = 2
[role."two words"]
scopes = []
'''

LINES: dict[Place, int] = {
    ("title",): 1,
    ("gateway",): 2,
    ("gateway", "odd key"): 3,
    ("gateway", "a"): 4,
    ("gateway", "a", "b", "c d"): 4,
    ("gateway", "lines"): 5,
    ("gateway", "next"): 8,
    ("gateway", "next", 0): 9,
    ("gateway", "next", 1): 10,
    ("gateway", "next", 1, "x"): 10,
    ("gateway", "next", 1, "y", 1): 11,
    ("robot",): 14,
    ("robot", 0): 14,
    ("robot", 0, "profile"): 15,
    ("robot", 0, "more", "deep"): 17,
    ("robot", 1): 19,
    ("robot", 1, "profile"): 20,
    ("robot", 1, "arm", 0, "n"): 22,
    ("robot", 1, "arm", 1): 23,
    ("robot", 1, "arm", 1, "n"): 24,
    ("role", "two words", "scopes"): 26,
}


def read(folder: Path, text: str | bytes) -> SourceMap:
    path = folder / "rosic.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_toml(path)


def places(data: Any, place: Place = ()) -> Iterator[Place]:  # noqa: ANN401 - whatever TOML holds
    if place:
        yield place
    entries: Iterable[tuple[Any, Any]] = ()
    if isinstance(data, dict):
        entries = data.items()
    elif isinstance(data, list):
        entries = enumerate(data)
    for key, value in entries:
        yield from places(value, (*place, key))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_line_is_known_for_every_key_and_item(end: str, tmp_path: Path) -> None:
    source = read(tmp_path, WRITTEN.replace("\n", end))
    assert source.data == tomllib.loads(WRITTEN)
    assert {place: source.lines.get(place) for place in LINES} == LINES
    assert set(places(source.data)) <= set(source.lines)


PIECES = st.sampled_from(
    [
        *("[a]\n", "[[b]]\n", "[b.c]\n", "[a.d]\n", "x = ", "y.z = ", "'k' = ", '"k\\"2" = '),
        *("1", "2.5", "true", '"s"', "'s'", '"""m\n"x"""', "'''m\n''x'''", '"\\""', "''", '""'),
        *("[", "]", "{", "}", ", ", "\n", " ", "# r\n", "1979-05-27", "\\", '"', "'", "=", "."),
        *("é", "\x00", "\r\n"),
    ]
)
STATEMENTS = st.lists(
    st.sampled_from(
        [
            "x{} = 1\n",
            "x{} = [1, [2, '3'], {{a = 1}}]\n",
            "x{}.y = {{a.b = '}}', c = []}}\n",
            "[t{}]\n",
            "[[u]] # {}\n",
            "[u.v{}]\n",
            "[[u.w]] # {}\n",
            "'x{}' = '''\n'\n''''\n",
            "# {}\n",
            '"x{} " = """\\\n  a" ""b"""""\n',
            "x{} = [ # c\n  1, # d\n\n  2 ]\n",
            "x{} = 07:32:00\n",
        ]
    ),
    max_size=12,
).map(lambda lines: "".join(line.format(number) for number, line in enumerate(lines)))


@given(st.one_of(STATEMENTS, st.lists(PIECES, max_size=25).map("".join), st.text(max_size=60)))
@example("x = " + "[" * 100_000)
def test_any_text_is_data_with_lines_or_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        source = read_toml(path)
    except ConfigurationError as error:
        refused = error
    else:
        check_lines(source, text)
        return
    assert refused.where.startswith(str(path))
    assert "\n" not in str(refused)


def check_lines(source: SourceMap, text: str) -> None:
    assert set(places(source.data)) <= set(source.lines)
    count = text.count("\n") + 1
    assert all(1 <= line <= count for line in source.lines.values())


@pytest.mark.parametrize(
    ("content", "line", "sentence"),
    [
        ("a = 1\nb 2\n", 2, "This is not TOML, column 3: expected '=' after a key"),
        ("a = 1\nb = nope\n", 2, "This is not TOML, column 5: invalid value."),
        ("a = 1\na = 2\n", 2, "This is not TOML, column 6: cannot overwrite a value."),
        ("a = 1\n\nb = [1,\n", 4, "This is not TOML, at the end: "),
        ("x = " + "[" * 100_000, None, "The file is too deeply nested."),
        (b"a = 1\nb = '\xff'\n", 2, "The file is not UTF-8 text. Save it as UTF-8."),
    ],
)
def test_broken_toml_is_said(
    content: str | bytes, line: int | None, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigurationError) as raised:
        read(tmp_path, content)
    where = f"{tmp_path / 'rosic.toml'}" + (f":{line}" if line else "")
    assert raised.value.where == where
    assert str(raised.value).startswith(f"{where}: {sentence}")


def test_a_broken_line_does_not_give_its_secret_away(tmp_path: Path) -> None:
    for text in (f"token = {TOKEN}\n", f'token = "{TOKEN}\n', f'token = "{TOKEN}" x\n'):
        with pytest.raises(ConfigurationError) as raised:
            read(tmp_path, text)
        assert TOKEN not in str(raised.value)
        assert raised.value.__suppress_context__
