"""Codes of a phone before dangerous things: once each, not too often, and not for long."""

from __future__ import annotations

from base64 import b32decode
from urllib.parse import parse_qs, urlsplit

import pytest

from rosic.authoriser import keys_messages as words
from rosic.authoriser.two_factor import hotp, step_at
from rosic.core.message import Chat, ChatKind
from rosic.core.records import Decided, Fact
from rosic.errors import (
    Expired,
    NotPermitted,
    NotUnderstood,
    RecordUnavailable,
    TooManyRequests,
)
from tests.authoriser.enrolment_rooms import EnrolmentRooms

HERE = Chat("telegram", "1")
THERE = Chat("telegram", "2")
GROUP = Chat("telegram", "-3", ChatKind.GROUP)
DAY_S = 86_400.0


class Phone:
    """Ada's phone: shows what an authenticator app shows, by its own right clock."""

    def __init__(self, secret: bytes, enrolling: EnrolmentRooms) -> None:
        self.secret = secret
        self.enrolling = enrolling

    def shows(self, later_s: float = 0.0) -> str:
        return hotp(self.secret, step_at(self.enrolling.clock.wall_ns() + int(later_s * 1e9)))

    def wrong(self) -> str:
        right = {self.shows(shift) for shift in (-30, 0, 30)}
        return next(code for code in map("{:06}".format, range(10)) if code not in right)


async def with_phone(enrolling: EnrolmentRooms, who: str = "ada") -> Phone:
    setup = enrolling.two_factor.begin(who, "Ada", HERE)
    secret = b32decode(parse_qs(urlsplit(setup.uri.reveal()).query)["secret"][0])
    phone = Phone(secret, enrolling)
    await prove(enrolling, phone.shows(), who, finish=True)
    return phone


async def prove(
    enrolling: EnrolmentRooms,
    code: str,
    who: str = "ada",
    chat: Chat = HERE,
    *,
    finish: bool = False,
) -> None:
    check = enrolling.two_factor.finish if finish else enrolling.two_factor.prove
    proof = check(who, chat, code)
    await enrolling.write(proof.records)
    enrolling.two_factor.admit(proof)


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


@pytest.fixture
async def phone(enrolling: EnrolmentRooms) -> Phone:
    found = await with_phone(enrolling)
    enrolling.two_factor.end("ada")
    await enrolling.clock.advance(60.0)
    return found


async def test_setting_up_takes_a_code_back(enrolling: EnrolmentRooms) -> None:
    with pytest.raises(NotPermitted, match="none is set up"):
        enrolling.two_factor.use("ada", HERE)
    await with_phone(enrolling)
    assert enrolling.two_factor.is_set_up("ada")
    enrolling.two_factor.use("ada", HERE)
    facts = (await enrolling.store.open()).facts["totp"]
    assert facts[0].letter is not None
    assert facts[0].letter.container == "ada"
    assert facts[0].letter.content not in facts[0].body


async def test_nothing_is_kept_until_the_code_has_come_back(enrolling: EnrolmentRooms) -> None:
    setup = enrolling.two_factor.begin("ada", "Ada", HERE)
    assert setup.key.reveal() in setup.sentence
    assert enrolling.two_factor.is_setting_up("ada")
    with pytest.raises(NotPermitted, match="not right"):
        enrolling.two_factor.finish("ada", HERE, "000000")
    assert not enrolling.two_factor.is_set_up("ada")
    await enrolling.clock.advance(601.0)
    assert not enrolling.two_factor.is_setting_up("ada")
    with pytest.raises(Expired, match="Begin again"):
        enrolling.two_factor.finish("ada", HERE, "000000")


async def test_a_secret_is_shown_in_private_only(enrolling: EnrolmentRooms) -> None:
    with pytest.raises(NotPermitted, match="private chat"):
        enrolling.two_factor.begin("ada", "Ada", GROUP)
    enrolling.two_factor.begin("ada", "Ada", HERE)
    with pytest.raises(NotPermitted, match="private chat"):
        enrolling.two_factor.finish("ada", GROUP, "000000")
    assert enrolling.counters["totp-in-group"] == 1


async def test_a_thief_cannot_put_their_phone_in_place_of_the_owners(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    with pytest.raises(NotPermitted, match="Give its present code first"):
        enrolling.two_factor.begin("ada", "Ada", HERE)
    await prove(enrolling, phone.shows())
    enrolling.two_factor.begin("ada", "Ada", HERE)


# ---- replays ----


async def test_a_code_is_good_once(enrolling: EnrolmentRooms, phone: Phone) -> None:
    code = phone.shows()
    await prove(enrolling, code)
    for chat in (HERE, THERE, GROUP):
        with pytest.raises(NotPermitted, match="used before"):
            await prove(enrolling, code, chat=chat)
    assert enrolling.counters["totp-replayed"] == 3


async def test_a_double_tap_before_anything_is_written_counts_once(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    code = phone.shows()
    proof = enrolling.two_factor.prove("ada", HERE, code)
    with pytest.raises(NotPermitted, match="used before"):
        enrolling.two_factor.prove("ada", THERE, code)
    with pytest.raises(RecordUnavailable):
        enrolling.two_factor.admit(proof)  # not written yet: it does not count
    assert not enrolling.two_factor.fresh("ada", HERE)
    await enrolling.write(proof.records)
    enrolling.two_factor.admit(proof)
    assert enrolling.two_factor.fresh("ada", HERE)


async def test_an_earlier_code_is_not_good_after_a_later_one(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    earlier, later = phone.shows(-30), phone.shows(30)
    await prove(enrolling, later)
    for code in (earlier, phone.shows(), later):
        with pytest.raises(NotPermitted, match="used before"):
            await prove(enrolling, code)
    await enrolling.clock.advance(60.0)
    await prove(enrolling, phone.shows())


async def test_a_code_used_before_a_restart_is_used(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    code = phone.shows()
    await prove(enrolling, code)
    again = await enrolling.restarted()
    with pytest.raises(NotPermitted, match="used before"):
        again.two_factor.prove("ada", HERE, code)
    assert not again.two_factor.fresh("ada", HERE)  # a step-up is never written down


async def test_a_clock_set_back_a_day_revives_no_code(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    used = phone.shows()
    await prove(enrolling, used)
    await enrolling.clock.advance(60.0)
    unused = phone.shows()  # somebody saw it on the phone
    await enrolling.clock.advance(DAY_S)
    await enrolling.write(enrolling.time.due())
    enrolling.clock.jump_wall(-DAY_S)
    assert phone.shows() == unused
    again = await enrolling.restarted()
    for place in (enrolling, again):
        with pytest.raises(NotPermitted):
            place.two_factor.prove("ada", HERE, used)
        with pytest.raises(NotPermitted):
            place.two_factor.prove("ada", HERE, unused)
    # The phone, whose clock is right, still opens.
    await prove(enrolling, phone.shows(DAY_S))


# ---- guessing ----


async def test_five_wrong_codes_then_not_even_the_right_one(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    for _ in range(5):
        with pytest.raises(NotPermitted, match="not right"):
            enrolling.two_factor.prove("ada", HERE, phone.wrong())
    for _ in range(100):
        with pytest.raises(TooManyRequests, match="Try again in 15 minutes") as caught:
            enrolling.two_factor.prove("ada", THERE, phone.shows())
        assert caught.value.retry_after_s == 900.0
    assert enrolling.counters["totp-wrong"] == 5
    assert enrolling.counters["totp-paused"] == 100
    await enrolling.clock.advance(900.0)
    await prove(enrolling, phone.shows())


async def test_the_five_tries_slide(enrolling: EnrolmentRooms, phone: Phone) -> None:
    for _ in range(5):
        with pytest.raises(NotPermitted):
            enrolling.two_factor.prove("ada", HERE, phone.wrong())
        await enrolling.clock.advance(100.0)
    await enrolling.clock.advance(400.0)  # the first of the five is 900 s old
    with pytest.raises(NotPermitted):
        enrolling.two_factor.prove("ada", HERE, phone.wrong())
    with pytest.raises(TooManyRequests, match="in 100 seconds") as caught:
        enrolling.two_factor.prove("ada", HERE, phone.shows())
    assert caught.value.retry_after_s == 100.0


@pytest.mark.usefixtures("phone")
async def test_ten_thousand_guesses_get_five_answers(enrolling: EnrolmentRooms) -> None:
    for number in range(10_000):
        with pytest.raises((NotPermitted, TooManyRequests)):
            enrolling.two_factor.prove("ada", HERE, f"{number:06}")
    assert enrolling.counters["totp-wrong"] == 5


@pytest.mark.parametrize("code", ["", "12345", "1234567", "12345x", "²²²²²²", "-12345", "1" * 9999])
async def test_what_is_no_code_is_no_try(
    enrolling: EnrolmentRooms, phone: Phone, code: str
) -> None:
    for _ in range(10):
        with pytest.raises(NotUnderstood, match="six digits"):
            enrolling.two_factor.prove("ada", HERE, code)
    await prove(enrolling, phone.shows())


async def test_a_code_is_read_as_apps_show_it(enrolling: EnrolmentRooms, phone: Phone) -> None:
    code = phone.shows()
    await prove(enrolling, f" {code[:3]} {code[3:]}")
    await enrolling.clock.advance(60.0)
    full_width = str.maketrans(
        "0123456789", "\uff10\uff11\uff12\uff13\uff14\uff15\uff16\uff17\uff18\uff19"
    )
    await prove(enrolling, phone.shows().translate(full_width))


async def test_anothers_code_is_wrong(enrolling: EnrolmentRooms, phone: Phone) -> None:
    await with_phone(enrolling, "bo")
    with pytest.raises(NotPermitted, match="not right"):
        enrolling.two_factor.prove("bo", HERE, phone.shows(30))


# ---- for how long ----


async def test_a_step_up_is_of_one_person_in_one_chat(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    await prove(enrolling, phone.shows())
    assert enrolling.two_factor.fresh("ada", HERE)
    for who, chat in (("ada", THERE), ("bo", HERE), ("ada", Chat("matrix", "1"))):
        with pytest.raises(NotPermitted):
            enrolling.two_factor.use(who, chat)


async def test_an_idle_hour_ends_it_and_every_use_begins_it_anew(
    enrolling: EnrolmentRooms, phone: Phone
) -> None:
    await prove(enrolling, phone.shows())
    for _ in range(3):
        await enrolling.clock.advance(3599.0)
        enrolling.two_factor.use("ada", HERE)
    await enrolling.clock.advance(3600.0)
    assert not enrolling.two_factor.fresh("ada", HERE)
    with pytest.raises(NotPermitted, match="six digits"):
        enrolling.two_factor.use("ada", HERE)


async def test_looking_does_not_prolong_it(enrolling: EnrolmentRooms, phone: Phone) -> None:
    await prove(enrolling, phone.shows())
    await enrolling.clock.advance(1800.0)
    assert enrolling.two_factor.fresh("ada", HERE)
    await enrolling.clock.advance(1800.0)
    assert not enrolling.two_factor.fresh("ada", HERE)


async def test_a_lock_ends_it_everywhere(enrolling: EnrolmentRooms, phone: Phone) -> None:
    await prove(enrolling, phone.shows())
    enrolling.two_factor.end("ada")
    assert not enrolling.two_factor.fresh("ada", HERE)
    assert enrolling.two_factor.is_set_up("ada")


# ---- lost phones, damage ----


@pytest.mark.usefixtures("phone")
async def test_another_admin_resets_a_lost_phone(enrolling: EnrolmentRooms) -> None:
    with pytest.raises(NotPermitted, match="Another admin"):
        enrolling.two_factor.reset("ada", "ada")
    records = enrolling.two_factor.reset("ada", "bo")
    assert isinstance(records[0], Decided)
    await enrolling.write(records)
    assert not enrolling.two_factor.is_set_up("ada")
    with pytest.raises(NotUnderstood, match="No phone"):
        enrolling.two_factor.reset("ada", "bo")
    await with_phone(enrolling)


@pytest.mark.parametrize("body", [b"\xc1", b"\x80", None])
async def test_a_damaged_phone_blocks_until_it_is_reset(
    enrolling: EnrolmentRooms, phone: Phone, body: bytes | None
) -> None:
    kept = (await enrolling.store.open()).facts["totp"][0]
    damaged = Fact(kind="totp", key="ada", body=kept.body if body is None else body)
    enrolling.two_factor.apply(damaged)
    for attempt in (
        lambda: enrolling.two_factor.prove("ada", HERE, phone.shows()),
        lambda: enrolling.two_factor.begin("ada", "Mallory", HERE),
    ):
        with pytest.raises(NotPermitted, match=words.PHONE_BROKEN):
            attempt()
    await enrolling.write(enrolling.two_factor.reset("ada", "bo"))
    await with_phone(enrolling)
