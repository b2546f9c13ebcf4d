"""What a tap stands for: a nonce bound to a person, a chat, a content and a time (I16)."""

from __future__ import annotations

from base64 import urlsafe_b64encode
from collections import OrderedDict
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import msgspec

from rosic.contracts.clock import ClockReading, passed_ns, reading
from rosic.core.i18n import said
from rosic.core.identity import CommandId, PrincipalId
from rosic.core.language.cancel_detection import hears_cancel
from rosic.core.message import Button
from rosic.core.time_units import MINUTE_NS
from rosic.errors import Expired, NotPermitted

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock, Entropy
    from rosic.core.message import Inbound

Count: TypeAlias = Callable[[str], None]

ANYBODY: Final[PrincipalId] = ""
NONCE_BYTES = 16
LIFETIME_NS = MINUTE_NS
# A stop must work from any button that was ever shown, so its button carries the word itself:
# whoever taps it has typed it.
STOP_PREFIX = "stop "
CANCEL_PREFIX = "cancel "
# A menu moves nothing, so whoever reads before they tap may be late.
MENU = ("?", "use ", "/use ", "robots", "undo ", "help ")
MENU_LIFETIME_NS = 10 * MINUTE_NS
# A button that moves nothing, whoever taps it and whenever, carries what it says after this sign,
# which no nonce has. Whoever taps it has asked for it: nothing is remembered of it, and it is good
# for as long as it is shown.
OPEN = "="
OPENS = ("?", "use ", "help ", "/picture ", "/map ", "/chart ", "/trajectory ")
OPEN_WHOLE = ("robots", "again")
# So much a button carries through the messenger that takes least.
CARRIED_BYTES = 64


# Of one person: whatever somebody is asked, be it by others' doing, voids nobody else's buttons.
EACH_AT_MOST: Final = 400
# And so many whatever their age: whoever taps one that is too old is offered to ask again.
EACH_AT_LEAST: Final = 40


class RedeemedButton(NamedTuple):
    """What a tap says.

    Attributes:
        command: As if typed.
        act: Digest of what it agrees to; empty: it agrees to nothing.
        shown_ns: When the button was shown, wall clock. What happened since, its tapper was not
            shown by it.
        asked: Identity of the command that it confirms; empty: of none.
    """

    command: str
    act: bytes
    shown_ns: int
    asked: CommandId = b""


class _Bound(msgspec.Struct, frozen=True):
    principal: PrincipalId
    chat: str
    command: str
    act: bytes
    asked: CommandId
    issued: ClockReading
    lifetime_ns: int
    still: bool


class ButtonTokens:
    """Issues and redeems nonces. Bounded, each person for themselves: the oldest buttons die first.

    Args:
        at_most: Buttons that are good at a time, of all people together.
        count: Hears of each tap that was refused, by kind.
    """

    def __init__(
        self,
        clock: Clock,
        entropy: Entropy,
        *,
        count: Count,
        at_most: int = 20_000,
    ) -> None:
        self._count = count
        self._clock = clock
        self._entropy = entropy
        self._at_most = at_most
        self._bound: OrderedDict[str, _Bound] = OrderedDict()
        self._own: dict[PrincipalId, OrderedDict[str, None]] = {}

    def issue(
        self,
        button: Button,
        principal: PrincipalId,
        chat: str,
        *,
        lifetime_ns: int = LIFETIME_NS,
        still: bool = False,
    ) -> Button:
        """Return the button with a nonce for this person in this chat.

        Args:
            button: What it says.
            principal: Who alone may tap it; `ANYBODY` in that chat, as often as they like: only
                for what is checked anew with each tap, and has its effect once.
            chat: Where.
            lifetime_ns: Only a button that moves nothing may live longer than a minute: an
                admin's answer to whoever wants to come in. What the button says itself counts
                more.
            still: Nothing moves by it, and nothing will move because of it alone: it is good
                after a gap in listening too, for as long as it lives, once.
        """
        if is_stop(button):
            return msgspec.structs.replace(button, nonce=button.command)
        lifetime_ns = button.good_for_ns or max(lifetime_ns, lifetime_of(button))
        nonce = urlsafe_b64encode(self._entropy.token(NONCE_BYTES)).rstrip(b"=").decode()
        self._bound[nonce] = _Bound(
            principal,
            chat,
            button.command,
            button.act,
            button.asked,
            reading(self._clock),
            lifetime_ns,
            still,
        )
        if principal != ANYBODY:
            own = self._own.setdefault(principal, OrderedDict())
            own[nonce] = None
            self._shorten(own)
        if len(self._bound) > self._at_most:
            self._drop(next(iter(self._bound)))
        return msgspec.structs.replace(button, nonce=nonce, good_for_ns=lifetime_ns)

    def _shorten(self, own: OrderedDict[str, None]) -> None:
        """Forget somebody's oldest buttons: what is too many, and what is good no more."""
        while len(own) > EACH_AT_LEAST:
            oldest = next(iter(own))
            if len(own) <= EACH_AT_MOST and not self._is_old(self._bound[oldest]):
                return
            self._drop(oldest)

    def _is_old(self, bound: _Bound) -> bool:
        return passed_ns(self._clock, bound.issued) > bound.lifetime_ns

    def _drop(self, nonce: str) -> None:
        self._disown(nonce, self._bound.pop(nonce).principal)

    def _disown(self, nonce: str, principal: PrincipalId) -> None:
        own = self._own.get(principal)
        if own is not None:
            own.pop(nonce, None)
            if not own:
                del self._own[principal]

    def void(self, principal: PrincipalId, begins: str) -> int:
        """Let somebody's buttons be no good any more whose command begins so; return how many."""
        gone = [
            nonce
            for nonce, bound in self._bound.items()
            if bound.principal == principal and bound.command.startswith(begins)
        ]
        for nonce in gone:
            self._drop(nonce)
        return len(gone)

    def asked(self, nonce: str) -> PrincipalId | None:
        """Return whom a button was shown that nobody has used so far; None: that is not known."""
        bound = self._bound.get(nonce)
        return None if bound is None or bound.principal == ANYBODY else bound.principal

    def says(self, nonce: str) -> str | None:
        """Return what a button says, and leave it as good as it is; None: that is not known."""
        bound = self._bound.get(nonce)
        if bound is not None:
            return bound.command
        return nonce[1:] if nonce.startswith(OPEN) else None

    def redeem(self, nonce: str, principal: PrincipalId, inbound: Inbound) -> RedeemedButton:
        """Return what the tap says and agrees to, and void the button.

        A tap by another person does not use the button up.

        Raises:
            NotPermitted: The button was shown to somebody else.
            Expired: Too old, used already, or shown before a gap in listening.
        """
        if nonce.startswith(OPEN) and is_open(nonce[1:]):
            return RedeemedButton(nonce[1:], b"", 0)
        bound = self._bound.get(nonce)
        if bound is None:
            self._count("button-used")
            raise Expired(said("This button is no longer good. Nothing was done."))
        if bound.principal not in {principal, ANYBODY} or bound.chat != inbound.chat.id:
            self._count("button-other")
            raise NotPermitted(said("This question was asked of somebody else."))
        if bound.principal != ANYBODY:
            del self._bound[nonce]
        self._disown(nonce, bound.principal)
        missed = bound.issued.wall_ns < inbound.listening_since_ns and not bound.still
        if missed or self._is_old(bound):
            self._count("button-late")
            raise Expired(
                said("This button is too old. Nothing was done."),
                offers=(bound.command.lstrip("?"),),
            )
        return RedeemedButton(bound.command, bound.act, bound.issued.wall_ns, bound.asked)


def open_button(label: str, command: str) -> Button | None:
    """Return a button that is bound to nobody, as it moves nothing; None if it cannot be carried.

    Whoever taps it is taken to have asked for it there and then, with their own rights.
    """
    nonce = f"{OPEN}{command}"
    if not is_open(command) or len(nonce.encode()) > CARRIED_BYTES:
        return None
    return Button(label, command, nonce)


def is_open(command: str) -> bool:
    """Whether a command moves and changes nothing, so that its button need not be anybody's."""
    return command.isprintable() and (command in OPEN_WHOLE or command.startswith(OPENS))


def is_lasting(button: Button) -> bool:
    """Whether a button is good for as long as it is shown."""
    return is_stop(button) or button.nonce.startswith(OPEN)


def lifetime_of(button: Button) -> int:
    """Return for how long a button is good at least, in nanoseconds."""
    if button.good_for_ns:
        return button.good_for_ns
    return MENU_LIFETIME_NS if button.command.startswith(MENU) else LIFETIME_NS


def is_stop(button: Button) -> bool:
    """Whether it stops, and so is good for ever and for everybody; or ends what the tapper does."""
    command = button.command
    if command.startswith(CANCEL_PREFIX):
        return hears_cancel(command) is not None  # and not that of a booking
    return command == "stop" or command.startswith(STOP_PREFIX)
