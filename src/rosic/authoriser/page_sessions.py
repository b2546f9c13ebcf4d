"""Sessions of people on the page: begun by a code from their own chat, short, gone with the person.

A code is good once, for minutes, and for whoever asked for it in their own private chat. What a
browser shows afterwards is a token of 256 bits; a digest of it is kept, so that a restart ends
nobody's session and no list of sessions lets anybody in.
"""

from __future__ import annotations

from base64 import urlsafe_b64encode
from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser.invite_codes import codes_in, new_code, normal, reads_as_stop
from rosic.core.i18n import said
from rosic.core.identity import PAGE, RECORD_ID_BYTES, Address, PrincipalId
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.records import Fact
from rosic.core.secret import Secret
from rosic.core.time_units import HOUR_NS, MINUTE_NS
from rosic.errors import TooManyRequests, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.authoriser.counters import Counters
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy

KIND: Final = "page-session"
TOKEN_BYTES: Final = 32
CODE_NS: Final = 5 * MINUTE_NS
SESSION_NS: Final = 12 * HOUR_NS
CODES_AT_MOST: Final = 1_000
SESSIONS_EACH: Final = 8
"""Of one person at a time: the oldest gives way."""
GUESSES: Final = RateLimit(burst=10.0, per_s=0.1)
PLACES_AT_MOST: Final = 10_000
"""From which wrong codes are counted. A code has 40 bits: 10,000 places that guess as fast as they
may for its five minutes find it with a chance of one in 2.7 million."""
"""Wrong codes of everybody together: 40 bits withstand so many for longer than a code is good."""

NO_CODE: Final = said(
    "That code is not good, or not any more. Ask for a new one in your chat: /signin"
)
GUESSED: Final = said("Too many wrong codes came here. Wait a little, then try again.")
SIGN_IN: Final = said("Sign in first: write /signin in your own chat.")

_encode = msgspec.msgpack.Encoder().encode


class PageSession(msgspec.Struct, frozen=True):
    """One browser of one person.

    Attributes:
        digest: Of the token that the browser shows.
        ends_ns: By the clock that never goes back.
    """

    principal: PrincipalId
    digest: bytes
    begun_ns: int
    ends_ns: int


class OneTimeCode(msgspec.Struct, frozen=True):
    """What somebody was given in their chat to sign in with."""

    principal: PrincipalId
    ends_ns: int


_decode = msgspec.msgpack.Decoder(PageSession).decode


class PageSessions:
    """Who is signed in on the page, and who may sign in now.

    Args:
        time: By which codes and sessions end; never goes back.
        entropy: Makes codes and tokens.
        counters: Counts whoever is turned away.
        has_access: Whether somebody could speak here now.
    """

    def __init__(
        self,
        time: MonotonicWallClock,
        entropy: Entropy,
        counters: Counters,
        has_access: Callable[[PrincipalId], bool],
    ) -> None:
        self._time, self._entropy, self._counters = time, entropy, counters
        self._has_access = has_access
        self._codes: OrderedDict[bytes, OneTimeCode] = OrderedDict()
        self._sessions: dict[str, PageSession] = {}
        self._by_digest: dict[bytes, str] = {}
        self._guesses: dict[str, Bucket] = {}

    # ---- signing in ----

    def offer(self, principal: PrincipalId) -> Secret:
        """Return a code for somebody who asks for it in their own chat; an earlier one is void."""
        for digest in [d for d, code in self._codes.items() if code.principal == principal]:
            del self._codes[digest]
        code = new_code(self._entropy)
        while reads_as_stop(code):
            code = new_code(self._entropy)
        ends_ns = self._time.wall_ns() + CODE_NS
        self._codes[_digest(code.reveal().replace("-", ""))] = OneTimeCode(principal, ends_ns)
        if len(self._codes) > CODES_AT_MOST:
            self._codes.popitem(last=False)
        return code

    def shown_in(self, text: str) -> tuple[str, ...]:
        """Return the good codes that a text shows: none of them is kept anywhere."""
        if not self._codes:
            return ()
        return tuple(code for code in codes_in(text) if _digest(code) in self._codes)

    def redeem(self, text: str, place: str) -> tuple[Secret, Fact]:
        """Return the token of a new session, and what makes it one; the code is used up.

        Args:
            text: As somebody has typed it.
            place: From which network it came: who guesses there keeps nobody elsewhere waiting.

        Raises:
            Unrecognised: The code is not good. It is counted.
            TooManyRequests: Too many codes from there were wrong. This one was not looked at.
        """
        now_ns, guesses = self._time.monotonic_ns(), self._guesses.pop(place, None)
        guesses = self._guesses[place] = guesses or Bucket(GUESSES, now_ns)
        if len(self._guesses) > PLACES_AT_MOST:
            del self._guesses[next(iter(self._guesses))]
        if (wait_s := guesses.wait_s(now_ns, 1.0)) > 0:
            raise TooManyRequests(GUESSED, retry_after_s=wait_s, own=False)
        code = self._codes.pop(_digest(normal(text) or ""), None)
        if code is None or code.ends_ns <= self._time.wall_ns():
            guesses.take(now_ns)
            raise self._counters.refuse("page-code", Unrecognised(NO_CODE))
        return self.begin(code.principal)

    def begin(self, principal: PrincipalId) -> tuple[Secret, Fact]:
        """Return the token of a new session of somebody who has shown who they are.

        Raises:
            Unrecognised: They have no access here any more.
        """
        if not self._has_access(principal):
            raise self._counters.refuse("page-code", Unrecognised(NO_CODE))
        random = urlsafe_b64encode(self._entropy.token(TOKEN_BYTES)).decode().rstrip("=")
        token = Secret(random)
        now_ns = self._time.wall_ns()
        session = PageSession(principal, _digest(random), now_ns, now_ns + SESSION_NS)
        key = f"s{self._entropy.token(RECORD_ID_BYTES).hex()}"
        return token, Fact(kind=KIND, key=key, body=_encode(session))

    # ---- sessions ----

    def identify(self, token: Secret) -> Address:
        """Return the address from which whoever shows a token speaks.

        Raises:
            Unrecognised: It is no token of a session, it has ended, or so has the person's access.
        """
        session = self._sessions.get(self._by_digest.get(_digest(token.reveal()), ""))
        if session is None or session.ends_ns <= self._time.wall_ns():
            raise self._counters.refuse("page-session", Unrecognised(SIGN_IN))
        if not self._has_access(session.principal):
            raise self._counters.refuse("page-session", Unrecognised(SIGN_IN))
        return Address(PAGE, session.principal)

    def end(self, token: Secret) -> tuple[Fact, ...]:
        """Return what ends the session of a token; nothing where there is none."""
        key = self._by_digest.get(_digest(token.reveal()))
        return () if key is None else (Fact(kind=KIND, key=key, body=b""),)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends every session of somebody, and void their code at once."""
        for digest in [d for d, code in self._codes.items() if code.principal == principal]:
            del self._codes[digest]
        return tuple(
            Fact(kind=KIND, key=key, body=b"")
            for key, session in self._sessions.items()
            if session.principal == principal
        )

    def of(self, principal: PrincipalId) -> tuple[PageSession, ...]:
        """Return the sessions of somebody that have not ended."""
        now_ns = self._time.wall_ns()
        return tuple(
            session
            for session in self._sessions.values()
            if session.principal == principal and session.ends_ns > now_ns
        )

    def due(self) -> tuple[Fact, ...]:
        """Return what lets go of sessions that are over, and of the oldest that are too many."""
        now_ns, kept = self._time.wall_ns(), dict[PrincipalId, int]()
        over = []
        for key, session in reversed(self._sessions.items()):
            kept[session.principal] = kept.get(session.principal, 0) + 1
            if session.ends_ns <= now_ns or kept[session.principal] > SESSIONS_EACH:
                over.append(Fact(kind=KIND, key=key, body=b""))
        return tuple(over)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so."""
        before = self._sessions.pop(fact.key, None)
        if before is not None:
            self._by_digest.pop(before.digest, None)
        if fact.body:
            session = _decode(fact.body)
            self._sessions[fact.key] = session
            self._by_digest[session.digest] = fact.key


def _digest(text: str) -> bytes:
    return blake2b(text.encode(errors="replace"), digest_size=32, person=b"rosic-page").digest()
