"""Buttons where a messenger has none: a number beneath the text, to be typed."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.core.language import hears_stop
from rosic.core.time_units import MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.message import Button, Inbound, Outbound

GAP: Final = "   "
HIGHEST: Final = 99
CHATS: Final = 4_096
AGAIN_NS: Final = 5 * MINUTE_NS
LATE_NS: Final = 5 * SECOND_NS
_TEN: Final = "\U0001f51f"
_KEYCAP: Final = "\u20e3"
_VARIATION: Final = "\ufe0f"


class OfferedButton(NamedTuple):
    """A button beneath a message.

    Attributes:
        message: Which: its id, or what stands for it until it has one.
        nonce: What a tap on it carries.
        urgent: It says stop.
    """

    message: object
    nonce: str
    urgent: bool


class _ChatNumbers:
    """What the numbers of one chat stand for."""

    def __init__(self) -> None:
        self.last = 0
        self.shown_ns = 0
        self.offered: dict[int, OfferedButton] = {}

    def next(self, now_ns: int) -> int:
        if self.last >= HIGHEST or now_ns - self.shown_ns > AGAIN_NS:
            self.last = 0
        self.last, self.shown_ns = self.last + 1, now_ns
        return self.last


class NumberedButtons:
    """Numbers the buttons of each chat, and knows what a number stands for.

    Numbers run on from one message to the next, to 99, and begin at 1 again after five minutes
    without new ones: what is typed twice, or a moment too late, is the number of no other button.
    Bounded: the chats that were shown none for longest are forgotten.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._chats: OrderedDict[str, _ChatNumbers] = OrderedDict()

    def label(self, message: object, outbound: Outbound) -> str:
        """Return a text with each row of buttons beneath it: the number and the label of each.

        Args:
            message: Its id, or what stands for it until `called` names that. A message that is
                shown again keeps the numbers of what is the same.
            outbound: What it is to show. Buttons beyond the first 99 are left out.
        """
        chat = self._chats.get(outbound.chat.id)
        if chat is None:
            if not outbound.buttons:
                return outbound.text
            chat = self._chats[outbound.chat.id] = _ChatNumbers()
        self._chats.move_to_end(outbound.chat.id)
        while len(self._chats) > CHATS:
            self._chats.popitem(last=False)
        before = {one.nonce: n for n, one in chat.offered.items() if one.message == message}
        chat.offered = {n: one for n, one in chat.offered.items() if one.message != message}
        left = HIGHEST
        lines = []
        for row in outbound.buttons:
            lines.append(GAP.join(self._number(chat, message, one, before) for one in row[:left]))
            left = max(0, left - len(row))
        below = "\n".join(filter(None, lines))
        return f"{outbound.text}\n\n{below}".strip() if below else outbound.text

    def _number(
        self, chat: _ChatNumbers, message: object, button: Button, before: dict[str, int]
    ) -> str:
        number = before.get(button.nonce) or chat.next(self._clock.monotonic_ns())
        urgent = hears_stop(button.command) is not None
        chat.offered[number] = OfferedButton(message, button.nonce, urgent)
        return f"{number}. {button.label}"

    def called(self, chat: str, before: object, message: str) -> None:
        """Know a message by its id from now on."""
        offered = self._chats[chat].offered if chat in self._chats else {}
        for number, one in offered.items():
            if one.message is before:
                offered[number] = one._replace(message=message)

    def chosen(self, chat: str, signs: Iterable[str], message: str = "") -> OfferedButton | None:
        """Return the button that a number names; None for none, and for more than one.

        Args:
            chat: In which chat.
            signs: Numbers as they were typed, or as emoji.
            message: Beneath this message alone; empty: beneath any.
        """
        numbers = self._chats.get(chat)
        offered = {} if numbers is None else numbers.offered
        named = (offered.get(_number_of(sign)) for sign in signs)
        found = {one for one in named if one is not None and message in {"", one.message}}
        return found.pop() if len(found) == 1 else None


def _number_of(sign: str) -> int:
    """Return the number that a text or an emoji is; 0 for none."""
    digits = "10" if sign == _TEN else sign.strip().replace(_VARIATION, "").removesuffix(_KEYCAP)
    plain = digits.isascii() and digits.isdecimal() and len(digits) <= len(str(HIGHEST))
    return int(digits) if plain else 0


def tapped(inbound: Inbound, chosen: OfferedButton) -> Inbound:
    """Return the message that names a button as a tap on it.

    It is dated when it is received; one that was late is backlog.
    """
    late = inbound.sent_ns < max(inbound.listening_since_ns, inbound.received_ns - LATE_NS)
    return replace(
        inbound,
        text="",
        nonce=chosen.nonce,
        tap=inbound.message,
        under=chosen.message if isinstance(chosen.message, str) else "",
        answers="",
        sent_ns=inbound.received_ns,
        listening_since_ns=inbound.received_ns + 1 if late else inbound.listening_since_ns,
    )
