"""The paper's authoriser: AUTHENTICATE and GENERATEKEY of Algorithm 1."""

from __future__ import annotations

from array import array
from base64 import urlsafe_b64encode
from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec

from rosic.authoriser.button_tokens import ButtonTokens
from rosic.core.i18n import said
from rosic.core.identity import Address, AuthorisationKey, Caller, KeyId, Principal, PrincipalId
from rosic.core.message import ChatKind
from rosic.errors import Unrecognised

if TYPE_CHECKING:
    from rosic.authoriser.directory import Directory
    from rosic.authoriser.keys import KeyRing
    from rosic.contracts.clock import Clock, Entropy
    from rosic.core.message import Chat, Inbound

SESSION_BYTES = 16
SESSIONS_AT_MOST = 20_000
TIMES_KEPT = 4_096
STRANGER = said("Hello. I work for people I know, and I do not know you yet. Ask the admin here.")
ENDED = said("Your access here has ended. The admin of this place can renew it.")


class Session(msgspec.Struct, frozen=True):
    """One authenticated conversation: a person, under a key, in a chat.

    Attributes:
        ends_ns: When the key ends by itself, wall clock; None: it does not.
    """

    caller: Caller
    ends_ns: int | None


class Authoriser:
    """Recognises who speaks, by the platform's immutable id and a key that is still good.

    Attributes:
        buttons: What taps stand for.
        directory: Who is known.
        keys: When a key ends by itself, by a clock that never goes back; and the count of messages
            that were turned away.

    Args:
        clock: The machine's, by which buttons live.
    """

    def __init__(self, directory: Directory, keys: KeyRing, clock: Clock, entropy: Entropy) -> None:
        self.directory = directory
        self.keys = keys
        self._count = keys.counters.count
        self._wall_ns = keys.time.wall_ns
        self.buttons = ButtonTokens(clock, entropy, count=self._count_tap)
        self._clock = clock
        self._entropy = entropy
        self._sessions: OrderedDict[tuple[str, str, str], Session] = OrderedDict()
        self._in_chat: dict[tuple[str, str], dict[str, Session]] = {}
        self._times_ns = array("q", bytes(8 * TIMES_KEPT))
        self._timed = 0

    def identify(self, inbound: Inbound) -> Caller:
        """Return who sent this, in this conversation.

        Raises:
            Unrecognised: A stranger, or a key that is revoked or has expired. Nothing changed.
        """
        started_ns = self._clock.monotonic_ns()
        sender, chat = inbound.sender, inbound.chat
        where = (sender.platform, sender.account, chat.id)
        session = self._sessions.get(where)
        if session is None:
            session = self._authenticate(inbound)
            self._sessions[where] = session
            self._in_chat.setdefault((sender.platform, chat.id), {})[sender.account] = session
            if len(self._sessions) > SESSIONS_AT_MOST:
                self._end(next(iter(self._sessions)))
        ends_ns = session.ends_ns
        if ends_ns is not None and self._wall_ns() >= ends_ns:
            self._count("key-expired")
            raise Unrecognised(ENDED)
        timed = self._timed
        self._times_ns[timed % TIMES_KEPT] = self._clock.monotonic_ns() - started_ns
        self._timed = timed + 1
        return session.caller

    def _authenticate(self, inbound: Inbound) -> Session:
        found = self.directory.at(inbound.sender)
        if found is None:
            if _is_for_us(inbound):
                self._count("stranger")
            raise Unrecognised(STRANGER)
        person, key = found
        if key.revoked_ns is not None:
            self._count("key-revoked")
            raise Unrecognised(ENDED)
        caller = Caller(person.id, person.name, inbound.sender, key.id, self._session_key())
        return Session(caller, self.keys.ends_ns(key))

    def knows(self, address: Address) -> bool:
        """Whether somebody here has this account, be it that their access has ended; a look-up."""
        return self.directory.at(address) is not None

    def stand_for(self, principal: PrincipalId) -> Caller:
        """Return somebody as whoever acts now by a rule of theirs, under their present key.

        Raises:
            Unrecognised: Nobody, or their key is revoked or has expired. Nothing changed.
        """
        person, key = self.directory.person(principal), self.directory.key_of(principal)
        if person is None or key is None or not self._is_good(key):
            raise Unrecognised(ENDED)
        address = person.addresses[0] if person.addresses else Address("rule", principal)
        return Caller(person.id, person.name, address, key.id, self._session_key())

    def has_access(self, principal: PrincipalId) -> bool:
        """Whether somebody could speak here now: their key is not revoked and has not ended."""
        key = self.directory.key_of(principal)
        return key is not None and self._is_good(key)

    def _is_good(self, key: AuthorisationKey) -> bool:
        ends_ns = self.keys.ends_ns(key)
        return key.revoked_ns is None and (ends_ns is None or self._wall_ns() < ends_ns)

    def _count_tap(self, kind: str) -> None:
        self._count(kind)

    def _session_key(self) -> str:
        """Return the id of a new session key: a hash, so that no list of them lets anybody in."""
        secret = self._entropy.token(SESSION_BYTES)
        return urlsafe_b64encode(blake2b(secret, digest_size=12).digest()).decode()

    def enrol(self, person: Principal, key: AuthorisationKey) -> None:
        """Make a person known from now on."""
        self.directory.enrol(person)
        self.directory.add_key(key)
        self.forget(person.id)

    def revoke(self, key_id: KeyId) -> PrincipalId | None:
        """End a key: the very next message under it is turned away. Return whose it was."""
        key = self.directory.revoke(key_id, self._wall_ns())
        if key is None:
            return None
        self.forget(key.principal)
        return key.principal

    def forget(self, principal: PrincipalId) -> None:
        """Let somebody be authenticated anew: their key or what is known of them has changed."""
        gone = [w for w, s in self._sessions.items() if s.caller.principal == principal]
        for where in gone:
            self._end(where)

    def _end(self, where: tuple[str, str, str]) -> None:
        del self._sessions[where]
        platform, account, chat = where
        there = self._in_chat[platform, chat]
        del there[account]
        if not there:
            del self._in_chat[platform, chat]

    def company(self, chat: Chat) -> frozenset[PrincipalId]:
        """Return who was recognised in a chat; for a stop that carries nobody's id (I17)."""
        there = self._in_chat.get((chat.platform, chat.id), {})
        return frozenset(session.caller.principal for session in there.values())

    def times_to_authenticate_s(self) -> tuple[float, ...]:
        """Return the newest measured times in seconds, oldest first."""
        first = max(0, self._timed - TIMES_KEPT)
        kept = range(first, self._timed)
        return tuple(self._times_ns[at % TIMES_KEPT] / 1e9 for at in kept)


def _is_for_us(inbound: Inbound) -> bool:
    """Whether somebody unknown tried something; people in groups talk to each other."""
    private = inbound.chat.kind is ChatKind.PRIVATE
    return private or inbound.nonce is not None or inbound.text.startswith("/")
