"""The pictures of chats in the documentation: what they say must be what is said today."""

from __future__ import annotations

import os
import re
from difflib import unified_diff
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rosic.config.plugins import LANGUAGES, catalogue
from rosic.core.i18n import in_language
from rosic.core.local_time import MONTHS, WEEKDAYS, LocalTime
from rosic.organiser.calendar_messages import clock_and_day
from rosic.testing.telegram.picture import draw, in_picture

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.testing.telegram.transcript import Transcript

DOCS: Final = Path(__file__).parents[2] / "docs"
FOLDER: Final = DOCS / "pictures"
PAGE: Final = DOCS / "first-time.md"
ASKED_TO_DRAW: Final = "ROSIC_PICTURES"
STALE: Final = "docs/pictures/{name}.svg does not say this any more: look, then run make pictures"


def _in_every_language(sentences: Iterable[str]) -> str:
    """Return what matches any of these sentences, said in any language, the longest first."""
    catalogues = [catalogue(code) for code in LANGUAGES]
    found = {in_language(one, spoken) for one in sentences for spoken in catalogues}
    return "|".join(map(re.escape, sorted(found, key=len, reverse=True)))


_WEEKDAY, _MONTH = _in_every_language(WEEKDAYS), _in_every_language(MONTHS)
_NEXT_DAY: Final = _in_every_language([clock_and_day(LocalTime.at(1), LocalTime.at(0))]).replace(
    "00:00", ""
)

# What differs from run to run: when it was, how fast a stop was, how far a robot had come by then.
_VARIES: Final = (
    (re.compile(rf"\b(?:{_WEEKDAY}) \d{{1,2}} (?:{_MONTH})(?: \d{{4}})?"), "DAY"),
    (re.compile(rf"\b\d{{4}}-\d\d-\d\d\b|\b(?:{_NEXT_DAY}|DAY )(?=\d\d:\d\d)"), "DAY "),
    (re.compile(r"\b\d\d:\d\d(?::\d\d)?\b"), "TIME"),
    (re.compile(r"(?:DAY +)?TIME"), "TIME"),
    (re.compile(r"\(\d+[.,]\d\d s\)|\b(?:within|innerhalb von) \d+ s\b"), "(SO SOON)"),
    (re.compile(r"\b\d+ %"), "SO MUCH"),
    (re.compile(r"((?:stopped before it ended|vor dem Ende angehalten) TIME).*"), r"\1"),
)


def lines_of(shown: Transcript) -> list[str]:
    """Return what a conversation says, without what differs from run to run."""
    return [steady(line) for line in shown.lines()]


def steady(line: str) -> str:
    """Return a line without what differs from run to run."""
    for pattern, instead in _VARIES:
        line = pattern.sub(instead, line)
    return line


def check_picture(name: str, shown: Transcript) -> None:
    """See that a picture in the documentation shows this; draw it anew where that is asked for.

    Raises:
        AssertionError: It shows something else.
    """
    file = FOLDER / f"{name}.svg"
    if os.environ.get(ASKED_TO_DRAW):
        FOLDER.mkdir(exist_ok=True)
        file.write_text(draw(shown))
    drawn, now = lines_of(in_picture(file.read_text())), lines_of(shown)
    assert drawn == now, "\n".join([STALE.format(name=name), *unified_diff(drawn, now, n=1)])


def row(name: str, shown: Transcript) -> str:
    """Return the line of the page that counts what somebody did and read."""
    return f"| [{name}](pictures/{name}.svg) | {shown.taps} | {shown.typed} | {shown.read} |"


def check_counts(name: str, shown: Transcript) -> None:
    """See that the page says these counts.

    Raises:
        AssertionError: It says others.
    """
    said = row(name, shown)
    assert said in PAGE.read_text(), f"docs/first-time.md should say: {said}"
