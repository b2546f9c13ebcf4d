"""One person, several accounts: a code from one chat makes another account theirs as well.

A code is good once, for minutes, and is kept in memory as a digest: a restart voids it. Whoever
hands it in has to be nobody: an account that is somebody's already stays theirs, also where their
access has ended, as nobody gets round a revocation by becoming somebody else. What an account may
do is what its person may: nothing here gives or takes a right.
"""

from __future__ import annotations

from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import link_messages as words
from rosic.authoriser.invite_codes import codes_in, new_code, normal, reads_as_stop
from rosic.core.identity import DIGEST_BYTES, Address, Principal, PrincipalId
from rosic.core.records import Decided, Enrolled, Letter, PersonRecord, Record
from rosic.core.time_units import MINUTE_NS
from rosic.errors import NotPermitted, NotUnderstood

if TYPE_CHECKING:
    from rosic.authoriser.authoriser import Authoriser
    from rosic.authoriser.page_sessions import PageSessions
    from rosic.contracts.clock import Entropy
    from rosic.core.identity import Caller
    from rosic.core.secret import Secret
    from rosic.errors import Refusal

CODE_NS: Final = 10 * MINUTE_NS
CODES_AT_MOST: Final = 1_000
ACCOUNTS_AT_MOST: Final = 8
"""Of one person. Whoever is told something everywhere is told it so often."""

_encode_record = msgspec.msgpack.Encoder().encode


class LinkCode(msgspec.Struct, frozen=True):
    """What somebody was given in one chat, to say it in another.

    Attributes:
        address: From which account it was asked for.
        ends_ns: By the clock that never goes back.
    """

    principal: PrincipalId
    address: Address
    ends_ns: int


class AccountChange(msgspec.Struct, frozen=True):
    """A person's accounts, as soon as the records are written.

    Attributes:
        person: As they are known from then on.
        address: What came or went.
        records: To be written together.
    """

    person: Principal
    address: Address
    records: tuple[Record, ...]


class AccountLinks:
    """Codes that link accounts, and the records of linking and unlinking. Changes nothing itself.

    Args:
        page_sessions: End with an account: they may have been begun from it.
    """

    def __init__(
        self,
        authoriser: Authoriser,
        page_sessions: PageSessions,
        entropy: Entropy,
    ) -> None:
        self._authoriser, self._directory = authoriser, authoriser.directory
        self._page_sessions, self._entropy = page_sessions, entropy
        self._time, self._counters = authoriser.keys.time, authoriser.keys.counters
        self._codes: OrderedDict[bytes, LinkCode] = OrderedDict()

    # ---- codes ----

    def offer(self, caller: Caller) -> Secret:
        """Return a code for somebody who asks for it in their own chat; an earlier one is void.

        Raises:
            NotPermitted: They speak from no account of a messenger, such as a program or a page;
                or they have as many accounts as anybody may have.
        """
        person = self._directory.person(caller.principal)
        if person is None or caller.address not in person.addresses or caller.is_program:
            raise NotPermitted(words.NO_ACCOUNT)
        if len(person.addresses) >= ACCOUNTS_AT_MOST:
            raise NotPermitted(words.too_many(ACCOUNTS_AT_MOST))
        self.void(person.id)
        code = new_code(self._entropy)
        while reads_as_stop(code):
            code = new_code(self._entropy)
        ends_ns = self._time.wall_ns() + CODE_NS
        key = _digest(code.reveal().replace("-", ""))
        self._codes[key] = LinkCode(person.id, caller.address, ends_ns)
        if len(self._codes) > CODES_AT_MOST:
            self._codes.popitem(last=False)
        return code

    def void(self, principal: PrincipalId) -> None:
        """Let somebody's code be good no more, as when they are locked."""
        for digest in [d for d, code in self._codes.items() if code.principal == principal]:
            del self._codes[digest]

    def shown_in(self, text: str) -> tuple[str, ...]:
        """Return the good codes that a text shows, however they are written there."""
        if not self._codes:
            return ()
        return tuple(code for code in codes_in(text) if self.find(code) is not None)

    def find(self, code: str) -> LinkCode | None:
        """Return whose code that is, without using it up; None where it is not good."""
        found = self._codes.get(_digest(normal(code) or ""))
        if found is None or found.ends_ns <= self._time.wall_ns():
            return None
        return found if self._authoriser.has_access(found.principal) else None

    def burn(self, code: str) -> LinkCode | None:
        """Let a code be good no more that others have read; return whose it was."""
        found = self.find(code)
        if found is not None:
            self.void(found.principal)
            self._counters.count("link-in-group")
        return found

    # ---- accounts ----

    def redeem(self, code: str, address: Address) -> AccountChange:
        """Return what makes an account that nobody has one more of whoever was given the code.

        Args:
            code: Good; `find` has returned it in this very step.
            address: Who hands it in, in a private chat.

        Raises:
            NotPermitted: The account is somebody else's, and the code is void; or it is their own,
                or they have as many as anybody may have, and it stays good.
        """
        found = self.find(code)
        if found is None:
            raise NotPermitted(words.NO_CODE)
        person = self._directory.person(found.principal)
        known = self._directory.at(address)
        if known is not None and known[0].id == found.principal:
            raise self._refuse("link-own", words.OWN)
        if person is not None and len(person.addresses) >= ACCOUNTS_AT_MOST:
            raise NotPermitted(words.too_many(ACCOUNTS_AT_MOST))
        self.void(found.principal)
        if person is None or known is not None:
            raise self._refuse("link-taken", words.TAKEN)
        after = msgspec.structs.replace(person, addresses=(*person.addresses, address))
        return self._change("link", after, address, person.id)

    def check(self, principal: PrincipalId, address: Address) -> Principal:
        """Return somebody from whom an account can be taken away.

        Raises:
            NotUnderstood: It is none of theirs.
            NotPermitted: It is their last one: then it is their access that has to end.
        """
        person = self._directory.person(principal)
        if person is None or address not in person.addresses:
            raise NotUnderstood(words.NOT_THEIRS)
        if len(person.addresses) == 1:
            raise NotPermitted(words.LAST)
        return person

    def unlink(self, principal: PrincipalId, address: Address, by: PrincipalId) -> AccountChange:
        """Return what takes an account away from somebody, with every session of theirs.

        Raises:
            NotUnderstood, NotPermitted: As `check` says.
        """
        person = self.check(principal, address)
        left = tuple(one for one in person.addresses if one != address)
        self.void(principal)
        after = msgspec.structs.replace(person, addresses=left)
        change = self._change("unlink", after, address, by)
        sessions = self._page_sessions.end_all(principal)
        return msgspec.structs.replace(change, records=(*change.records, *sessions))

    def has(self, principal: PrincipalId, address: Address) -> bool:
        """Whether an account is one of somebody's."""
        person = self._directory.person(principal)
        return person is not None and address in person.addresses

    def _change(
        self, act: str, after: Principal, address: Address, by: PrincipalId
    ) -> AccountChange:
        now_ns, record = self._time.wall_ns(), PersonRecord(after.name, after.addresses)
        letter = Letter(after.id, _encode_record(record))
        body = blake2b(letter.content, digest_size=DIGEST_BYTES).digest()
        decided = Decided(act=act, by=by, about=after.id, at_ns=now_ns, digest=body)
        enrolled = Enrolled(principal=after.id, roles=after.roles, at_ns=now_ns, letter=letter)
        return AccountChange(after, address, (decided, enrolled))

    def _refuse(self, kind: str, sentence: str) -> Refusal:
        return self._counters.refuse(kind, NotPermitted(sentence))


def _digest(text: str) -> bytes:
    return blake2b(text.encode(errors="replace"), digest_size=32, person=b"rosic-link").digest()
