"""A picture of a chat, as a phone shows it: one SVG, the same for the same transcript.

Buttons that were tapped are filled and numbered. A form of a message whose place another took is
grey, with a dashed line to the next. The transcript itself is in the picture, as JSON: see
`in_picture`.
"""

from __future__ import annotations

import re
import unicodedata
from html import escape, unescape
from itertools import cycle
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.testing.telegram.transcript import Key, read_transcript, written

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rosic.testing.telegram.transcript import Bubble, Transcript


# ---- lettering ----

# How wide letters are, and where lines break: without a font, the same on every machine.
#
# The widths are those of Helvetica, which Arial and Liberation Sans share. A drawing that also
# says how long each line is meant to be looks right in any other font.

ELLIPSIS: Final = "\u2026"

# Thousandths of the letter size.
_WIDTHS: Final = {
    letter: width
    for width, letters in (
        (191, "'"),
        (222, "ijl\u2018\u2019"),
        (260, "|"),
        (278, " !,./:;I[\\]ft\u00b7\u00a0"),
        (333, "()-`r\u201c\u201d\u00b2\u00b3"),
        (334, "{}"),
        (350, "\u2022"),
        (355, '"'),
        (389, "*"),
        (400, "\u00b0"),
        (469, "^"),
        (500, "Jcksvxyz"),
        (549, "\u2264\u2265"),
        (556, "#$0123456789?L_abdeghnopqu\u2013\u20ac"),
        (584, "+<=>~\u00b1\u00d7"),
        (611, "FTZ\u00df"),
        (667, "&ABEKPSVXY"),
        (722, "CDHNRUw"),
        (778, "GOQ"),
        (833, "Mm"),
        (889, "%"),
        (944, "W"),
        (1000, "\u2014\u2026\u2190\u2191\u2192\u2193"),
        (1015, "@"),
    )
    for letter in letters
}
_USUAL: Final = 570
_WIDE: Final = 1000


def width_of(text: str, size: float) -> float:
    """Return how wide a text is, in the unit of the letter size."""
    return sum(map(_width, text)) * size / 1000


def _width(letter: str) -> int:
    known = _WIDTHS.get(letter)
    if known is not None:
        return known
    if unicodedata.combining(letter) or unicodedata.category(letter) in {"Cf", "Cc"}:
        return 0
    if unicodedata.east_asian_width(letter) in {"W", "F"}:
        return _WIDE
    base = unicodedata.normalize("NFD", letter)[0]
    return _WIDTHS.get(base, _USUAL)


def wrapped(text: str, size: float, most: float) -> list[str]:
    """Return a text as lines no wider than ``most``.

    Lines break at spaces; a word that is wider than a line breaks anywhere. White space at the
    beginning of a line of the text stays.
    """
    return [line for said in text.split("\n") for line in _broken(said, size, most)]


def _broken(text: str, size: float, most: float) -> Iterator[str]:
    line = text[: len(text) - len(text.lstrip())]
    begun = False
    for whole in text.split():
        word = whole
        wider = f"{line} {word}" if begun else f"{line}{word}"
        if begun and width_of(wider, size) > most:
            yield line
            wider = word
        while len(wider) > 1 and width_of(wider, size) > most:
            at = _fits(wider, size, most)
            yield wider[:at]
            wider = wider[at:]
        line, begun = wider, True
    yield line


def _fits(text: str, size: float, most: float) -> int:
    """Return how many letters of a text fit; one does in any case."""
    at = 1
    while at < len(text) and width_of(text[: at + 1], size) <= most:
        at += 1
    return at


def cut(text: str, size: float, most: float) -> str:
    """Return a text on one line, with an ellipsis where it had to be cut off."""
    text = " ".join(text.split())
    if width_of(text, size) <= most:
        return text
    kept = _fits(text, size, most - width_of(ELLIPSIS, size))
    return text[:kept].rstrip() + ELLIPSIS


# ---- picture ----

WIDTH: Final = 390
EDGE, PAD, GAP = 10, 11, 8
WIDEST: Final = 316
TEXT, LINE = 15, 20
SMALL, KEY_TEXT, KEY_HIGH, KEY_GAP = 11, 13.5, 36, 4
HEAD, QUOTE = 54, 40
BADGE: Final = 9
BOLDER: Final = 1.08  # bold letters are about so much wider

FONT = "Helvetica, Arial, 'Liberation Sans', Roboto, sans-serif"
PAPER, INK, FAINT, ACCENT = "#dfe7ee", "#16202a", "#6b7781", "#2f7fd6"
THEIRS, OWN, PAST, PAST_INK = "#ffffff", "#e1f5cd", "#eef2f5", "#5c6770"
KEY_FILL, KEY_INK, PAST_KEY = "#f7fafc", "#24639f", "#e9eef2"
_UNWRITABLE: Final = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ufffe\uffff]")
NAMES = ("#c03d33", "#3f7d20", "#7a4fb5", "#b8651b", "#1d7f86")


def draw(shown: Transcript) -> str:
    """Return a transcript as an SVG, as wide as a phone and as high as it needs."""
    return _Drawing(shown).svg()


def in_picture(svg: str) -> Transcript:
    """Return the transcript that a picture was drawn from.

    Raises:
        ValueError: There is none in it.
    """
    found = re.search(r"<metadata>(.*?)</metadata>", svg, re.DOTALL)
    if found is None:
        raise ValueError("this picture holds no transcript")
    return read_transcript(unescape(found[1]))


class _Box(msgspec.Struct):
    """Where a bubble stands, in pixels."""

    past: bool
    left: float
    top: float
    width: float
    height: float
    lines: list[str]


class _Drawing:
    """One picture, drawn from the top down."""

    def __init__(self, shown: Transcript) -> None:
        self._shown = shown
        self._parts: list[str] = []
        self._y: float = HEAD + GAP
        self._tints = cycle(NAMES)
        self._tint: dict[str, str] = {}
        self._before: Bubble | None = None

    def svg(self) -> str:
        for bubble in self._shown.bubbles:
            if bubble.tap:
                self._start(bubble.tap)
            self._bubble(bubble)
            self._before = bubble
        height = round(self._y + GAP)
        title = _plain(self._shown.title)
        record = _in_json(escape(written(self._shown).decode(), quote=False))
        begin = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
            f'viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{title}" '
            f'font-family="{FONT}">'
        )
        parts = [begin, f"<metadata>{record}</metadata>", *self._frame(height), *self._parts]
        return "\n".join([*parts, "</svg>"]) + "\n"

    def _frame(self, height: int) -> list[str]:
        shown = self._shown
        title = cut(shown.title, 17 * BOLDER, WIDTH - 80)
        below = cut(shown.below, 13, WIDTH - 80)
        initial = _plain(shown.title[:1].upper())
        return [
            f'<rect width="{WIDTH}" height="{height}" rx="14" fill="{PAPER}"/>',
            f'<path d="M0 {HEAD}V14a14 14 0 0 1 14-14H376a14 14 0 0 1 14 14V{HEAD}z" fill="#fff"/>',
            f'<circle cx="32" cy="27" r="18" fill="{ACCENT}"/>',
            f'<text x="32" y="33" font-size="17" text-anchor="middle" fill="#fff">{initial}</text>',
            _bold(title, (60, 24), 17, INK),
            (
                f'<text x="60" y="42" font-size="13" fill="{FAINT}"{_as_long(below, 13)}>'
                f"{_plain(below)}</text>"
            ),
        ]

    # ---- one message ----

    def _bubble(self, bubble: Bubble) -> None:
        before = self._before
        quoted = _worth_quoting(bubble, before)
        box = self._laid_out(bubble, quoted)
        if before is not None and before.past and before.message == bubble.message:
            self._arrow(box)
        fill = PAST if bubble.past else OWN if bubble.own else THEIRS
        self._rect((box.left, box.top, box.width, box.height), 13, fill)
        y = box.top + 7
        if bubble.name and not bubble.own:
            self._name(bubble.name, box.left + PAD, y + 13)
            y += LINE
        if quoted is not None:
            self._quote(quoted, box, y)
            y += QUOTE
        ink = PAST_INK if bubble.past else INK
        for line in box.lines:
            y += LINE
            self._text(line, (box.left + PAD, y - 5), TEXT, ink)
        foot = self._foot(bubble)
        where = (box.left + box.width - PAD - width_of(foot, SMALL), box.top + box.height - 7)
        self._text(foot, where, SMALL, FAINT)
        self._y = box.top + box.height + KEY_GAP
        for row in bubble.keys:
            self._row(row, box)
        self._y += GAP - KEY_GAP

    def _laid_out(self, bubble: Bubble, quoted: tuple[str, str] | None) -> _Box:
        """Return where a bubble stands: as wide as what is in it, and in reach of its edge."""
        inner = WIDEST - 2 * PAD
        lines = wrapped(bubble.text, TEXT, inner)
        foot = width_of(self._foot(bubble), SMALL)
        last = width_of(lines[-1], TEXT) + 10 + foot
        wide = max([width_of(line, TEXT) for line in lines] + [foot])
        high = len(lines) * LINE + 14
        if last <= inner:
            wide = max(wide, last)
        else:
            high += 14
        if quoted is not None:
            high += QUOTE
            wide = max(wide, 12 + max(width_of(said, 13) for said in quoted))
        if bubble.name and not bubble.own:
            high += LINE
            wide = max(wide, width_of(bubble.name, 13) * 1.1)
        wide = max(wide, *(_row_width(row) - 2 * PAD for row in bubble.keys), 0.0)
        width = min(wide, inner) + 2 * PAD
        left = WIDTH - EDGE - width if bubble.own else EDGE
        return _Box(bubble.past, left, self._y, width, high, lines)

    def _foot(self, bubble: Bubble) -> str:
        return f"{self._shown.app.edited} {bubble.at}" if bubble.edited else bubble.at

    def _quote(self, quoted: tuple[str, str], box: _Box, y: float) -> None:
        name, said = quoted
        x = box.left + PAD
        self._rect((x, y + 3, 3, QUOTE - 8), 1.5, ACCENT)
        self._text(name, (x + 10, y + 15), 13, ACCENT)
        self._text(cut(said, 13, box.width - 2 * PAD - 12), (x + 10, y + 31), 13, FAINT)

    def _name(self, name: str, x: float, y: float) -> None:
        if name not in self._tint:
            self._tint[name] = next(self._tints)
        said = cut(name, 13, WIDEST - 4 * PAD)
        self._parts.append(_bold(said, (x, y), 13, self._tint[name]))

    def _arrow(self, box: _Box) -> None:
        """Draw a line from a form of a message to the next, and make room for it."""
        x, top = EDGE + 22, self._y - GAP + 3
        box.top += 2 * GAP
        self._parts.append(
            f'<path d="M{x} {_n(top)}V{_n(box.top - 3)}" fill="none" stroke="{FAINT}" '
            f'stroke-width="1.5" stroke-dasharray="3 2"/>'
            f'<path d="M{x - 4} {_n(box.top - 7)}l4 4l4 -4" fill="none" stroke="{FAINT}" '
            f'stroke-width="1.5"/>'
        )

    # ---- buttons ----

    def _row(self, row: Sequence[Key], box: _Box) -> None:
        width = (box.width - KEY_GAP * (len(row) - 1)) / len(row)
        for number, key in enumerate(row):
            left = box.left + number * (width + KEY_GAP)
            plain = PAST_KEY if box.past else KEY_FILL
            ink = PAST_INK if box.past else KEY_INK
            self._key(key, (left, self._y, width), (ACCENT, "#fff") if key.tap else (plain, ink))
        self._y += KEY_HIGH + KEY_GAP

    def _key(self, key: Key, where: tuple[float, float, float], looks: tuple[str, str]) -> None:
        left, top, width = where
        fill, ink = looks
        self._rect((left, top, width, KEY_HIGH), 9, fill)
        label = cut(key.label, KEY_TEXT, width - 12)
        self._parts.append(
            f'<text x="{_n(left + width / 2)}" y="{_n(top + 23)}" font-size="{KEY_TEXT}" '
            f'text-anchor="middle" fill="{ink}"{_as_long(label, KEY_TEXT)}>{_plain(label)}</text>'
        )
        if key.tap:
            self._badge(key.tap, left + width - 5, top + 5)

    def _start(self, tap: int) -> None:
        """Draw Telegram's own button at the foot of a chat that was never spoken in."""
        where = (EDGE, self._y, WIDTH - 2 * EDGE)
        self._key(Key(self._shown.app.start, tap), where, (ACCENT, "#fff"))
        self._y += KEY_HIGH + GAP

    def _badge(self, number: int, x: float, y: float) -> None:
        self._parts.append(
            f'<circle cx="{_n(x)}" cy="{_n(y)}" r="{BADGE}" fill="{INK}" stroke="#fff" '
            f'stroke-width="1.5"/><text x="{_n(x)}" y="{_n(y + 4)}" font-size="11" '
            f'font-weight="bold" text-anchor="middle" fill="#fff">{number}</text>'
        )

    # ---- strokes ----

    def _rect(self, box: tuple[float, float, float, float], round_: float, fill: str) -> None:
        x, y, width, height = map(_n, box)
        self._parts.append(
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{round_}" fill="{fill}"/>'
        )

    def _text(self, text: str, at: tuple[float, float], size: float, fill: str) -> None:
        """Write one line, as long as it was reckoned, whatever the font is."""
        said = text.lstrip()
        if not said:
            return
        x = at[0] + width_of(text[: len(text) - len(said)], size)
        self._parts.append(
            f'<text x="{_n(x)}" y="{_n(at[1])}" font-size="{size}" fill="{fill}"'
            f"{_as_long(said, size)}>{_plain(said)}</text>"
        )


def _bold(text: str, at: tuple[float, float], size: float, fill: str) -> str:
    return (
        f'<text x="{_n(at[0])}" y="{_n(at[1])}" font-size="{size}" font-weight="bold" '
        f'fill="{fill}"{_as_long(text, size * BOLDER)}>{_plain(text)}</text>'
    )


def _as_long(text: str, size: float) -> str:
    """Return the attributes that keep a line as long as it was reckoned, whatever the font is."""
    long = width_of(text, size)
    return f' textLength="{_n(long)}" lengthAdjust="spacingAndGlyphs"' if long else ""


def _plain(text: str) -> str:
    """Return a text as it may stand in XML, which knows no way to write some characters."""
    return escape(_UNWRITABLE.sub("", text))


def _in_json(text: str) -> str:
    """Return JSON in which those characters are written as JSON has it."""
    return _UNWRITABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def _worth_quoting(bubble: Bubble, before: Bubble | None) -> tuple[str, str] | None:
    """Return who is quoted and what, a line each; not what stands right above, or did before."""
    quote = bubble.answers
    if quote is None or (before is not None and before.message in {quote.message, bubble.message}):
        return None
    most = WIDEST - 2 * PAD - 12
    return cut(quote.name, 13, most), cut(quote.text, 13, most)


def _row_width(row: Sequence[Key]) -> float:
    """Return how wide a row has to be for all of its labels to be read."""
    widest = max(width_of(key.label, KEY_TEXT) for key in row) + 24
    return len(row) * widest + (len(row) - 1) * KEY_GAP


def _n(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
