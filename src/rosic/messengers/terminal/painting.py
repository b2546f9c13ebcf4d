"""What a terminal shows: colours where they are wanted, and never somebody's escape sequence."""

from __future__ import annotations

import re

_BOLD, _DIM, _RED, _GREEN, _YELLOW, _CYAN = "1", "2", "1;31", "32", "33", "36"

# The markup of a terminal. Shown as a sign instead, a text can neither move the cursor nor change
# what stands above it.
_CONTROLS = dict.fromkeys((*range(32), *range(127, 160)), "�")
_CONTROLS |= {
    ord("\n"): "\n",
    ord("\t"): "\t",
    **{code: chr(0x2400 + code) for code in range(0x20) if chr(code) not in "\n\t"},
}

_LINE = re.compile(r"(?P<who>STOP(?: sent to)?|[^\s:\[][^:\n]{0,63}): (?P<what>.*)")
_CHOICE = re.compile(r"\[\d+\]")
_GOOD = ("done",)
_ODD = ("failed", "not ", "stopped before", "sent; ", "refused")


def harmless(text: str) -> str:
    """Return the text as a terminal may be given it: every character, no markup."""
    return text.translate(_CONTROLS)


def painted(text: str) -> str:
    """Return the text with colours: who in bold, a stop in red, how it ended in its colour."""
    return "\n".join([_line(line) for line in text.split("\n")])


def _line(line: str) -> str:
    if line.startswith("> "):
        return _in(_DIM, line)
    if line.lstrip().startswith("["):
        return _CHOICE.sub(lambda found: _in(_CYAN, found[0]), line)
    match = _LINE.match(line)
    if match is None:
        return line
    who, what = match["who"], match["what"]
    if who.startswith("STOP"):
        return f"{_in(_RED, who)}: {what}"
    if what.startswith(_GOOD):
        what = _in(_GREEN, what)
    elif what.startswith(_ODD):
        what = _in(_YELLOW, what)
    return f"{_in(_BOLD, who)}: {what}"


def _in(code: str, text: str) -> str:
    return f"\x1b[{code}m{text}\x1b[0m"
