"""One person by several accounts: what is theirs is one, whichever account they speak from."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.admin.api import books_of
from rosic.app.people import ConfiguredPerson
from rosic.authoriser import link_messages as words
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind
from rosic.core.policy.roles import Assurance, RoleRules, SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.gateway.delivery.last_accounts import KIND as LAST_ACCOUNTS
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, VI, Place
from tests.gateway.test_rights import rules

if TYPE_CHECKING:
    from rosic.testing.clock import ManualClock

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
BO_TOO = "22"
SECOND = SkillPrecondition(scopes=("omni:wave",), second_person=True)


class OtherMessenger(MemoryMessenger):
    """A messenger of another platform, which can lose its connection."""

    def __init__(self, clock: ManualClock) -> None:
        super().__init__("other", clock=clock)
        self.platform, self.assurance, self.connected = "other", "e2ee-verified", True

    def is_connected(self) -> bool:
        """Return what the test says."""
        return self.connected


class TwoMessengers(Place):
    """A place with a second messenger, where Bo has an account as well."""

    besides = (OtherMessenger,)

    def __init__(
        self,
        store: MemoryStore | None = None,
        *,
        rulebook: RoleRules | None = None,
        limit: RateLimit | None = None,
    ) -> None:
        super().__init__(store, limit=limit)
        if rulebook is not None:
            self.gateway._settings = replace(self._settings, rulebook=rulebook)

    @property
    def other(self) -> OtherMessenger:
        """Return the second messenger."""
        [_, found] = self.gateway._parts.messengers
        assert isinstance(found, OtherMessenger)
        return found

    async def there(self, text: str, account: str = BO_TOO) -> str:
        """Say something on the other messenger; return what was told there because of it."""
        before = len(self.other.told)
        await self.clock.advance(0.001)
        self.other.say(text, account=account, chat=account)
        await self.quiet()
        return "\n".join(t.outbound.text for t in list(self.other.told)[before:])

    async def here(self, text: str, account: str = BO) -> str:
        """Say something on the first messenger, in private; return what was told in that chat."""
        before = len(self.chat.told)
        await self.say(text, account=account, chat=account)
        return self.read(account, before)

    def read(self, chat: str, before: int = 0) -> str:
        """Return what a private chat on the first messenger was told."""
        news = list(self.chat.told)[before:]
        return "\n".join(t.outbound.text for t in news if t.outbound.chat.id == chat)

    async def link(self) -> None:
        """Make Bo's account on the other messenger Bo's."""
        found = CODE.search(await self.here("/link"))
        assert found is not None
        told = await self.there(f"link {found[0]}")
        assert words.linked_here("Bo", "Memory 2 and Other 22 (here)") in told

    async def unlink(self) -> None:
        """Have Bo take the account on the other messenger away."""
        await self.here("/unlink other")
        button, under = self.button("Take it away")
        await self.tap(button, under, BO)
        assert self.gateway.rooms.authoriser.directory.at(Address("other", BO_TOO)) is None


async def test_one_lease_whichever_account_it_was_taken_from() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        await place.here("omni wave")
        assert place.acted() == 1
        await place.there("omni wave")
        assert place.acted() == 2
        organiser = place.gateway.rooms.organiser
        bo = place.gateway.rooms.authoriser.directory.at(Address("memory", BO))
        assert bo is not None
        assert organiser.holder("omni") == bo[0].id
        assert "Bo" in await place.here("omni wave", ADA)
        assert place.acted() == 2


async def test_two_accounts_of_one_person_are_not_two_persons() -> None:
    place = TwoMessengers(rulebook=rules(SECOND))
    async with place.open():
        await place.link()
        told = await place.here("omni wave")
        assert "needs a second person who agrees." in told
        button, under = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[button.nonce].command
        assert "Somebody else has to agree." in await place.there(command)
        assert not [t for t in place.other.told if "Do you agree?" in t.outbound.text]
        assert place.acted() == 0
        await place.here("/me")
        await place.tap(button, under)  # Ada does
        button, under = place.button("Do it")
        await place.tap(button, under, BO)
        assert place.acted() == 1


async def test_an_order_is_worth_what_the_account_is_by_which_it_came() -> None:
    wanted = SkillPrecondition(scopes=("omni:wave",), assurance="e2ee-verified")
    place = TwoMessengers(rulebook=rules(wanted))
    place.chat.assurance = "provider-readable"
    async with place.open():
        await place.link()
        assert "This chat is not enough." in await place.here("omni wave")
        assert place.acted() == 0
        await place.there("omni wave")
        assert place.acted() == 1
        await place.here("omni wave")
        assert place.acted() == 1
        bo = place.gateway.rooms.authoriser.directory.at(Address("other", BO_TOO))
        assert bo is not None
        books = books_of(place.gateway, "UTC", place.gateway._parts.messengers)
        assert books.assurance_of(bo[0]) is Assurance.PROVIDER_READABLE


async def test_the_file_takes_no_account_from_whoever_linked_it(
    caplog: pytest.LogCaptureFixture,
) -> None:
    store = MemoryStore()
    place = TwoMessengers(store)
    async with place.open():
        await place.link()
    taken, own = Address("other", BO_TOO), Address("other", "23")
    place = TwoMessengers(store)
    more = (
        ConfiguredPerson("Mallory", (taken,), ("admin",)),
        ConfiguredPerson("Zoe", (taken, own), ("viewer",)),
    )
    place.gateway._settings = replace(place._settings, people=(*place.people, *more))
    async with place.open():
        assert "You are Bo." in await place.there("/me")
        assert "You are Zoe." in await place.there("/me", "23")
        assert not place.gateway.rooms.authoriser.directory.named("Mallory")
        assert "other:22 is somebody's here already" in caplog.text


async def test_what_was_asked_by_an_account_that_goes_comes_to_nothing() -> None:
    place = TwoMessengers(rulebook=rules(SECOND))
    async with place.open():
        await place.link()
        assert "needs a second person" in await place.there("omni wave")
        agree, under = place.button("I agree")
        await place.unlink()
        assert "settled before" in await place.tap(agree, under)
        assert place.acted() == 0


async def test_what_was_agreed_to_by_an_account_that_goes_comes_to_nothing() -> None:
    place = TwoMessengers(rulebook=rules(SECOND))
    async with place.open():
        await place.link()
        await place.here("omni wave", ADA)
        confirmation = place.gateway.pipeline.confirmation
        [number] = confirmation._requests
        assert "Ada is told that you agree." in await place.there(f"/approve {number}")
        do_it, under = place.button("Do it")
        assert confirmation._requests
        await place.unlink()
        assert not confirmation._requests
        await place.tap(do_it, under)
        assert place.acted() == 0


async def test_a_second_factor_is_proven_for_a_chat_and_ends_with_an_account() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        two_factor = place.gateway.access.two_factor
        bo = place.gateway.rooms.authoriser.directory.at(Address("memory", BO))
        assert bo is not None
        two_factor._proven.refresh(bo[0].id, Chat("other", BO_TOO))
        assert two_factor.fresh(bo[0].id, Chat("other", BO_TOO))
        assert not two_factor.fresh(bo[0].id, Chat("memory", BO))
        await place.unlink()
        assert not two_factor.fresh(bo[0].id, Chat("other", BO_TOO))


async def test_one_set_of_limits_for_all_accounts() -> None:
    place = TwoMessengers(limit=RateLimit(burst=4.0, per_s=0.001))
    async with place.open():
        await place.link()  # one of them
        for _ in range(2):
            assert "omni" in await place.here("omni look")
        assert "omni" in await place.there("omni look")
        refused = "That is more than one person may ask."
        assert refused in await place.there("omni look")
        assert place.acted() == 3
        await place.here("omni look")
        assert place.acted() == 3


async def test_a_linked_account_outlives_a_restart_and_so_does_its_loss() -> None:
    store = MemoryStore()
    place = TwoMessengers(store)
    async with place.open():
        await place.link()
    place = TwoMessengers(store)
    async with place.open():
        assert "You are Bo." in await place.there("/me")
        await place.unlink()
    place = TwoMessengers(store)
    async with place.open():
        assert "You are Bo." not in await place.there("/me")
        assert "You are Bo." in await place.here("/me")


async def test_a_code_is_in_no_archive() -> None:
    place = TwoMessengers()
    async with place.open():
        found = CODE.search(await place.here("/link"))
        assert found is not None
        assert place.gateway.access.codes_in(f"say {found[0]}") == (found[0].replace("-", ""),)
        await place.there(f"link {found[0]}")
        assert place.gateway.access.codes_in(f"say {found[0]}") == ()
        assert "You are Vi." in await place.here("/me", VI)


# ---- where somebody is told something ----


def tell(place: TwoMessengers, text: str, *, urgent: bool = False) -> None:
    """Tell Bo something that Bo did not ask for."""
    bo = place.gateway.rooms.authoriser.directory.at(Address("memory", BO))
    assert bo is not None
    place.gateway.kernel.reach.tell((bo[0].id,), text, urgent=urgent)


async def heard_of(place: TwoMessengers, text: str, *, urgent: bool = False) -> list[str]:
    """Tell Bo something; return the messengers on which it was read."""
    tell(place, text, urgent=urgent)
    await place.quiet()
    await place.clock.advance(2.0)
    await place.quiet()
    both = {"memory": place.chat, "other": place.other}
    return [n for n, m in both.items() if any(text in t.outbound.text for t in m.told)]


async def test_a_notice_goes_where_the_person_was_last() -> None:
    place = TwoMessengers()
    async with place.open():
        assert await heard_of(place, "notice A") == ["memory"]
        await place.link()
        assert await heard_of(place, "notice B") == ["other"]
        await place.here("/me")
        assert await heard_of(place, "notice C", urgent=True) == ["memory"]
        await place.there("/me")
        assert await heard_of(place, "notice D", urgent=True) == ["other"]
        await place.say("omni", account=BO, chat="-7", kind=ChatKind.GROUP)
        assert await heard_of(place, "notice E") == ["memory"]


async def test_where_somebody_was_last_outlives_a_restart() -> None:
    store = MemoryStore()
    place = TwoMessengers(store)
    async with place.open():
        await place.link()
        await place.here("/me")
    for last in ("memory", "other"):
        place = TwoMessengers(store)
        async with place.open():
            assert await heard_of(place, "notice F") == [last]
            await place.there("/me")


async def test_what_a_chat_does_not_take_is_told_in_another_one() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        place.other.gone.add(BO_TOO)
        assert await heard_of(place, "an alarm", urgent=True) == ["memory"]


async def test_a_messenger_that_is_not_connected_is_passed_over() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        place.other.connected = False
        assert await heard_of(place, "an alarm", urgent=True) == ["memory"]
        place.other.connected = True
        assert await heard_of(place, "notice G") == ["other"]


async def test_nothing_is_kept_of_somebody_with_one_account() -> None:
    store = MemoryStore()
    place = TwoMessengers(store)
    async with place.open():
        await place.here("/me")
        await place.here("/me", ADA)
        await place.say("omni", account=BO, chat="-7", kind=ChatKind.GROUP)
    assert (await store.open()).facts.get(LAST_ACCOUNTS, ()) == ()


async def test_what_is_kept_goes_with_the_account() -> None:
    store = MemoryStore()
    place = TwoMessengers(store)
    async with place.open():
        await place.link()
        await place.unlink()
        assert await heard_of(place, "notice F") == ["memory"]
    assert (await store.open()).facts.get(LAST_ACCOUNTS, ()) == ()


async def test_answers_go_where_they_were_asked_for() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        place.robot("omni").work_s = 10_000.0
        before = len(place.other.told)
        await place.there("omni move 1 m")
        await place.here("/me")
        place.robot("omni").finish()
        await place.quiet()
        await place.clock.advance(2.0)
        assert any("done" in t.outbound.text for t in list(place.other.told)[before:])
        assert "omni: move" not in place.read(BO)


# ---- what an account that is lost reads ----


async def test_a_card_in_an_account_that_is_lost_ends() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        await place.there("/card omni")
        await place.here("/card omni")
        await place.unlink()
        await place.clock.advance(2.0)
        await place.quiet()
        dashboards = place.gateway.kernel.shared.dashboards.get()
        assert dashboards.of(place.chat, Chat("memory", BO)) is not None
        assert dashboards.of(place.other, Chat("other", BO_TOO)) is None
        before = len(place.other.told)
        await place.here("omni wave")
        await place.clock.advance(60.0)
        await place.quiet()
        assert not list(place.other.told)[before:]


async def test_an_account_that_is_lost_hears_no_robot() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        await place.there("omni wave")
        await place.here("omni wave")
        followers = place.gateway.pipeline.followers
        assert {m.name for m, _ in followers.of("omni")} == {"memory", "other"}
        await place.unlink()
        assert {m.name for m, _ in followers.of("omni")} == {"memory"}


async def test_what_was_planned_in_an_account_that_is_lost_is_shown_in_another_one() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        told = await place.there("in 10 minutes omni wave")
        button, under = next(
            (b, t.message)
            for t in reversed(place.other.told)
            for row in t.outbound.buttons
            for b in row
            if b.label not in {"Leave it", "Change"}
        )
        place.other.tap(button, under=under, account=BO_TOO)
        await place.quiet()
        await place.unlink()
        before, there = len(place.chat.told), len(place.other.told)
        for _ in range(12):
            await place.clock.advance(60.0)
            await place.quiet()
        assert place.acted() == 1, told
        assert "omni: wave" in place.read(BO, before)
        news = [t.outbound.text for t in list(place.other.told)[there:]]
        assert not [text for text in news if "done" in text or "sent" in text], news


class RoomsMessenger(OtherMessenger):
    """A messenger whose private chats have ids of their own."""

    def private_chat(self, account: str) -> Chat:
        """Return the room with somebody alone."""
        return Chat("other", f"room-{account}")


class TwoMessengersWithRooms(TwoMessengers):
    besides = (RoomsMessenger,)

    async def there(self, text: str, account: str = BO_TOO) -> str:
        """Say something in the room with somebody alone; return what was told there."""
        before = len(self.other.told)
        await self.clock.advance(0.001)
        self.other.say(text, account=account, chat=f"room-{account}")
        await self.quiet()
        return "\n".join(t.outbound.text for t in list(self.other.told)[before:])


@pytest.mark.parametrize("kind", [TwoMessengers, TwoMessengersWithRooms])
async def test_nothing_more_is_kept_of_an_account_that_is_lost(kind: type[TwoMessengers]) -> None:
    place = kind()
    own = Chat("other", BO_TOO if kind is TwoMessengers else f"room-{BO_TOO}")
    async with place.open():
        await place.here("/me", ADA)
        found = CODE.search(await place.here("/link", ADA))
        assert found is not None
        await place.there(f"link {found[0]}")
        archive = place.gateway.archive
        await place.there("/archive on")
        await place.here("/archive on", ADA)
        assert archive.keeps(own)
        await place.here("/unlink other", ADA)
        button, under = place.button("Take it away")
        await place.tap(button, under)
        assert not archive.keeps(own)
        assert archive.keeps(Chat("memory", ADA))
        assert "does not belong to Ada" in place.other.told[-1].outbound.text
