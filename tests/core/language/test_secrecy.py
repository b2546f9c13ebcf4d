"""Nothing is kept of what is read as a secret: one rule for reading and for leaving out."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosic.app.features import command_table
from rosic.config.units import compile_units
from rosic.core.language import (
    CommandLine,
    LanguageReader,
    Start,
    Vocabulary,
    VocabularyHolder,
    without_codes,
)
from tests.gateway.place import FLEET

READER = LanguageReader(VocabularyHolder(Vocabulary.build(FLEET, compile_units(), command_table())))
VISIBLE = frozenset(profile.id for profile in FLEET)
SECRET = "417293"  # noqa: S105 - of nobody


def is_read_as_secret(text: str) -> bool:
    """Whether some line of a text brings the secret to where one is expected."""
    for line in READER.lines(text, "", VISIBLE):
        brought = line.payload if isinstance(line, Start) else ""
        if isinstance(line, CommandLine) and line.verb in {"code", "authenticator"}:
            brought = "" if line.rest.casefold().startswith("reset") else line.rest
        if SECRET in brought:
            return True
    return False


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("please code 417293", "please code -"),
        ("the code 417293", "the code -"),
        ("to code 417293", "to code -"),
        ("code: 417293", "code: -"),
        ("code, 417293", "code, -"),
        ("\uff43\uff4f\uff44\uff45 417293", "\uff43\uff4f\uff44\uff45 -"),
        ("\u200bcode 417293", "code -"),
        ("\ufeffcode 417293", "code -"),
        ("c\u00ado\u00adde 417293", "code -"),
        ("hello\n  /Code@lab_bot: 417293", "hello\n/Code@lab_bot: -"),
        ("/code\n \u200b\n417293\nhello", "/code\n \u200b\n-\nhello"),
    ],
)
def test_a_secret_is_left_out_however_its_command_is_written(text: str, kept: str) -> None:
    assert without_codes(text, command_table(), "-") == kept


@pytest.mark.parametrize(
    "text",
    ["", "please omni status", "code", "the", "/", "the /", "decode 1\n=", "\u200b\n", "Barcode"],
)
def test_what_is_no_secret_stays(text: str) -> None:
    assert without_codes(text, command_table(), "-") == text


BEFORE = st.sampled_from(
    ["please", "the", "&", "to", "bitte", "omni", ":", "/", "//", "\u200b", "", "="]
)
HIDDEN = ("\uff43\uff4f\uff44\uff45", "c\u200bode", "co\u00adde", "\ufeffcode", "\U0001d41code")
PLAIN = ("code", "Code", "/code", "/code@lab_bot", "authenticator", "start", "/start", "join")
WORD = st.sampled_from(PLAIN + HIDDEN)
BETWEEN = st.sampled_from(
    [" ", ": ", ", ", "; ", ". ", "! ", "\t", "\u00a0", "\u3000", " = ", "=", "\n", "\n\n"]
)
BEHIND = st.sampled_from(
    [SECRET, f"{SECRET} please", f"the {SECRET}", f"{SECRET}.", f"reset {SECRET}"]
)
LINE = st.one_of(
    st.tuples(st.lists(BEFORE, max_size=3).map(" ".join), st.just(" "), WORD, BETWEEN, BEHIND).map(
        "".join
    ),
    st.text(max_size=10),
)


@given(st.lists(LINE, min_size=1, max_size=4).map("\n".join))
@example(f"please code {SECRET}")
@example(f"bitte code {SECRET}")
@example(f"omni start {SECRET}")
def test_whatever_is_read_as_a_secret_is_left_out(text: str) -> None:
    kept = without_codes(text, command_table(), "-")
    assert not is_read_as_secret(kept)
    if is_read_as_secret(text):
        assert kept != text
