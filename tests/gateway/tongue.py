"""A language that shows what was forgotten: every word that a catalogue gave stands in brackets."""

from __future__ import annotations

import re
from string import Formatter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.message import Outbound

OPEN, CLOSE = "⟦", "⟧"
_TRANSLATED = re.compile(f"{OPEN}[^{OPEN}{CLOSE}]*{CLOSE}")
_QUOTED = re.compile(r'"[^"]*"')
_WORD = re.compile(r"(?<![\w/-])[A-Za-z][\w-]+")


class Bracketed:
    """Puts the words of each template in brackets, and leaves its fields outside of them.

    So what fills a field has to be translated by itself, or to be a name or a number.
    """

    def gettext(self, message: str) -> str:
        return "".join(
            (f"{OPEN}{text.replace('{', '{{').replace('}', '}}')}{CLOSE}" if text else "")
            + ("" if name is None else _field(name, spec, conversion))
            for text, name, spec, conversion in Formatter().parse(message)
        )

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        return self.gettext(msgid1 if n == 1 else msgid2)


def _field(name: str, spec: str | None, conversion: str | None) -> str:
    shown = f"!{conversion}" if conversion else ""
    return f"{{{name}{shown}:{spec}}}" if spec else f"{{{name}{shown}}}"


def forgotten(text: str, names: frozenset[str]) -> list[str]:
    """Return the words of a text that no catalogue gave and that are no names."""
    rest = _QUOTED.sub(" ", _TRANSLATED.sub(" ", text))
    return [word for word in _WORD.findall(rest) if word.casefold() not in names]


def forgotten_in(outbound: Outbound, names: frozenset[str]) -> list[str]:
    """Return the same of a message and its buttons; what a button says is typed, not translated."""
    labels = [
        button.label
        for row in outbound.buttons
        for button in row
        if button.label.strip("/") != button.command.lstrip("/?!")
    ]
    return [word for text in (outbound.text, *labels) for word in forgotten(text, names)]
