"""Lexicons are files that translators edit: the how-to is followed, and mistakes are told."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rosic.app.features import command_table
from rosic.config.lexicons import SHIPPED, main, read_lexicon, read_lexicons
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import Do, LineContext, Misunderstood, Vocabulary, bind, understand
from rosic.errors import ConfigurationError

HOWTO = Path(__file__).parents[2] / "docs" / "howto" / "add-a-language.md"
BLOCKS = dict(re.findall(r"```(toml|sh|chat)\n(.*?)```", HOWTO.read_text("utf-8"), re.DOTALL))


@pytest.fixture
def locale(tmp_path: Path) -> Path:
    """A copy of what ships, for adding to."""
    shutil.copytree(SHIPPED, tmp_path / "locale")
    return tmp_path / "locale"


def vocabulary_of(folder: Path) -> Vocabulary:
    profiles = [load_profile(shipped_profiles()[name]) for name in ("omni", "kuka1", "cf1")]
    return Vocabulary.build(profiles, known_units(), command_table(), read_lexicons(folder))


def added(folder: Path, code: str, text: str) -> Path:
    (folder / code).mkdir(exist_ok=True)
    (folder / code / "lexicon.toml").write_text(text, encoding="utf-8")
    return folder


def test_the_howto_adds_a_language(locale: Path) -> None:
    added(locale, "it", BLOCKS["toml"])
    command = BLOCKS["sh"].split()
    assert command[:3] == ["python", "-m", "rosic.config.lexicons"]
    checked = subprocess.run(  # noqa: S603 - the command is that of the page
        [sys.executable, *command[1:3], str(locale)], capture_output=True, text=True, check=True
    )
    assert "it: " in checked.stdout
    vocabulary = vocabulary_of(locale)
    context = LineContext("", frozenset(vocabulary.profiles))
    lines = BLOCKS["chat"].splitlines()
    for said, answer in zip(lines[::2], lines[1::2], strict=True):
        [line] = understand(said.removeprefix("> "), vocabulary, context)
        if isinstance(line, Misunderstood):
            assert line.sentence == answer, said
            continue
        [meant] = understand(answer, vocabulary, context)
        assert isinstance(line, Do), said
        assert isinstance(meant, Do), answer
        assert bind(vocabulary, "omni", line.skills[0], line.spoken) == bind(
            vocabulary, "omni", meant.skills[0], meant.spoken
        ), said


def test_without_the_language_none_of_it_acts() -> None:
    vocabulary = vocabulary_of(SHIPPED)
    context = LineContext("", frozenset(vocabulary.profiles))
    for said in BLOCKS["chat"].splitlines()[::2]:
        [line] = understand(said.removeprefix("> "), vocabulary, context)
        assert not isinstance(line, Do), said


def test_a_word_that_denies_in_one_language_lets_no_line_act_in_another(locale: Path) -> None:
    """Portuguese ``no`` is ``in the``, as Catalan and Spanish ``no`` is not."""
    nothing = BLOCKS["toml"].replace('nothing = ["il"', 'nothing = ["no", "il"')
    assert nothing != BLOCKS["toml"]
    vocabulary = vocabulary_of(added(locale, "it", nothing))
    context = LineContext("", frozenset(vocabulary.profiles))
    for said, acts in (("omni avanza due metri", True), ("omni no avanza due metri", False)):
        [line] = understand(said, vocabulary, context)
        assert isinstance(line, Do) is acts, said


WRONG = (
    ('[skills]\ngrasp = ["seize"]\n', '"seize" means number 16 and skill grasp'),
    ('[choices]\nleft = ["rechts"]\n', '"rechts" means choice left and choice right'),
    ('[verbs]\nmove = ["stopp"]\n', "stops a robot or ends its order everywhere"),
    ('[skills]\ngrasp = ["… su"]\n', "has nothing before or after its gap"),
    ('[skils]\ngrasp = ["x"]\n', "unknown field `skils`"),
    ('[skills]\ngrasp = "x"\n', "Expected `array`"),
    ("[skills\n", "cannot be read"),
    ('[numbers]\n"abc" = ["xx"]\n', '"abc" is no number'),
    ('[amounts]\n"90deg" = ["xx"]\n', '"90deg" is no number'),
    ('[amounts]\n"90" = ["xx"]\n', "has no unit"),
    ('[numerals]\ncompound = "{due}"\n', "compound is made of {one} and {ten}"),
    ('[times]\nat2 = ["xx"]\n', '[times] has no "at2"; it has am, at, day'),
    ('[questions]\nstatsu = ["xx"]\n', '[questions] has "statsu", which no other language has'),
    ('[blocked]\nnegatoin = ["xx"]\n', '[blocked] has no "negatoin"'),
)


@pytest.mark.parametrize(("text", "sentence"), WRONG)
def test_a_mistake_is_one_sentence(
    locale: Path, text: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(added(locale, "it", text))]) == 1
    assert sentence in capsys.readouterr().out


def test_a_folder_without_a_lexicon_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path)]) == 1
    assert capsys.readouterr().out == f"{tmp_path}: There is no <language>/lexicon.toml here.\n"


def test_what_cannot_be_read_names_its_file(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError) as told:
        read_lexicon(tmp_path / "lexicon.toml")
    assert told.value.where == str(tmp_path / "lexicon.toml")
