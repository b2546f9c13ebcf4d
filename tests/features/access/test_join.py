"""Coming in by a code: what is shown, what a tap does, and what is turned away."""

from __future__ import annotations

from rosic.authoriser import messages
from rosic.authoriser.invitations import OPEN_AT_MOST
from rosic.core.identity import Address
from rosic.core.records import Decided
from rosic.features.access import messages as words
from rosic.features.access.join import ANSWERS
from rosic.features.access.newcomer_chat import stand_in
from rosic.stores.memory import MemoryStore
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, BrokenStore, Hall, a_hall

HELLO = (
    "Hello. You are invited as operator on kuka1 for 2 hours.\n"
    "What the chat operator can read: everything here (Telegram is not end-to-end encrypted)."
)
WELCOME = (
    "You are in, as operator on kuka1 for 2 hours. Say stop at any time: whatever you may see, "
    "you may stop.\nWhich robot?"
)
STRANGER = "Hello. I work for people I know, and I do not know you yet. Ask the admin here."


def grants(hall: Hall, account: str) -> list[tuple[str, tuple[str, ...]]]:
    known = hall.directory.at(Address(hall.chat.platform, account))
    assert known is not None
    return [(g.role, g.robots) for g in hall.rights.grants(known[0].id)]


# ---- the way in ----


async def test_a_link_shows_what_it_gives_and_one_tap_lets_in() -> None:
    async with a_hall() as hall:
        code = await hall.invited("operator kuka1 for 2h")
        assert await hall.say(DI, f"/start {code}") == HELLO
        assert hall.labels(DI) == ["Join", "Not me"]
        assert hall.directory.at(Address("telegram", DI)) is None
        assert await hall.tap(DI, "Join") == WELCOME
        assert hall.labels(DI) == ["kuka1"]
        assert grants(hall, DI) == [("operator", ("kuka1",))]
        assert hall.last(ADA).text == "Di is in, as operator on kuka1 for 2 hours."
        assert await hall.tap(DI, "kuka1") == "(Use)"
        await hall.clock.advance(7_201.0)
        known = hall.directory.at(Address("telegram", DI))
        assert known is not None
        assert not hall.rights.visible(known[0].id, hall.clock.wall_ns())


async def test_a_code_comes_in_many_shapes() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        bare, low = code.replace("-", ""), code.lower()
        shapes = (
            code,
            low,
            f"join {bare}",
            f"/join {low}",
            f"/start@lab_bot {code}",
            f"https://t.me/lab_bot?start={code}",
            code.replace("-", "\u2013"),
        )
        for shape in shapes:
            assert (await hall.say(DI, shape)).startswith("Hello. You are invited as viewer."), (
                shape
            )


async def test_what_the_chat_operator_can_read_is_said_by_its_worth() -> None:
    expected = {
        "local": "Hello. You are invited as viewer.",
        "e2ee-verified": (
            "Hello. You are invited as viewer.\nWhat the chat operator can read: who writes when, "
            "but not what (the messages are end-to-end encrypted)."
        ),
        "never-heard-of": (
            "Hello. You are invited as viewer.\nWhat the chat operator can read: everything here "
            "(Matrix is not end-to-end encrypted)."
        ),
    }
    for assurance, text in expected.items():
        async with a_hall(platform="matrix", assurance=assurance) as hall:
            code = await hall.invited("viewer")
            assert await hall.say(DI, code) == text


async def test_looking_at_a_code_uses_nothing_up_and_not_me_tells_who_invited() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        await hall.say(DI, code)
        assert await hall.tap(DI, "Not me") == (
            "Nothing was done. Whoever invited has been told that it was not for you."
        )
        assert hall.last(ADA).text == (
            "Your invitation as viewer reached somebody who says that it is not for them. "
            "Its code is still good. Take it back if you sent it to the wrong person."
        )
        await hall.say(ED, code)
        assert (await hall.tap(ADA, "Take it back")) == words.TAKEN_BACK
        assert await hall.tap(ED, "Join") == messages.NOT_GOOD
        assert hall.directory.at(Address("telegram", ED)) is None


async def test_a_known_person_gets_more() -> None:
    async with a_hall() as hall:
        code = await hall.invited("senior omni for 1h", account=BO)
        await hall.say(CY, code)
        assert await hall.tap(CY, "Join") == (
            "An admin has to let you in and sees the words: "
            f"{hall.enrolment.applicants.all()[0].words}. If asked, say these words. I wait for "
            "24 hours."
        )
        code = await hall.invited("viewer kuka1 for 1h", account=BO)
        await hall.say(DI, code)
        await hall.tap(DI, "Join")
        more = await hall.invited("junior omni", account=BO)
        await hall.say(DI, more)
        assert (await hall.tap(DI, "Join")).startswith(
            "You can do more now: junior on omni. What you could do before stays as it was."
        )
        assert grants(hall, DI) == [("viewer", ("kuka1",)), ("junior", ("omni",))]


async def test_the_first_admin_comes_in_by_the_code_of_the_first_start() -> None:
    async with Hall().open() as hall:
        offer = hall.enrolment.first_admin_code()
        assert offer is not None
        async with hall.changes.turn() as turn:
            await turn.write(offer.records)
        hall._names[ADA] = "Ada"
        await hall.say(ADA, f"join {offer.code.reveal()}")
        assert (await hall.tap(ADA, "Join")).startswith("You are in, as admin.")
        assert hall.directory.named("Ada")[0].roles == ("admin",)
        assert (await hall.say(ADA, "/people")).startswith("Ada (you) · admin")


async def test_somebody_without_a_shown_name_is_a_guest() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        await hall.say("77", code)
        await hall.tap("77", "Join")
        assert hall.directory.named("guest")


async def test_coming_in_survives_a_restart() -> None:
    store = MemoryStore()
    async with a_hall(store) as hall:
        code = await hall.invited("operator kuka1 for 2h as Dr Di")
        await hall.say(DI, code)
        await hall.tap(DI, "Join")
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        assert grants(again, DI) == [("operator", ("kuka1",))]
        assert again.directory.named("Dr Di")
        assert await again.say(ED, code) == messages.NOT_GOOD


# ---- buttons on the doorstep ----


async def test_a_button_is_good_once_for_one_address_and_ten_minutes() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer code 2h")
        await hall.say(DI, code)
        join, under = hall.button(DI, "Join")
        assert await hall.tap_again(ED, join, under) == ""  # another's tap
        assert hall.chat.answers[-1][1] == "This question was asked of somebody else."
        assert hall.directory.at(Address("telegram", ED)) is None

        assert (await hall.tap_again(DI, join, under)).startswith("You are in")
        assert await hall.tap_again(DI, join, under) == ""  # twice
        assert hall.chat.answers[-1][1] == words.ANSWERED
        await hall.tap_again(DI, hall.button(DI, "Not me")[0], under)
        assert hall.chat.answers[-1][1] == words.ANSWERED
        assert "not for them" not in hall.told(ADA)

        code = await hall.invited("viewer code 2h")
        await hall.say(ED, code)
        join, under = hall.button(ED, "Join")
        await hall.clock.advance(2 * 3_600 + 1)
        assert await hall.tap_again(ED, join, under) == words.INVITATION_OVER
        assert hall.chat.answers[-1][1] == "This button is too old. Nothing was done."


async def test_the_buttons_are_good_for_as_long_as_the_code_and_no_longer() -> None:
    async with a_hall() as hall:
        for code, lasts_s in (("10 min", 600), ("2h", 7_200), ("20 s", 20)):
            await hall.say(DI, await hall.invited(f"viewer code {code}"))
            join, under = hall.button(DI, "Join")
            await hall.clock.advance(lasts_s - 1)
            assert join.good_for_ns == lasts_s * 1_000_000_000
            await hall.clock.advance(2)
            assert await hall.tap_again(DI, join, under) == words.INVITATION_OVER
        await hall.say(DI, await hall.invited("viewer code 2h"))
        await hall.clock.advance(7_199)
        assert (await hall.tap(DI, "Join")).startswith("You are in")


async def test_the_first_admin_is_told_where_the_code_is_and_to_ask_nobody() -> None:
    async with Hall().open() as hall:
        offer = hall.enrolment.first_admin_code()
        assert offer is not None
        async with hall.changes.turn() as turn:
            await turn.write(offer.records)
        assert await hall.say(ADA, "hello") == messages.FIRST_WANTED
        assert await hall.say(ADA, "join AAAA-AAAA") == messages.NOT_GOOD_FOR_THE_FIRST
        await hall.say(ADA, f"join {offer.code.reveal()}")
        await hall.clock.advance(86_399)
        join, under = hall.button(ADA, "Join")
        await hall.clock.advance(2)
        assert await hall.tap_again(ADA, join, under) == words.OVER_FOR_THE_FIRST
    async with a_hall() as hall:
        assert await hall.say(DI, "hello") not in {messages.FIRST_WANTED, ""}


async def test_a_button_to_join_that_was_shown_before_a_gap_is_still_good() -> None:
    async with a_hall() as hall:
        await hall.say(DI, await hall.invited("viewer"))
        await hall.clock.advance(1.0)
        hall.chat.gap()
        assert (await hall.tap(DI, "Join")).startswith("You are in")


async def test_a_button_joins_by_the_invitation_under_which_it_stands() -> None:
    async with a_hall() as hall:
        await hall.say(DI, await hall.invited("viewer kuka1 for 1h"))
        first, under = hall.button(DI, "Join")
        await hall.say(DI, await hall.invited("operator omni for 1h"))
        await hall.tap_again(DI, first, under)
        assert grants(hall, DI) == [("viewer", ("kuka1",))]


async def test_two_who_were_shown_one_code_race_and_one_wins() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        await hall.say(DI, code)
        await hall.say(ED, code)
        buttons = {account: hall.button(account, "Join") for account in (DI, ED)}
        for account, (button, under) in buttons.items():
            hall.chat.tap(button, under=under, account=account)
        await hall.quiet()
        inside = [a for a in (DI, ED) if hall.directory.at(Address("telegram", a)) is not None]
        assert len(inside) == 1
        (outside,) = {DI, ED} - set(inside)
        assert hall.last(outside).text == messages.NOT_GOOD


def test_no_principal_looks_like_what_stands_in_for_one() -> None:
    seen = {stand_in(Address(*pair)) for pair in (("a", "b:c"), ("a:b", "c"), ("a', 'b", "c"))}
    assert len(seen) == 3
    assert all(standing.startswith("(") for standing in seen)


# ---- turned away ----


async def test_five_wrong_codes_and_then_a_wait() -> None:
    async with a_hall() as hall:
        good = await hall.invited("viewer code 1h")
        for number in range(5):
            assert await hall.say(DI, f"join ABCD-000{number}") == messages.NOT_GOOD
        assert await hall.say(DI, good) == (
            "Too many wrong codes. Try again in 15 minutes, or ask whoever invited you."
        )
        assert hall.enrolment.invitations.open()
        await hall.clock.advance(901.0)
        assert (await hall.say(DI, good)).startswith("Hello.")


async def test_the_breaker_tells_the_admins_who_can_open_joining_again() -> None:
    async with a_hall() as hall:
        good = await hall.invited("viewer code 1h")
        for number in range(50):
            await hall.say(str(1_000 + number // 5), f"/start ABCD-00{number:02}")
        assert hall.last(ADA).text == (
            "50 wrong codes came in within 60 minutes: somebody may be guessing. Whoever has a "
            "good code can still join. For 60 minutes each account has 2 tries, then it waits "
            "as long; an admin can end that."
        )
        assert hall.last(BO).urgent
        await hall.clock.advance(60.0)
        for wrong in ("join ABCD-1111", "join ABCD-2222"):
            await hall.say(DI, wrong)
        assert (await hall.say(DI, good)).startswith("Too many wrong codes.")
        hall.registry.reach.tell(("p-1",), "again", (words.REOPEN_ROW,))
        await hall.quiet()
        assert await hall.tap(ADA, "All tries again") == words.REOPENED
        assert (await hall.say(DI, good)).startswith("Hello.")


async def test_ten_strangers_keep_nobody_out_who_has_a_code() -> None:
    async with a_hall() as hall:
        good = await hall.invited("viewer code 1h")
        for number in range(100):
            await hall.say(str(1_000 + number // 5), f"/start ABCD-00{number:02}")
        assert await hall.say(DI, "join ABCD-1111") == ""  # of wrong codes so many are answered
        assert (await hall.say(DI, good)).startswith("Hello.")


async def test_a_flood_of_wrong_codes_is_not_answered_for_ever() -> None:
    async with a_hall() as hall:
        good = await hall.invited("viewer code 1h")
        answers = [await hall.say(f"9{n}", "join ABCD-0000") for n in range(40)]
        assert sum(map(bool, answers)) == int(ANSWERS.burst)
        assert (await hall.say(DI, good)).startswith("Hello.")  # a good one always is


async def test_a_stranger_without_a_code_gets_the_one_polite_line() -> None:
    async with a_hall() as hall:
        for text in ("/start", "hello", "omni move 1 m", "start the-robot"):
            assert await hall.say(DI, text) == STRANGER


async def test_a_robot_that_looks_like_a_code_is_a_robot_to_those_who_know_it() -> None:
    async with a_hall() as hall:
        assert (await hall.say(CY, "kuka-left")).startswith("(")
        # Nothing was counted: five of them are no five wrong codes.
        assert not hall.counters.by_kind()
        assert await hall.say(DI, "kuka-left") == messages.NOT_GOOD


async def test_somebody_locked_cannot_join_again() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        await hall.say(ADA, "/lock Cy Young")
        assert await hall.say(CY, code) == "Your access is locked. Ask an admin."


async def test_what_cannot_be_written_lets_nobody_in_and_uses_no_code_up() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        code = await hall.invited("operator kuka1 for 2h")
        await hall.say(DI, code)
        store.broken = True
        assert await hall.tap(DI, "Join") == words.NOT_WRITTEN
        assert hall.directory.at(Address("telegram", DI)) is None
        store.broken = False
        await hall.say(DI, code)
        assert await hall.tap(DI, "Join") == WELCOME


async def test_nobody_gets_more_rights_than_can_be_kept() -> None:
    async with a_hall() as hall:
        for _ in range(64):
            await hall.say(CY, await hall.invited("viewer omni for 2h"))
            await hall.tap(CY, "Join")
        code = await hall.invited("viewer omni for 2h")
        await hall.say(CY, code)
        assert await hall.tap(CY, "Join") == (
            "That would be more than 64 separate rights for one person. Make a role of them."
        )
        assert len(hall.enrolment.invitations.open()) == 1 < OPEN_AT_MOST


async def test_the_code_stands_in_no_record_and_no_button() -> None:
    store = MemoryStore()
    async with a_hall(store) as hall:
        code = await hall.invited("viewer")
        await hall.say(DI, code)
        await hall.tap(DI, "Join")
        shown = [t.outbound for t in hall.chat.told if t.outbound.chat.id == DI]
        buttons = [b for outbound in shown for row in outbound.buttons for b in row]
        assert not any(code in b.command or code in b.nonce for b in buttons)
        memory = await store.open()
        assert code.replace("-", "") not in repr(memory).replace("-", "")


async def test_who_let_whom_in_is_on_record() -> None:
    written: list[object] = []

    class Listening(MemoryStore):
        async def write(self, *records: object) -> None:
            written.extend(records)
            await super().write(*records)  # type: ignore[arg-type]

    async with a_hall(Listening()) as hall:
        await hall.say(DI, await hall.invited("operator kuka1 for 2h"))
        await hall.tap(DI, "Join")
        decided = [(r.act, r.by) for r in written if isinstance(r, Decided)]
        assert decided[-3:] == [("invite", "p-1"), ("enrol", "p-1"), ("grant", "p-1")]
