"""What Telegram would make a link of by itself, marked so that it makes none.

Telegram looks for links, mentions, addresses, numbers to call and more in every text, whoever wrote
it (https://core.telegram.org/bots/api#messageentity). Robots and people are quoted in what ROSIC
says, so these stand as ``code``, within which Telegram finds nothing. Commands stay: ROSIC offers
them. What looks like a number to call is not published; here it is seven digits in a row, or in
groups as people write them. Dates, times, lengths and places are none.
"""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect
from typing import TYPE_CHECKING, Final

from telegram import InlineKeyboardButton, InlineKeyboardMarkup, MessageEntity

from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import TypeAlias

    from rosic.core.message import Outbound


# ---- lengths in UTF-16 code units ----

MESSAGE_UNITS = 4_096
CAPTION_UNITS = 1_024
ANSWER_UNITS = 200
LABEL_UNITS = 64

_JOINS = frozenset({"\u200d", "\ufe0e", "\ufe0f"})
_SEAMS = ("\n\n", "\n", ". ", " ")


def clean(text: str) -> str:
    """Return the text with halves of characters replaced, which no connection can carry."""
    return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")


def units(text: str) -> int:
    """Return its length in UTF-16 code units."""
    return len(text) if text.isascii() else len(text.encode("utf-16-le", "surrogatepass")) // 2


def shorten(text: str, limit: int) -> str:
    """Return as much of it as fits; for labels, which have no second part."""
    text = clean(text)
    return text if units(text) <= limit else text[: _fit(text, limit - 1)] + "…"


def split(text: str, limit: int = MESSAGE_UNITS) -> list[str]:
    """Cut a text into parts of at most ``limit`` units, at a paragraph, a line, a word if it can.

    Nothing is lost but white space at the seams, which Telegram takes away from the ends of a
    message anyway.
    """
    rest, parts = clean(text), []
    while units(rest) > limit:
        end = _seam(rest, _fit(rest, limit))
        parts.append(rest[:end].rstrip())
        rest = rest[end:].lstrip()
    parts.append(rest)
    return [part for part in parts if part] or [""]


def _fit(text: str, limit: int) -> int:
    """Return how many characters fit into so many units, without taking a character apart."""
    taken = 0
    for index, character in enumerate(text):
        taken += 2 if character > "\uffff" else 1
        if taken > limit:
            return _whole(text, index)
    return len(text)


def _whole(text: str, end: int) -> int:
    """Move a cut forwards, out of a character that is made of several."""
    for back in range(32):
        at = end - back
        if at <= 1:
            break
        joined = text[at] in _JOINS or text[at - 1] == "\u200d" or unicodedata.combining(text[at])
        if not joined:
            return at
    return end


def _seam(text: str, end: int) -> int:
    """Return the best place to cut in the second half of what fits."""
    for seam in _SEAMS:
        at = text.rfind(seam, end // 2, end + 1)
        if at > 0 and text[:at].strip():
            return min(at + len(seam), end)
    return end


# ---- no links by themselves ----


if TYPE_CHECKING:
    Span: TypeAlias = tuple[int, int]

_FOUND: Final = re.compile(
    r"""
    (?: https? | ftp | tg | ton (?:site)? ) : // [^\s<>]{1,2000}     # anything with a scheme
    | (?<! [\w@.+-] ) [\w.+-]{1,64} @ (?: [\w-]{1,63} \. ){1,8} [^\W\d_]{2,24}   # an address
    | (?<! [\w@] ) @ [A-Za-z] \w{1,64}                 # somebody's account
    | (?<! [\w@.-] ) (?: (?: [\w-]{1,63} \. ){1,8} [^\W\d_]{2,24}    # a host by its name,
                       | (?: [0-9]{1,3} \. ){3} [0-9]{1,3} ) (?! \w )   # or by its number, and
      (?: [/?:\#] [^\s<>]{0,2000} )?                    # what may follow it
    | (?<! [\w\#] ) \# (?= [\d_]{0,255} [^\W\d_] ) \w{1,256}         # a hashtag: it has a letter
    | (?<! [\w$] ) \$ (?-i: 1INCH | [A-Z]{1,8} ) (?! [\w$] )         # a cashtag
    """,
    re.VERBOSE | re.IGNORECASE,
)
_DIGITS: Final = re.compile(r"[0-9](?:[ ()-]{0,2}[0-9]){6}")
"""Without these a text holds no number to call."""
_NUMBERS: Final = re.compile(
    r"""
    (?<! [\w+] ) \+ [0-9] (?: [ ()-]{0,2} [0-9] ){6,14}              # abroad
    | (?<! [\w.,:+-] ) (?: [0-9]{7,}                                 # in a row
        | \( [0-9]{2,5} \) [ -]? [0-9] (?: [ -]? [0-9] ){4,11}       # with an area code
        | 0 [0-9]{1,4} (?= (?: [ ]? [0-9] ){5} ) (?: [ ] [0-9]{2,8} ){1,4}       # in groups
        | [2-9] [0-9]{2} [ ] [0-9]{3} [ ] [0-9]{4}
        | (?! [0-9]{4} - [0-9]{2} - [0-9]{2} (?! [0-9] ) ) (?= (?: [0-9] -? ){7} )   # no date
          [0-9]{1,5} (?: - [0-9]{2,7} ){1,4} (?! - )
      ) (?! \w | [.,:] [0-9] )
    | (?P<card> (?<! [\w.,+-] ) [0-9] (?: [ -]{0,2} [0-9] ){12,18} (?! [\w-] ) )  # of a bank card
    """,
    re.VERBOSE,
)
_INVITATION: Final = re.compile(r"https://t\.me/\w{5,32}\?start=[\w-]{1,64}", re.ASCII)
"""What ROSIC says to be tapped; it opens a bot of Telegram and nothing else."""
MARKS_AT_MOST: Final = 100
"""Telegram forgets what is marked beyond so much."""


def inert(text: str) -> tuple[MessageEntity, ...] | None:
    """Return the marks of a text that make it lead nowhere; None where there is nothing to mark."""
    spans: list[Span] = []
    if "." in text or "@" in text or "://" in text or "#" in text or "$" in text:
        spans = [found.span() for found in _FOUND.finditer(text)]
    if _DIGITS.search(text) is not None:
        spans = sorted([*spans, *_numbers(text, spans)])
    spans = [span for span in spans if not _is_invitation(text[slice(*span)])]
    if len(spans) > MARKS_AT_MOST:
        spans = [(spans[0][0], spans[-1][1])]
    return tuple(_marks(text, spans)) or None


def _marks(text: str, spans: list[Span]) -> Iterator[MessageEntity]:
    """Yield a mark for each span, counted from the one before: each sign is counted once."""
    at = offset = 0
    for begin, end in spans:
        offset += units(text[at:begin])
        length = units(text[begin:end])
        yield MessageEntity(MessageEntity.CODE, offset, length)
        at, offset = end, offset + length


def _is_invitation(text: str) -> bool:
    return _INVITATION.fullmatch(text.rstrip(".,;:!?)")) is not None


def _numbers(text: str, taken: list[Span]) -> Iterator[Span]:
    """Find numbers that lie outside what was found already."""
    begins = [begin for begin, _ in taken]
    for found in _NUMBERS.finditer(text):
        if found.lastgroup == "card" and not _adds_up(found[0]):
            continue
        after = bisect(begins, found.start())
        before_end = taken[after - 1][1] if after else 0
        next_begin = begins[after] if after < len(begins) else len(text)
        if before_end <= found.start() and found.end() <= next_begin:
            yield found.span()


def _adds_up(number: str) -> bool:
    """Whether a number ends in the digit that a bank card's would (ISO/IEC 7812)."""
    digits = [int(sign) for sign in reversed(number) if sign.isdecimal()]
    doubled = (sum(divmod(2 * digit, 10)) for digit in digits[1::2])
    return (sum(digits[::2]) + sum(doubled)) % 10 == 0


# ---- buttons ----

NONCE_BYTES: Final = 64


def keyboard_of(outbound: Outbound) -> InlineKeyboardMarkup | None:
    """Return the buttons under a message; None where there are none.

    Raises:
        MessengerFault: Telegram would take one of them from nobody. Nothing was sent.
    """
    if not outbound.buttons:
        return None
    for button in (button for row in outbound.buttons for button in row):
        if not 1 <= len(button.nonce.encode()) <= NONCE_BYTES or not button.label.strip():
            raise MessengerFault("A button without a label or a usable nonce. Nothing was sent.")
    rows = [
        [
            InlineKeyboardButton(shorten(button.label, LABEL_UNITS), callback_data=button.nonce)
            for button in row
        ]
        for row in outbound.buttons
    ]
    return InlineKeyboardMarkup(rows)
