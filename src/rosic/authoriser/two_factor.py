"""A second step before dangerous things: the code that a person's phone shows now.

A step-up is good for one person in one chat until an hour has passed without use, and is never
written down. What is written down is the last half minute whose code was used: no code of that
half minute or an earlier one is ever good again.
"""

from __future__ import annotations

import hmac
import logging
from base64 import b32encode
from collections import OrderedDict, deque
from typing import TYPE_CHECKING, Final
from urllib.parse import quote, urlencode

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.contracts.clock import ClockReading, passed_ns, reading
from rosic.core.identity import OPERATOR, PrincipalId
from rosic.core.language.sanitise import fold_word
from rosic.core.message import Chat, ChatKind
from rosic.core.records import Decided, Fact, Letter, Record
from rosic.core.secret import Secret
from rosic.core.time_units import HOUR_NS, MINUTE_NS, SECOND_NS
from rosic.errors import Expired, NotPermitted, NotUnderstood, RecordUnavailable, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.counters import Counters
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy


# ---- totp ----

# Six digits from a shared secret and the time: HOTP (RFC 4226) and TOTP (RFC 6238).

# ---- HOTP (RFC 4226) and TOTP (RFC 6238) ----

STEP_S: Final = 30
STEP_NS: Final = STEP_S * SECOND_NS
DIGITS: Final = 6
SKEW_STEPS: Final = 1  # phones are rarely more than half a minute off
SECRET_BYTES: Final = 20  # RFC 4226 asks for the length of the hash


def new_secret(entropy: Entropy) -> bytes:
    """Return a secret for one person."""
    return entropy.token(SECRET_BYTES)


def hotp(secret: bytes, counter: int, *, digits: int = DIGITS) -> str:
    """Return the code of a counter (RFC 4226, SHA-1, which is what authenticator apps know)."""
    mac = hmac.digest(secret, counter.to_bytes(8, "big"), "sha1")
    start = mac[-1] & 0x0F
    number = int.from_bytes(mac[start : start + 4], "big") & 0x7FFF_FFFF
    return str(number % 10**digits).zfill(digits)


def step_at(wall_ns: int) -> int:
    """Return the number of the half minute in which a wall time lies."""
    return wall_ns // STEP_NS


def matching_steps(secret: bytes, code: str, step: int) -> tuple[int, ...]:
    """Return which steps around the present one have this code, oldest first.

    Every candidate is computed and compared in constant time, whatever the code.
    """
    given = code.encode()
    around = range(max(0, step - SKEW_STEPS), step + SKEW_STEPS + 1)
    found = [(n, hmac.compare_digest(hotp(secret, n).encode(), given)) for n in around]
    return tuple(n for n, same in found if same)


def otpauth_uri(secret: bytes, *, place: str, account: str) -> Secret:
    """Return what an authenticator app reads from a QR code.

    Args:
        secret: Never shown otherwise.
        place: Name of this lab, as the app shows it.
        account: Name of the person, as the app shows it.
    """
    # A colon would move the border between the two names.
    issuer, person = (quote(text.replace(":", " "), safe="") for text in (place, account))
    asked = {
        "secret": b32encode(secret).decode().rstrip("="),
        "issuer": place.replace(":", " "),
        "algorithm": "SHA1",
        "digits": str(DIGITS),
        "period": str(STEP_S),
    }
    return Secret(f"otpauth://totp/{issuer}:{person}?{urlencode(asked, quote_via=quote)}")


def key_to_type(secret: bytes) -> Secret:
    """Return the secret in groups of four letters, for a phone that cannot see the picture."""
    letters = b32encode(secret).decode().rstrip("=")
    return Secret(" ".join(letters[at : at + 4] for at in range(0, len(letters), 4)))


# ---- a person's phone ----


class TotpDevice(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the principal, its letter the secret.

    Attributes:
        last_step: The newest half minute whose code was used.
        since_ns: When it was set up; wall clock.
    """

    last_step: int
    since_ns: int


class TotpSetup(msgspec.Struct, frozen=True):
    """What a phone needs, once, until the first code has come back.

    Attributes:
        uri: For a QR picture.
        key: The same to be typed.
    """

    uri: Secret
    key: Secret

    @property
    def sentence(self) -> str:
        """Return what stands under the picture; it holds the secret."""
        return words.scan(self.key.reveal())


class TotpProof(msgspec.Struct, frozen=True):
    """A right code. It counts as soon as the records are written and applied, by `admit`.

    Attributes:
        sentence: For the person, once it counts.
    """

    principal: PrincipalId
    chat: Chat
    step: int
    records: tuple[Record, ...]
    sentence: str


# ---- two factor ----

IDLE_NS: Final = HOUR_NS
PROVEN_AT_MOST: Final = 20_000


class SecondFactorSessions:
    """Principal and chat to the last use; an idle hour ends it, by either clock."""

    def __init__(self, time: MonotonicWallClock) -> None:
        self._time = time
        self._used: OrderedDict[tuple[PrincipalId, str, str], ClockReading] = OrderedDict()

    def fresh(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether an hour without use has not passed."""
        used = self._used.get((principal, chat.platform, chat.id))
        return used is not None and passed_ns(self._time, used) < IDLE_NS

    def refresh(self, principal: PrincipalId, chat: Chat) -> None:
        """Begin the hour anew. Bounded: those used longest ago go first."""
        where = (principal, chat.platform, chat.id)
        self._used[where] = reading(self._time)
        self._used.move_to_end(where)
        if len(self._used) > PROVEN_AT_MOST:
            self._used.popitem(last=False)

    def end(self, principal: PrincipalId) -> None:
        """Forget somebody in every chat; looks at all of them, which is rare."""
        for where in [where for where in self._used if where[0] == principal]:
            del self._used[where]


# ---- the second step ----

KIND: Final = "totp"
TRIES: Final = 5
TRIES_WITHIN_NS: Final = 15 * MINUTE_NS
SETUP_NS: Final = 10 * MINUTE_NS
SETUPS_AT_MOST: Final = 1_000

_log = logging.getLogger(__name__)


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(TotpDevice).decode


class TwoFactor:
    """Whose phone is set up, which codes are used, and who has proven it lately."""

    def __init__(
        self, time: MonotonicWallClock, entropy: Entropy, counters: Counters, *, place: str
    ) -> None:
        self._time = time
        self._entropy = entropy
        self._counters = counters
        self._place = place
        self._phones: dict[PrincipalId, tuple[TotpDevice, bytes]] = {}
        self._broken: set[PrincipalId] = set()
        # Grows at once when a code is right, so that it is good once even before it is written.
        self._spent: dict[PrincipalId, int] = {}
        self._wrong: dict[PrincipalId, deque[int]] = {}
        self._setups: OrderedDict[PrincipalId, tuple[bytes, ClockReading]] = OrderedDict()
        self._proven = SecondFactorSessions(time)

    # ---- setting up ----

    def is_set_up(self, principal: PrincipalId) -> bool:
        """Whether somebody can be asked for a code."""
        return principal in self._phones

    def begin(self, principal: PrincipalId, name: str, chat: Chat) -> TotpSetup:
        """Return what the phone needs; a new request replaces the one before.

        Raises:
            NotPermitted: Others could read along, or a phone is set up and its code was not given
                here lately: a thief must not put their own phone in its place. Nothing changed.
        """
        if chat.kind is not ChatKind.PRIVATE:
            raise self._counters.refuse("totp-in-group", NotPermitted(words.PRIVATE_ONLY))
        if principal in self._broken:
            raise NotPermitted(words.PHONE_BROKEN)
        if principal in self._phones and not self.fresh(principal, chat):
            raise NotPermitted(words.PROVE_FIRST)
        secret = new_secret(self._entropy)
        self._setups[principal] = (secret, reading(self._time))
        self._setups.move_to_end(principal)
        if len(self._setups) > SETUPS_AT_MOST:
            self._setups.popitem(last=False)
        uri = otpauth_uri(secret, place=self._place, account=name)
        return TotpSetup(uri, key_to_type(secret))

    def finish(self, principal: PrincipalId, chat: Chat, code: str) -> TotpProof:
        """Return what sets a phone up, if it shows the right code.

        Raises:
            Expired: Nothing was begun, or too long ago.
            Refusal: As `prove`.
        """
        if chat.kind is not ChatKind.PRIVATE:
            raise NotPermitted(words.PRIVATE_ONLY)
        begun = self._setups.get(principal)
        if begun is None or passed_ns(self._time, begun[1]) > SETUP_NS:
            raise Expired(words.SET_UP_FIRST)
        step = self._checked(principal, begun[0], code)
        del self._setups[principal]
        phone = TotpDevice(step, self._time.wall_ns())
        return self._proof(principal, chat, phone, begun[0], act="set-up-phone")

    def is_setting_up(self, principal: PrincipalId) -> bool:
        """Whether six digits from somebody would finish a set-up."""
        begun = self._setups.get(principal)
        return begun is not None and passed_ns(self._time, begun[1]) <= SETUP_NS

    def reset(self, principal: PrincipalId, by: PrincipalId) -> tuple[Record, ...]:
        """Return what forgets somebody's phone: it was lost, or cannot be read.

        Raises:
            NotPermitted: Nobody resets their own. Nothing changed.
            NotUnderstood: There is none. Nothing changed.
        """
        if by == principal and by != OPERATOR:
            raise NotPermitted(words.OWN_RESET)
        if principal not in self._phones and principal not in self._broken:
            raise NotUnderstood(words.NOTHING_TO_RESET)
        now_ns = self._time.wall_ns()
        decided = Decided(act="reset-phone", by=by, about=principal, at_ns=now_ns)
        return (decided, Fact(kind=KIND, key=principal, body=b""))

    # ---- proving ----

    def prove(self, principal: PrincipalId, chat: Chat, code: str) -> TotpProof:
        """Return what a right code is worth. The code is used up from now on, whatever follows.

        Raises:
            NotPermitted: No phone is set up, or the code is wrong or was used.
            NotUnderstood: Not six digits; this is no try.
            TooManyRequests: Five wrong codes within 15 minutes. Not even a right one helps.
        """
        found = self._phones.get(principal)
        if found is None:
            raise NotPermitted(
                words.PHONE_BROKEN if principal in self._broken else words.NOT_SET_UP
            )
        phone, secret = found
        step = self._checked(principal, secret, code)
        used = msgspec.structs.replace(phone, last_step=step)
        return self._proof(principal, chat, used, secret, act="step-up")

    def admit(self, proof: TotpProof) -> None:
        """Let a proof count, after its records were written and applied.

        Raises:
            RecordUnavailable: They were not. The code is used up all the same.
        """
        found = self._phones.get(proof.principal)
        if found is None or found[0].last_step < proof.step:
            raise RecordUnavailable(words.CODE_NOT_WRITTEN)
        self._wrong.pop(proof.principal, None)
        self._proven.refresh(proof.principal, proof.chat)

    def _checked(self, principal: PrincipalId, secret: bytes, code: str) -> int:
        """Return the step whose code this is; count what is not right."""
        digits = "".join(fold_word(word) for word in code[:32].split())
        if not (len(digits) == DIGITS and digits.isascii() and digits.isdigit()):
            raise NotUnderstood(words.NOT_A_CODE)
        wait_s = self._pause_s(principal)
        if wait_s > 0:
            sentence = words.too_many_codes(wait_s)
            refusal = TooManyRequests(sentence, retry_after_s=wait_s)
            raise self._counters.refuse("totp-paused", refusal)
        steps = matching_steps(secret, digits, step_at(self._time.wall_ns()))
        unused = [step for step in steps if step > self._last_step(principal)]
        if unused:
            self._spent[principal] = unused[-1]
            return unused[-1]
        self._wrong.setdefault(principal, deque(maxlen=TRIES)).append(self._time.monotonic_ns())
        if steps:
            raise self._counters.refuse("totp-replayed", NotPermitted(words.USED_CODE))
        raise self._counters.refuse("totp-wrong", NotPermitted(words.WRONG_CODE))

    def _last_step(self, principal: PrincipalId) -> int:
        found = self._phones.get(principal)
        written = -1 if found is None else found[0].last_step
        return max(written, self._spent.get(principal, -1))

    def _pause_s(self, principal: PrincipalId) -> float:
        wrong = self._wrong.get(principal)
        if wrong is None or len(wrong) < TRIES:
            return 0.0
        return max(0, wrong[0] + TRIES_WITHIN_NS - self._time.monotonic_ns()) / 1e9

    def _proof(
        self, principal: PrincipalId, chat: Chat, phone: TotpDevice, secret: bytes, *, act: str
    ) -> TotpProof:
        fact = Fact(kind=KIND, key=principal, body=_encode(phone), letter=Letter(principal, secret))
        now_ns = self._time.wall_ns()
        decided = Decided(act=act, by=principal, about=principal, at_ns=now_ns)
        sentence = words.CODE_TAKEN if act == "step-up" else words.PHONE_READY
        return TotpProof(principal, chat, phone.last_step, (decided, fact), sentence)

    # ---- asking ----

    def fresh(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether somebody has proven it in this chat, and an hour without use has not passed."""
        return self._proven.fresh(principal, chat)

    def use(self, principal: PrincipalId, chat: Chat) -> None:
        """Let a dangerous thing pass; its use keeps the step-up good for another hour.

        Raises:
            NotPermitted: A code has to be given first, or a phone set up.
        """
        if not self._proven.fresh(principal, chat):
            raise NotPermitted(words.ASK_CODE if principal in self._phones else words.NOT_SET_UP)
        self._proven.refresh(principal, chat)

    def end(self, principal: PrincipalId) -> None:
        """End every step-up of somebody: locked, revoked, another key."""
        self._proven.end(principal)
        self._setups.pop(principal, None)

    # ---- state ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. A phone that cannot be read blocks, until an admin resets it."""
        principal = fact.key
        self._phones.pop(principal, None)
        self._broken.discard(principal)
        if not fact.body:
            self.end(principal)
            self._spent.pop(principal, None)
            self._wrong.pop(principal, None)
            return
        try:
            phone = _decode(fact.body)
        except msgspec.MsgspecError:
            _log.warning("a phone's entry cannot be read; an admin has to reset it")
            self._broken.add(principal)
            return
        if fact.letter is None:
            _log.warning("a phone's secret cannot be read; an admin has to reset it")
            self._broken.add(principal)
            return
        self._phones[principal] = (phone, fact.letter.content)
