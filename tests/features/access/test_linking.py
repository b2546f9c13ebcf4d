"""One person, several accounts: linked by one code, taken away by a tap, said and recorded."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from rosic.authoriser import link_messages as words
from rosic.authoriser import messages
from rosic.authoriser.account_links import ACCOUNTS_AT_MOST, CODE_NS
from rosic.core.identity import PAGE, Address, Caller
from rosic.core.message import MessageValidity
from rosic.core.records import Decided
from rosic.errors import NotPermitted
from rosic.features.access import messages as access_words
from rosic.gateway.commands import ONLY_IN_PRIVATE
from rosic.stores.memory import MemoryStore
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, BrokenStore, Hall, a_hall
from tests.features.access.test_second_factor import set_up

if TYPE_CHECKING:
    from rosic.core.records import Record

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")


async def code_of(hall: Hall, account: str = CY) -> str:
    """Ask for a code; return it."""
    found = CODE.search(await hall.say(account, "/link"))
    assert found is not None
    return found[0]


def at(hall: Hall, account: str) -> str:
    """Return who is at an account; empty for nobody."""
    known = hall.directory.at(Address("telegram", account))
    return "" if known is None else known[0].id


async def linked(hall: Hall, account: str = DI) -> None:
    """Make an account Cy's as well."""
    await hall.say(account, f"link {await code_of(hall)}")
    assert at(hall, account) == "p-3"


class AuditedStore(MemoryStore):
    """Tells which acts were written: by whom, about whom."""

    def __init__(self) -> None:
        super().__init__()
        self.acts: list[tuple[str, str, str]] = []

    async def write(self, *records: Record) -> None:
        self.acts += [(r.act, r.by, r.about) for r in records if isinstance(r, Decided)]
        await super().write(*records)


# ---- linking ----


@pytest.mark.parametrize("said", ["link {}", "/link {}", "{}", "/start {}", "join {}", "LINK {}"])
async def test_one_code_makes_another_account_the_same_person(said: str) -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        assert await hall.say(DI, said.format(code)) == words.linked_here(
            "Cy Young", "Telegram 3 and Telegram 4 (here)"
        )
        assert at(hall, DI) == at(hall, CY) == "p-3"
        assert hall.directory.person("p-3").roles == ("operator",)  # type: ignore[union-attr]
        assert hall.last(CY).text == words.linked_there("Telegram 4")
        assert hall.last(ADA).text == words.linked_of("Cy Young", "Telegram 4")
        assert hall.last(BO).text == words.linked_of("Cy Young", "Telegram 4")
        assert "You are Cy Young." in await hall.say(DI, "/me")
        assert words.your_accounts("Telegram 3 and Telegram 4 (here)") in hall.last(DI).text
        assert "accounts: Telegram 3 and Telegram 4" in await hall.say(ADA, "/people Cy")
        assert "  Cy Young: Telegram 3 and Telegram 4" in await hall.say(ADA, "/security")


async def test_the_answer_to_link_carries_a_link_that_opens_the_other_chat() -> None:
    async with a_hall() as hall:
        told = await hall.say(CY, "/link")
        code = CODE.search(told)
        assert code is not None
        assert told == words.code(code[0], 600.0)


async def test_a_code_is_good_once_for_minutes_and_the_newest_alone() -> None:
    async with a_hall() as hall:
        first = await code_of(hall)
        second = await code_of(hall)
        assert await hall.say(DI, first) == messages.NOT_GOOD
        await hall.say(DI, second)
        assert at(hall, DI) == "p-3"
        assert await hall.say(ED, second) == messages.NOT_GOOD
        third = await code_of(hall)
        await hall.clock.advance(CODE_NS / 1e9)
        assert await hall.say(ED, third) == messages.NOT_GOOD
        assert at(hall, ED) == ""


async def test_it_is_written_down_and_a_restart_knows_it() -> None:
    store = AuditedStore()
    async with a_hall(store) as hall:
        await linked(hall)
        assert store.acts[-1] == ("link", "p-3", "p-3")
    async with Hall(store).open() as hall:
        assert at(hall, DI) == at(hall, CY) == "p-3"
        assert hall.rights.visible("p-3", hall.clock.wall_ns())
        await hall.say(CY, "/unlink telegram:4")
        await hall.tap(CY, "Take it away")
    async with Hall(store).open() as hall:
        assert (at(hall, DI), at(hall, CY)) == ("", "p-3")


async def test_nothing_is_linked_that_cannot_be_written() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        code = await code_of(hall)
        store.broken = True
        assert await hall.say(DI, f"link {code}") == access_words.NOT_WRITTEN
        assert at(hall, DI) == ""
        store.broken = False


# ---- who may not ----


async def test_an_account_that_is_somebodys_stays_theirs() -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        assert await hall.say(BO, f"link {code}") == words.TAKEN
        assert at(hall, BO) == "p-2"
        assert hall.last(CY).text == words.code_used("Telegram 2")
        assert await hall.say(DI, code) == messages.NOT_GOOD
        assert hall.counters["link-taken"] == 1


async def test_whoever_lost_their_access_does_not_come_back_as_somebody_else() -> None:
    async with a_hall() as hall:
        code = await code_of(hall, ADA)
        await hall.say(BO, "/revoke Cy Young")
        await hall.tap(BO, "Revoke")
        assert not hall.directory.has_good_key("p-3")
        assert await hall.say(CY, f"link {code}") == words.TAKEN
        assert at(hall, CY) == "p-3"


async def test_a_code_dies_with_the_access_of_whoever_asked_for_it() -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        await hall.say(ADA, "/lock Cy Young")
        assert await hall.say(DI, code) == messages.NOT_GOOD
        assert "locked" in await hall.say(CY, "/link")
        assert await hall.say(ADA, "/unlock Cy Young") == "Cy Young is unlocked."
        assert not hall.locks.locked("p-3")
        assert await hall.say(DI, code) == messages.NOT_GOOD, "whoever had the account may have it"
        assert at(hall, DI) == ""


async def test_a_code_in_ones_own_account_is_no_use_and_stays_good() -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        assert await hall.say(CY, f"link {code}") == words.OWN
        await hall.say(DI, f"link {code}")
        assert at(hall, DI) == "p-3"


async def test_whoever_waits_for_an_admin_waits_on() -> None:
    async with a_hall() as hall:
        await hall.say(DI, f"/start {await hall.invited('senior')}")
        await hall.tap(DI, "Join")
        told = await hall.say(DI, f"link {await code_of(hall)}")
        assert "An admin has to let you in" in told
        assert at(hall, DI) == ""


@pytest.mark.parametrize("standing", [MessageValidity.FRESH, MessageValidity.EDITED])
async def test_a_code_shown_in_a_group_is_good_for_nobody(standing: MessageValidity) -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        told = await hall.in_group(DI, f"look: {code}", standing=standing)
        assert told == messages.IN_GROUP
        assert hall.last(CY).text == words.CODE_SHOWN
        assert await hall.say(DI, code) == messages.NOT_GOOD
        assert at(hall, DI) == ""
        assert await hall.in_group(CY, "/link") == words.IN_GROUP


async def test_a_phone_that_is_set_up_is_asked_for_first() -> None:
    async with a_hall() as hall:
        await set_up(hall)
        await code_of(hall)
        await hall.clock.advance(3_601.0)
        assert "six digits" in await hall.say(CY, "/link")


async def test_nobody_has_more_accounts_than_can_be_told() -> None:
    async with a_hall() as hall:
        for number in range(ACCOUNTS_AT_MOST - 1):
            await linked(hall, f"4{number}")
        assert await hall.say(CY, "/link") == words.too_many(ACCOUNTS_AT_MOST)


async def test_from_a_page_no_account_is_linked() -> None:
    async with a_hall() as hall:
        page = Caller("p-3", "Cy Young", Address(PAGE, "p-3"), "k-3", "s")
        with pytest.raises(NotPermitted, match="on a messenger"):
            hall.access.links.offer(page)


# ---- guessing ----


async def test_strangers_guess_as_often_as_they_guess_invitations_and_wait() -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        for _ in range(5):
            assert await hall.say(DI, "link 0000-0000") == messages.NOT_GOOD
        assert "Too many wrong codes." in await hall.say(DI, f"link {code}")
        assert at(hall, DI) == ""
        await hall.clock.advance(1.0)
        await hall.say(ED, f"link {code}")  # who shuts themselves out shuts out nobody else
        assert at(hall, ED) == "p-3"


async def test_codes_are_bounded() -> None:
    async with a_hall() as hall:
        links = hall.access.links
        await hall.knows("77", "Gus", "viewer")
        gus = Caller("p-77", "Gus", Address("telegram", "77"), "k-77", "s")
        for _ in range(100):
            links.offer(gus)
        assert len(links._codes) == 1


# ---- taking away ----


async def test_one_tap_takes_an_account_away_where_it_was_linked_and_where_it_was_asked() -> None:
    for there in (CY, DI):
        async with a_hall() as hall:
            await linked(hall)
            told = await hall.tap(there, "Take it away")
            assert words.unlinked("Telegram 4") in told
            assert (at(hall, DI), at(hall, CY)) == ("", "p-3")
            other = DI if there == CY else CY
            expected = (
                words.unlinked_here("Cy Young")
                if other == DI
                else words.unlinked_there("Telegram 4")
            )
            assert hall.last(other).text == expected
            assert hall.last(ADA).text == words.unlinked_of("Cy Young", "Cy Young", "Telegram 4")
            assert "I do not know you yet" in await hall.say(DI, "/me")
            assert "You are Cy Young." in await hall.say(CY, "/me")


@pytest.mark.parametrize("typed", ["telegram:4", "TELEGRAM:4", "p-3 telegram:4"])
async def test_an_account_that_is_typed_is_asked_about_first(typed: str) -> None:
    async with a_hall() as hall:
        await linked(hall)
        assert await hall.say(CY, f"/unlink {typed}") == words.sure_of_own("Telegram 4")
        assert at(hall, DI) == "p-3"
        await hall.tap(CY, "Leave it")
        assert at(hall, DI) == "p-3"
        await hall.say(CY, f"/unlink {typed}")
        await hall.tap(CY, "Take it away")
        assert at(hall, DI) == ""


async def test_unlink_alone_shows_ones_accounts() -> None:
    async with a_hall() as hall:
        assert await hall.say(CY, "/unlink") == words.only_one("Telegram 3")
        await linked(hall)
        assert await hall.say(DI, "/unlink") == words.which_account(
            "Telegram 3 and Telegram 4 (here)"
        )
        await hall.tap(DI, "Telegram 3")
        await hall.tap(DI, "Take it away")
        assert (at(hall, CY), at(hall, DI)) == ("", "p-3")
        assert await hall.say(DI, "/unlink telegram") == words.LAST
        assert await hall.in_group(DI, "/unlink telegram") == ONLY_IN_PRIVATE


async def test_an_admin_takes_an_account_of_somebody_away_and_both_sides_read_it() -> None:
    store = AuditedStore()
    async with a_hall(store) as hall:
        await linked(hall)
        assert await hall.say(ADA, "/unlink Cy Young") == words.which_account_of(
            "Cy Young", "Telegram 3 and Telegram 4"
        )
        assert await hall.say(ADA, "/unlink Cy Young telegram:4") == words.sure_of(
            "Cy Young", "Telegram 4"
        )
        told = await hall.tap(ADA, "Take it away")
        assert told == words.unlinked("Telegram 4")
        assert at(hall, DI) == ""
        assert hall.last(DI).text == words.unlinked_here("Cy Young")
        assert hall.last(CY).text == words.unlinked_by("Telegram 4", "Ada")
        assert hall.last(BO).text == words.unlinked_of("Ada", "Cy Young", "Telegram 4")
        assert store.acts[-1] == ("unlink", "p-1", "p-3")
        assert await hall.say(ADA, "/unlink Cy Young telegram:3") == words.LAST
        assert await hall.say(ADA, "/unlink Cy Young") == words.LAST


async def test_nobody_else_takes_an_account_away() -> None:
    async with a_hall() as hall:
        await linked(hall)
        await hall.knows("9", "Vi", "viewer")
        for line in ("/unlink Cy Young telegram:4", "/unlink p-3 telegram:4", "/unlink Cy Young"):
            await hall.say("9", line)
            assert "Take it away" not in hall.labels("9")
        assert at(hall, DI) == "p-3"


async def test_an_account_is_gone_at_once_although_the_disk_fails() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        await linked(hall)
        store.broken = True
        await hall.tap(CY, "Take it away")
        assert at(hall, DI) == ""
        assert access_words.UNWRITTEN in hall.last(CY).text
        store.broken = False


async def test_an_account_that_goes_ends_what_it_may_have_begun() -> None:
    async with a_hall() as hall:
        await linked(hall)
        sessions = hall.access.page_sessions
        token, fact = sessions.begin("p-3")
        sessions.apply(fact)
        sessions.offer("p-3")
        waiting = await code_of(hall, DI)
        await hall.say(CY, "/unlink telegram:4")
        await hall.tap(CY, "Take it away")
        with pytest.raises(Exception, match="Sign in first"):
            sessions.identify(token)
        assert not sessions._codes
        assert await hall.say(ED, waiting) == messages.NOT_GOOD
        buttons = hall.authoriser.buttons
        assert not [b for b in buttons._bound.values() if b.principal == "p-3"]


async def test_an_account_that_was_taken_away_can_be_linked_anew() -> None:
    async with a_hall() as hall:
        await linked(hall)
        await hall.tap(CY, "Take it away")
        await linked(hall)
        await hall.say(DI, "/me")
        assert "You are Cy Young." in hall.last(DI).text


async def test_a_code_from_before_a_lock_is_no_good_after_it() -> None:
    async with a_hall() as hall:
        code = await code_of(hall)
        await hall.say(ADA, "/lock Cy Young")
        await hall.tap(ADA, "Unlock")

        await hall.say(DI, f"link {code}")

        assert at(hall, DI) == ""


async def test_an_application_from_an_account_that_was_lost_lets_nobody_in() -> None:
    async with a_hall() as hall:
        await linked(hall)
        code = await hall.invited("operator confirm")
        await hall.say(DI, code)
        await hall.tap(DI, hall.labels(DI)[0])
        await hall.say(CY, "/unlink telegram:4")
        await hall.tap(CY, "Take it away")

        told = await hall.tap(ADA, "Let them in")

        assert "settled" in told
        assert (at(hall, DI), at(hall, CY)) == ("", "p-3")
