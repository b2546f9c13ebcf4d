"""The authoriser's modules as the gateway puts them together, over a store in memory."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.authoriser.authoriser import Authoriser
from rosic.authoriser.counters import Counters
from rosic.authoriser.directory import Directory
from rosic.authoriser.enrolment import Enrolment, EnrolmentRules
from rosic.authoriser.enrolment_records import Answer, CodeRedeemed
from rosic.authoriser.guessing import GuessLimits
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.authoriser.keys import KeyRing
from rosic.authoriser.locks import AccountLocks
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.authoriser.security_report import SecurityReports
from rosic.authoriser.two_factor import TwoFactor
from rosic.core.identity import OPERATOR, Address, AuthorisationKey, Principal
from rosic.core.records import Enrolled, Fact, KeyIssued, Letter, PersonRecord
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.invitations import Invitation
    from rosic.core.records import Record

import msgspec

ADA = Address("telegram", "1001")  # the admin
BO = Address("telegram", "1002")  # an admin, too
CY = Address("telegram", "1003")
DI = Address("telegram", "1004")


def account(number: int) -> Address:
    return Address("telegram", str(100_000 + number))


class EnrolmentRooms:
    """Ada and Bo are admins. Whatever is decided is written, then applied, under one lock."""

    def __init__(
        self,
        *,
        limits: GuessLimits | None = None,
        store: MemoryStore | None = None,
        clock: ManualClock | None = None,
        seed: int = 0,
    ) -> None:
        self.clock = clock or ManualClock()
        self.store = store or MemoryStore()
        self.lock = asyncio.Lock()
        entropy = SeededEntropy(seed)
        self.time = MonotonicWallClock(self.clock)
        self.counters = Counters()
        self.locks = AccountLocks(self.time)
        self.directory = Directory()
        self.keys = KeyRing(self.time, entropy, self.counters)
        self.authoriser = Authoriser(self.directory, self.keys, self.clock, entropy)
        self.enrolment = Enrolment(
            self.directory,
            self.locks,
            self.time,
            entropy,
            self.counters,
            EnrolmentRules(lambda _who, _given: True, limits or GuessLimits()),
        )
        self.two_factor = TwoFactor(self.time, entropy, self.counters, place="lab")
        self.security = SecurityReports(
            self.authoriser, self.enrolment, self.keys, self.locks, self.counters, self.time
        )

    async def opened(self) -> EnrolmentRooms:
        await self.store.open()
        return self

    async def with_admins(self) -> EnrolmentRooms:
        await self.opened()
        for principal, name, address in (("ada", "Ada", ADA), ("bo", "Bo", BO)):
            await self.knows(principal, name, address, roles=("admin",))
        return self

    async def knows(
        self, principal: str, name: str, address: Address, *, roles: tuple[str, ...]
    ) -> AuthorisationKey:
        key = AuthorisationKey(
            id=f"k-{principal}",
            principal=principal,
            issuer=OPERATOR,
            issued_ns=self.clock.wall_ns(),
        )
        card = msgspec.msgpack.encode(PersonRecord(name, (address,)))
        enrolled = Enrolled(
            principal=principal, roles=roles, at_ns=1, letter=Letter(principal, card)
        )
        await self.write((enrolled, KeyIssued(key=key)))
        person = Principal(id=principal, name=name, roles=roles, addresses=(address,))
        self.authoriser.enrol(person, key)
        return key

    async def write(self, records: Iterable[Record]) -> None:
        records = tuple(records)
        await self.store.write(*records)
        self.apply(records)

    def apply(self, records: Iterable[Record]) -> None:
        for record in records:
            self.keys.apply(record)
            if isinstance(record, Fact):
                self.apply_fact(record)

    def apply_fact(self, fact: Fact) -> None:
        keepers = {
            "lock": self.locks.apply,
            "totp": self.two_factor.apply,
            "tally": self.counters.apply,
            "high-water": self.time.apply,
            "key-end": self.keys.apply,
        }
        keepers.get(fact.kind, self.enrolment.apply)(fact)

    async def restarted(self) -> EnrolmentRooms:
        """Another run over the same record; the clock goes on."""
        enrolling = EnrolmentRooms(store=self.store, clock=self.clock, seed=99)
        memory = await self.store.open()
        for entry in memory.enrolled:
            card = msgspec.msgpack.decode(entry.letter.content, type=PersonRecord)
            enrolling.directory.enrol(
                Principal(
                    id=entry.principal,
                    name=card.name,
                    roles=entry.roles,
                    addresses=card.addresses,
                )
            )
        for key in memory.keys:
            enrolling.directory.add_key(key)
        enrolling.keys.restore(memory.keys, ())
        for facts in memory.facts.values():
            for fact in facts:
                enrolling.apply_fact(fact)
        return enrolling

    # ---- what people do ----

    async def invite(
        self,
        *roles: str,
        robots: tuple[str, ...] = (),
        lasts_s: float | None = None,
        confirm: bool | None = None,
        by: str = "ada",
    ) -> tuple[str, Invitation]:
        given = InvitedRights(roles=roles or ("operator",), robots=robots, lasts_s=lasts_s)
        wanted = InvitationRequest(given=given, needs_confirmation=confirm)
        async with self.lock:
            offer = self.enrolment.invitations.invite(wanted, by)
            await self.write(offer.records)
        return offer.code.reveal(), offer.invitation

    async def redeem(
        self, code: str, address: Address = CY, *, private: bool = True, name: str = "Cy"
    ) -> Answer:
        async with self.lock:
            answer = self.enrolment.redeem(code, address, private=private, name=name)
            await self.write(answer.records)
            if isinstance(answer, CodeRedeemed):
                self.authoriser.enrol(answer.person, answer.key)
        return answer

    async def confirm(self, pending: str, by: str, *, may_admit: bool = True) -> CodeRedeemed:
        async with self.lock:
            redeemed = self.enrolment.confirm(pending, by, may_admit=may_admit)
            await self.write(redeemed.records)
            self.authoriser.enrol(redeemed.person, redeemed.key)
        return redeemed
