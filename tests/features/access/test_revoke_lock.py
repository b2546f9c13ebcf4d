"""Revoking, locking and unlocking: whose access ends, what they have in hand, who is told."""

from __future__ import annotations

import asyncio

from rosic.authoriser.invitations import InvitationState
from rosic.core.identity import Address
from rosic.core.policy.roles import Grant
from rosic.core.records import Decided, Fact, KeyRevoked, Record
from rosic.features.access import access_messages, messages
from rosic.gateway.commands import ONLY_IN_PRIVATE
from rosic.gateway.transactions import WRITTEN_WITHIN_S
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import settle
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, BrokenStore, Hall, a_hall
from tests.pace import pace

GONE = "Your access here has ended. The admin of this place can renew it."
LAST = (
    "Ada is the last admin here. Make somebody else an admin first: /grant NAME admin. "
    "Nothing was done."
)
LOCKED = "Cy Young is locked: nothing they send is carried out until an admin unlocks them."
NOT_YOURS = "Locking and unlocking people is for admins. Ada or Bo can. Nothing was done."


class SlowStore(MemoryStore):
    """Its disk hangs while the test wants it to."""

    def __init__(self) -> None:
        super().__init__()
        self.ready = asyncio.Event()
        self.ready.set()

    async def write(self, *records: Record) -> None:
        await self.ready.wait()
        await super().write(*records)


# ---- revoking ----


async def test_revoking_asks_once_and_then_ends_everything() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Di", "tutor", grants=(Grant(id="g1", role="senior"),))
        code = await hall.invited("viewer kuka1", account=DI)
        assert await hall.say(ADA, "/revoke Di") == (
            "End the access of Di (tutor; senior) for good? What they move stops, their times are "
            "free again, and their codes let nobody in any more."
        )
        assert hall.labels(ADA) == ["Revoke", "Leave it"]
        assert hall.directory.has_good_key("p-4")
        assert hall.ended == []

        assert await hall.tap(ADA, "Revoke") == "Di has no access any more."
        assert hall.ended == [("p-4", True)]
        assert hall.last(DI).text == GONE
        assert hall.last(BO).text == "Ada ended the access of Di."
        assert await hall.say(DI, "/me") == GONE
        assert hall.rights.grants("p-4") == ()
        made = hall.enrolment.invitations.find(code)
        assert made is not None
        assert made.state is InvitationState.WITHDRAWN
        assert not any(hall.keys.good(key.id) for key in hall.keys.of("p-4"))
        assert await hall.say(ADA, "/revoke Di") == ("Di has no access any more. Nothing was done.")


async def test_the_times_of_whoever_is_revoked_are_free_again() -> None:
    async with a_hall() as hall:
        calendar, now_ns, hour_ns = hall.organiser.calendar, hall.time.wall_ns(), 3600 * 10**9
        async with hall.changes.turn() as turn:
            await turn.write(calendar.book("p-3", "kuka1", now_ns, 3600, "p-3"))
            await turn.write(calendar.book("p-3", "omni", now_ns + hour_ns, 3600, "p-3"))
            await turn.write(calendar.book("p-2", "omni", now_ns + 3 * hour_ns, 3600, "p-2"))
            await turn.write(hall.access.waiting.join("p-3", "omni"))
        await hall.clock.advance(60)
        await hall.say(ADA, "/revoke Cy Young")
        assert calendar.present("kuka1", hall.time.wall_ns()) is not None
        await hall.tap(ADA, "Revoke")
        assert calendar.present("kuka1", hall.time.wall_ns()) is None
        upcoming = calendar.on("omni", now_ns, now_ns + 10 * hour_ns)
        assert [slot.principal for slot in upcoming] == ["p-2"]
        assert hall.access.waiting.queue("omni") == ()


async def test_leaving_it_leaves_it() -> None:
    async with a_hall() as hall:
        await hall.say(ADA, "/revoke Cy Young")
        assert await hall.tap(ADA, "Leave it") == "Nothing was done."
        assert hall.directory.has_good_key("p-3")


async def test_revoking_is_for_good_over_a_restart() -> None:
    store = MemoryStore()
    async with a_hall(store) as hall:
        await hall.knows(DI, "Di", "operator", grants=(Grant(id="g1", role="senior"),))
        await hall.say(ADA, "/revoke Di")
        await hall.tap(ADA, "Revoke")
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert await again.say(DI, "/me") == GONE
        assert again.rights.grants("p-4") == ()


async def test_whoever_is_revoked_waits_no_longer_for_more() -> None:
    async with a_hall() as hall:
        await hall.say(CY, await hall.invited("senior"))
        await hall.tap(CY, "Join")
        await hall.say(BO, "/revoke Cy Young")
        await hall.tap(BO, "Revoke")
        assert not hall.enrolment.applicants.all()
        await hall.tap(ADA, "Let them in")
        assert not hall.directory.has_good_key("p-3")


async def test_nobody_revokes_the_last_admin() -> None:
    async with a_hall() as hall:
        until_ns = hall.clock.wall_ns() + 3_600_000_000_000
        await hall.knows(DI, "Di", grants=(Grant(id="g", role="admin", expires_ns=until_ns),))
        await hall.say(ADA, "/revoke Bo")
        await hall.say(BO, "/revoke Ada")
        assert await hall.tap(ADA, "Revoke") == "Bo has no access any more."
        # Di is admin for an hour: a place must not be left to that.
        assert await hall.say(DI, "/revoke Ada") == LAST
        assert await hall.say(ADA, "/revoke Ada") == LAST
        assert hall.directory.has_good_key("p-1")
        assert await hall.say(DI, "/lock Ada") != LAST  # which can be undone


async def test_a_question_that_was_asked_before_helps_nobody() -> None:
    async with a_hall() as hall:
        await hall.say(ADA, "/revoke Bo")
        await hall.say(BO, "/revoke Ada")
        await hall.tap(ADA, "Revoke")
        assert await hall.tap(BO, "Revoke") == GONE
        await hall.knows(DI, "Di", "admin")
        await hall.say(ADA, "/revoke Di")
        await hall.say(DI, "/revoke Ada")
        await hall.tap(DI, "Revoke")
        assert await hall.tap(ADA, "Revoke") == GONE
        assert hall.directory.has_good_key("p-4")


async def test_two_admins_who_revoke_each_other_at_once_leave_one() -> None:
    async with a_hall() as hall:
        await hall.say(ADA, "/revoke Bo")
        await hall.say(BO, "/revoke Ada")
        for account in (ADA, BO):
            button, under = hall.button(account, "Revoke")
            hall.chat.tap(button, under=under, account=account)
        await hall.quiet()
        assert [hall.directory.has_good_key(p) for p in ("p-1", "p-2")].count(True) == 1


async def test_the_question_of_earlier_does_not_take_the_last_admin() -> None:
    async with a_hall() as hall:
        until_ns = hall.clock.wall_ns() + 3_600_000_000_000
        await hall.knows(DI, "Di", grants=(Grant(id="g", role="admin", expires_ns=until_ns),))
        await hall.say(DI, "/revoke Ada")
        await hall.say(DI, "/revoke Bo", chat="elsewhere")
        assert await hall.tap(DI, "Revoke", chat="elsewhere") == "Bo has no access any more."
        assert await hall.tap(DI, "Revoke") == LAST
        assert hall.directory.has_good_key("p-1")


async def test_whoever_is_locked_while_they_wait_for_a_turn_does_nothing_more() -> None:
    store = SlowStore()
    async with a_hall(store) as hall:
        await hall.knows(DI, "Di", "admin")
        await hall.say(ED, await hall.invited("senior"))
        await hall.tap(ED, "Join")
        await hall.say(ADA, "/lock Cy Young")
        store.ready.clear()
        hall.chat.say("/invite viewer", account=ADA, chat=ADA)  # holds the turn
        await settle()
        lines = (
            *("/invite viewer", "/invite reopen"),
            *("/approve Ed", "/decline Ed", "/unlock Cy Young"),
            *("/code 123456", "/authenticator reset Cy Young"),
        )
        for number, line in enumerate(lines):
            hall.chat.say(line, account=BO, chat=f"b{number}")
        await hall.quiet()
        before = len(hall.chat.told)
        hall.chat.say("/lock Bo", account=DI, chat=DI)
        await hall.quiet()
        assert hall.locks.locked("p-2")
        store.ready.set()
        await hall.quiet()
        chats = tuple(f"b{number}" for number in range(len(lines)))
        assert {hall.told(chat, before) for chat in chats} == {
            "Your access is locked. Ask an admin."
        }
        assert hall.directory.has_good_key("p-3")
        assert hall.locks.locked("p-3")
        assert len(hall.enrolment.invitations.open()) == 1  # Ada's
        assert hall.enrolment.applicants.all()


async def test_revoking_is_for_admins_in_private() -> None:
    async with a_hall() as hall:
        assert await hall.say(CY, "/revoke Ada") == (
            "Looking after people is for admins. Ada or Bo can. Nothing was done."
        )
        assert await hall.say(CY, "/revoke p-1 confirmed") == (
            "Looking after people is for admins. Ada or Bo can. Nothing was done."
        )
        assert await hall.in_group(ADA, "/revoke Cy Young") == ONLY_IN_PRIVATE
        assert await hall.say(ADA, "/revoke") == access_messages.HOW_TO_REVOKE
        assert hall.ended == []


async def test_revoking_acts_with_the_disk_full() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        await hall.say(ADA, "/revoke Cy Young")
        store.broken = True
        assert await hall.tap(ADA, "Revoke") == (
            "Cy Young has no access any more. I could not write this down: it holds until ROSIC is "
            "restarted. The operator has to look."
        )
        assert hall.ended == [("p-3", True)]
        assert await hall.say(CY, "/me") == GONE


# ---- locking ----


async def test_a_lock_acts_at_once_in_any_chat() -> None:
    async with a_hall() as hall:
        assert await hall.in_group(ADA, "/lock cy young") == LOCKED
        assert hall.ended == [("p-3", True)]
        assert hall.last(BO).text == "Ada locked Cy Young."
        assert not hall.told(CY)  # whoever has the phone is told nothing
        assert await hall.say(CY, "/me") == "Your access is locked. Ask an admin."
        assert await hall.say(ADA, "/lock Cy Young") == LOCKED  # twice is no mistake
        assert await hall.tap(ADA, "Unlock") == "Cy Young is unlocked."
        assert not hall.locks.locked("p-3")


async def test_a_lock_acts_with_the_disk_full_and_comes_back_when_it_was_written() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        store.broken = True
        assert await hall.say(ADA, "/lock Cy Young") == f"{LOCKED} {messages.UNWRITTEN}"
        assert hall.locks.locked("p-3")
        assert hall.ended == [("p-3", True)]
        store.broken = False
        assert await hall.say(ADA, "/lock Cy Young") == LOCKED
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert again.locks.locked("p-3")


async def test_a_lock_waits_for_nobodys_disk() -> None:
    store = SlowStore()
    async with a_hall(store) as hall:
        store.ready.clear()
        hall.chat.say("/invite viewer", account=BO, chat=BO)  # holds the turn
        await settle()
        hall.chat.say("/lock Cy Young", account=ADA, chat=ADA)
        await hall.quiet()
        assert hall.locks.locked("p-3")
        assert await hall.say(CY, "/me") == "Your access is locked. Ask an admin."
        store.ready.set()
        await hall.quiet()
        assert hall.last(ADA).text == LOCKED
        assert hall.ended == [("p-3", True)]


async def test_revoking_waits_for_nobodys_disk_and_is_answered_in_a_second() -> None:
    store = SlowStore()
    async with a_hall(store) as hall:
        code = await hall.invited("viewer")
        made = hall.enrolment.invitations.find(code)
        assert made is not None
        await hall.say(ADA, "/revoke Cy Young")
        store.ready.clear()
        hall.chat.say("/invite viewer", account=BO, chat=BO)  # holds the turn
        await settle()
        button, under = hall.button(ADA, "Revoke")
        hall.chat.tap(button, under=under, account=ADA)
        hall.chat.say(f"/invite back {made.id}", account=ADA, chat="elsewhere")
        await hall.quiet()
        assert not hall.directory.has_good_key("p-3")
        assert made.id not in {one.id for one in hall.enrolment.invitations.open()}
        assert hall.ended == [("p-3", True)]
        assert await hall.say(CY, "/me") == GONE
        await hall.clock.advance(WRITTEN_WITHIN_S)
        await hall.quiet()
        assert hall.last(ADA).text == f"Cy Young has no access any more. {messages.UNWRITTEN}"
        assert hall.told("elsewhere").endswith(messages.UNWRITTEN)
        store.ready.set()
        await hall.quiet()
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert await again.say(CY, "/me") == GONE, "it was written as soon as the disk answered"


async def test_what_is_given_too_late_outlives_no_revoking() -> None:
    """Whoever gives more had looked before it: their write hung meanwhile (I8)."""
    store = SlowStore()
    async with a_hall(store) as hall:
        await hall.say(ADA, "/revoke Cy Young")
        until_ns = hall.clock.wall_ns() + 3_600_000_000_000

        async def give() -> bool:
            async with hall.changes.turn() as turn:
                given = Grant(id="late", role="senior", expires_ns=until_ns)
                await turn.write(
                    (
                        *hall.keys.issue("p-3", "test")[1],
                        *hall.authority.grants_book.give("p-3", (given,), "test"),
                    )
                )
                return hall.directory.has_good_key("p-3")

        store.ready.clear()
        giving = asyncio.create_task(give())
        await settle()
        button, under = hall.button(ADA, "Revoke")
        hall.chat.tap(button, under=under, account=ADA)
        await hall.quiet()
        assert not hall.directory.has_good_key("p-3")
        store.ready.set()
        assert not await asyncio.wait_for(giving, 60 * pace()), "not for a moment"
        await hall.quiet()
        assert hall.rights.grants("p-3") == ()
        assert not any(hall.keys.good(key.id) for key in hall.keys.of("p-3"))
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert await again.say(CY, "/me") == GONE
        assert again.rights.grants("p-3") == ()


async def test_an_unlocking_that_is_written_too_late_undoes_no_later_lock() -> None:
    store = SlowStore()
    async with a_hall(store) as hall:
        await hall.say(ADA, "/lock Cy Young")
        store.ready.clear()
        hall.chat.say("/unlock Cy Young", account=BO, chat=BO)
        await settle()
        hall.chat.say("/lock Cy Young", account=ADA, chat=ADA)
        await hall.quiet()
        store.ready.set()
        await hall.quiet()
        assert hall.locks.locked("p-3")
        assert await hall.say(ADA, "/unlock Cy Young") == "Cy Young is unlocked."
        assert not hall.locks.locked("p-3"), "whoever looks afterwards has seen it"
        await hall.say(ADA, "/lock Cy Young")
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert again.locks.locked("p-3")


async def test_what_is_in_hand_ends_before_the_disk_has_answered() -> None:
    store = SlowStore()
    async with a_hall(store) as hall:
        begun: list[str] = []

        async def begin(principal: str) -> None:
            begun.append(principal)

        hall.revocation_ends(begin)
        await hall.say(ADA, "/revoke Cy Young")
        store.ready.clear()
        button, under = hall.button(ADA, "Revoke")
        hall.chat.tap(button, under=under, account=ADA)
        hall.chat.say("/lock Bo", account=ADA, chat="elsewhere")
        await hall.quiet()
        assert sorted(begun) == ["p-2", "p-3"]
        store.ready.set()
        await hall.quiet()


async def test_anybody_locks_themselves() -> None:
    async with a_hall() as hall:
        assert await hall.say(CY, "/lock me") == access_messages.LOCKED_YOURSELF
        assert hall.last(ADA).text == "Cy Young locked their own access."
        await hall.say(ADA, "/unlock Cy Young")
        assert await hall.say(CY, "/lock Cy Young") == access_messages.LOCKED_YOURSELF
        assert await hall.say(CY, "/unlock me") == "Your access is locked. Ask an admin."


async def test_nobody_locks_the_last_admin_but_they_themselves() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Di", "guard")
        await hall.say(ADA, "/lock Bo")
        assert await hall.say(DI, "/lock Ada") == LAST
        assert await hall.say(ADA, "/lock me") == access_messages.LOCK_LAST
        assert not hall.locks.locked("p-1")
        assert await hall.tap(ADA, "Leave it") == "Nothing was done."
        await hall.say(ADA, "/lock me")
        assert await hall.tap(ADA, "Lock me") == access_messages.LOCKED_YOURSELF
        assert hall.locks.locked("p-1")


async def test_locking_is_for_those_who_may() -> None:
    async with a_hall() as hall:
        for line in ("/lock Ada", "/unlock Ada", "/lock", "/lock Nobody", "/unlock"):
            assert await hall.say(CY, line) == NOT_YOURS, line
        assert await hall.say(ADA, "/lock") == access_messages.HOW_TO_LOCK
        await hall.say(ADA, "/lock Bo")
        assert await hall.say(BO, "/unlock Bo") == "Your access is locked. Ask an admin."
        assert await hall.say(BO, "/lock Ada") == "Your access is locked. Ask an admin."


async def test_a_lock_ends_every_proof_of_a_phone() -> None:
    async with a_hall() as hall:
        chat = hall.chat.say("/me", account=CY, chat=CY).chat
        hall.two_factor._proven.refresh("p-3", chat)
        await hall.say(ADA, "/lock Cy Young")
        await hall.say(ADA, "/unlock Cy Young")
        assert not hall.two_factor.fresh("p-3", chat)


async def test_acts_are_on_record_by_ids_only() -> None:
    written: list[Record] = []

    class Listening(MemoryStore):
        async def write(self, *records: Record) -> None:
            written.extend(records)
            await super().write(*records)

    async with a_hall(Listening()) as hall:
        written.clear()
        await hall.say(ADA, "/lock Cy Young")
        await hall.say(BO, "/unlock Cy Young")
        await hall.say(BO, "/revoke Cy Young")
        await hall.tap(BO, "Revoke")
        acts = [(r.act, r.by, r.about) for r in written if isinstance(r, Decided)]
        assert acts == [
            ("lock", "p-1", "p-3"),
            ("unlock", "p-2", "p-3"),
            ("ungrant", "p-2", "p-3"),
            ("revoke-key", "p-2", "k-3"),
        ]
        assert any(isinstance(r, KeyRevoked) for r in written)
        assert b"Young" not in b"".join(r.body for r in written if isinstance(r, Fact))
        assert hall.directory.at(Address("telegram", CY)) is not None
