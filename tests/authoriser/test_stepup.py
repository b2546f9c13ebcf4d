"""Codes of a phone before dangerous things: once each, not too often, and not for long."""

from __future__ import annotations

from base64 import b32decode
from urllib.parse import parse_qs, urlsplit

import pytest

from rosic.authoriser import keys_messages as words
from rosic.authoriser.totp import hotp, step_at
from rosic.core.message import Chat, ChatKind
from rosic.core.records import Decided, Fact
from rosic.errors import (
    Expired,
    NotPermitted,
    NotUnderstood,
    RecordUnavailable,
    TooManyRequests,
)
from tests.authoriser.office import Office

HERE = Chat("telegram", "1")
THERE = Chat("telegram", "2")
GROUP = Chat("telegram", "-3", ChatKind.GROUP)
DAY_S = 86_400.0


class Phone:
    """Ada's phone: shows what an authenticator app shows, by its own right clock."""

    def __init__(self, secret: bytes, office: Office) -> None:
        self.secret = secret
        self.office = office

    def shows(self, later_s: float = 0.0) -> str:
        return hotp(self.secret, step_at(self.office.clock.wall_ns() + int(later_s * 1e9)))

    def wrong(self) -> str:
        right = {self.shows(shift) for shift in (-30, 0, 30)}
        return next(code for code in map("{:06}".format, range(10)) if code not in right)


async def with_phone(office: Office, who: str = "ada") -> Phone:
    setup = office.stepup.begin(who, "Ada", HERE)
    secret = b32decode(parse_qs(urlsplit(setup.uri.reveal()).query)["secret"][0])
    phone = Phone(secret, office)
    await prove(office, phone.shows(), who, finish=True)
    return phone


async def prove(
    office: Office, code: str, who: str = "ada", chat: Chat = HERE, *, finish: bool = False
) -> None:
    check = office.stepup.finish if finish else office.stepup.prove
    proof = check(who, chat, code)
    await office.write(proof.records)
    office.stepup.admit(proof)


@pytest.fixture
async def office() -> Office:
    return await Office().with_admins()


@pytest.fixture
async def phone(office: Office) -> Phone:
    found = await with_phone(office)
    office.stepup.end("ada")
    await office.clock.advance(60.0)
    return found


async def test_setting_up_takes_a_code_back(office: Office) -> None:
    with pytest.raises(NotPermitted, match="none is set up"):
        office.stepup.use("ada", HERE)
    await with_phone(office)
    assert office.stepup.is_set_up("ada")
    office.stepup.use("ada", HERE)
    facts = (await office.store.open()).facts["totp"]
    assert facts[0].letter is not None
    assert facts[0].letter.container == "ada"
    assert facts[0].letter.content not in facts[0].body


async def test_nothing_is_kept_until_the_code_has_come_back(office: Office) -> None:
    setup = office.stepup.begin("ada", "Ada", HERE)
    assert setup.key.reveal() in setup.sentence
    assert office.stepup.is_setting_up("ada")
    with pytest.raises(NotPermitted, match="not right"):
        office.stepup.finish("ada", HERE, "000000")
    assert not office.stepup.is_set_up("ada")
    await office.clock.advance(601.0)
    assert not office.stepup.is_setting_up("ada")
    with pytest.raises(Expired, match="Begin again"):
        office.stepup.finish("ada", HERE, "000000")


async def test_a_secret_is_shown_in_private_only(office: Office) -> None:
    with pytest.raises(NotPermitted, match="private chat"):
        office.stepup.begin("ada", "Ada", GROUP)
    office.stepup.begin("ada", "Ada", HERE)
    with pytest.raises(NotPermitted, match="private chat"):
        office.stepup.finish("ada", GROUP, "000000")
    assert office.tally["totp-in-group"] == 1


async def test_a_thief_cannot_put_their_phone_in_place_of_the_owners(
    office: Office, phone: Phone
) -> None:
    with pytest.raises(NotPermitted, match="Give its present code first"):
        office.stepup.begin("ada", "Ada", HERE)
    await prove(office, phone.shows())
    office.stepup.begin("ada", "Ada", HERE)


# ---- replays ----


async def test_a_code_is_good_once(office: Office, phone: Phone) -> None:
    code = phone.shows()
    await prove(office, code)
    for chat in (HERE, THERE, GROUP):
        with pytest.raises(NotPermitted, match="used before"):
            await prove(office, code, chat=chat)
    assert office.tally["totp-replayed"] == 3


async def test_a_double_tap_before_anything_is_written_counts_once(
    office: Office, phone: Phone
) -> None:
    code = phone.shows()
    proof = office.stepup.prove("ada", HERE, code)
    with pytest.raises(NotPermitted, match="used before"):
        office.stepup.prove("ada", THERE, code)
    with pytest.raises(RecordUnavailable):
        office.stepup.admit(proof)  # not written yet: it does not count
    assert not office.stepup.fresh("ada", HERE)
    await office.write(proof.records)
    office.stepup.admit(proof)
    assert office.stepup.fresh("ada", HERE)


async def test_an_earlier_code_is_not_good_after_a_later_one(office: Office, phone: Phone) -> None:
    earlier, later = phone.shows(-30), phone.shows(30)
    await prove(office, later)
    for code in (earlier, phone.shows(), later):
        with pytest.raises(NotPermitted, match="used before"):
            await prove(office, code)
    await office.clock.advance(60.0)
    await prove(office, phone.shows())


async def test_a_code_used_before_a_restart_is_used(office: Office, phone: Phone) -> None:
    code = phone.shows()
    await prove(office, code)
    again = await office.restarted()
    with pytest.raises(NotPermitted, match="used before"):
        again.stepup.prove("ada", HERE, code)
    assert not again.stepup.fresh("ada", HERE)  # a step-up is never written down


async def test_a_clock_set_back_a_day_revives_no_code(office: Office, phone: Phone) -> None:
    used = phone.shows()
    await prove(office, used)
    await office.clock.advance(60.0)
    unused = phone.shows()  # somebody saw it on the phone
    await office.clock.advance(DAY_S)
    await office.write(office.time.due())
    office.clock.jump_wall(-DAY_S)
    assert phone.shows() == unused
    again = await office.restarted()
    for place in (office, again):
        with pytest.raises(NotPermitted):
            place.stepup.prove("ada", HERE, used)
        with pytest.raises(NotPermitted):
            place.stepup.prove("ada", HERE, unused)
    # The phone, whose clock is right, still opens.
    await prove(office, phone.shows(DAY_S))


# ---- guessing ----


async def test_five_wrong_codes_then_not_even_the_right_one(office: Office, phone: Phone) -> None:
    for _ in range(5):
        with pytest.raises(NotPermitted, match="not right"):
            office.stepup.prove("ada", HERE, phone.wrong())
    for _ in range(100):
        with pytest.raises(TooManyRequests, match="Try again in 15 minutes") as caught:
            office.stepup.prove("ada", THERE, phone.shows())
        assert caught.value.retry_after_s == 900.0
    assert office.tally["totp-wrong"] == 5
    assert office.tally["totp-paused"] == 100
    await office.clock.advance(900.0)
    await prove(office, phone.shows())


async def test_the_five_tries_slide(office: Office, phone: Phone) -> None:
    for _ in range(5):
        with pytest.raises(NotPermitted):
            office.stepup.prove("ada", HERE, phone.wrong())
        await office.clock.advance(100.0)
    await office.clock.advance(400.0)  # the first of the five is 900 s old
    with pytest.raises(NotPermitted):
        office.stepup.prove("ada", HERE, phone.wrong())
    with pytest.raises(TooManyRequests, match="in 100 seconds") as caught:
        office.stepup.prove("ada", HERE, phone.shows())
    assert caught.value.retry_after_s == 100.0


@pytest.mark.usefixtures("phone")
async def test_ten_thousand_guesses_get_five_answers(office: Office) -> None:
    for number in range(10_000):
        with pytest.raises((NotPermitted, TooManyRequests)):
            office.stepup.prove("ada", HERE, f"{number:06}")
    assert office.tally["totp-wrong"] == 5


@pytest.mark.parametrize("code", ["", "12345", "1234567", "12345x", "²²²²²²", "-12345", "1" * 9999])
async def test_what_is_no_code_is_no_try(office: Office, phone: Phone, code: str) -> None:
    for _ in range(10):
        with pytest.raises(NotUnderstood, match="six digits"):
            office.stepup.prove("ada", HERE, code)
    await prove(office, phone.shows())


async def test_a_code_is_read_as_apps_show_it(office: Office, phone: Phone) -> None:
    code = phone.shows()
    await prove(office, f" {code[:3]} {code[3:]}")
    await office.clock.advance(60.0)
    full_width = str.maketrans(
        "0123456789", "\uff10\uff11\uff12\uff13\uff14\uff15\uff16\uff17\uff18\uff19"
    )
    await prove(office, phone.shows().translate(full_width))


async def test_anothers_code_is_wrong(office: Office, phone: Phone) -> None:
    await with_phone(office, "bo")
    with pytest.raises(NotPermitted, match="not right"):
        office.stepup.prove("bo", HERE, phone.shows(30))


# ---- for how long ----


async def test_a_step_up_is_of_one_person_in_one_chat(office: Office, phone: Phone) -> None:
    await prove(office, phone.shows())
    assert office.stepup.fresh("ada", HERE)
    for who, chat in (("ada", THERE), ("bo", HERE), ("ada", Chat("matrix", "1"))):
        with pytest.raises(NotPermitted):
            office.stepup.use(who, chat)


async def test_an_idle_hour_ends_it_and_every_use_begins_it_anew(
    office: Office, phone: Phone
) -> None:
    await prove(office, phone.shows())
    for _ in range(3):
        await office.clock.advance(3599.0)
        office.stepup.use("ada", HERE)
    await office.clock.advance(3600.0)
    assert not office.stepup.fresh("ada", HERE)
    with pytest.raises(NotPermitted, match="six digits"):
        office.stepup.use("ada", HERE)


async def test_looking_does_not_prolong_it(office: Office, phone: Phone) -> None:
    await prove(office, phone.shows())
    await office.clock.advance(1800.0)
    assert office.stepup.fresh("ada", HERE)
    await office.clock.advance(1800.0)
    assert not office.stepup.fresh("ada", HERE)


async def test_a_lock_ends_it_everywhere(office: Office, phone: Phone) -> None:
    await prove(office, phone.shows())
    office.stepup.end("ada")
    assert not office.stepup.fresh("ada", HERE)
    assert office.stepup.is_set_up("ada")


# ---- lost phones, damage ----


@pytest.mark.usefixtures("phone")
async def test_another_admin_resets_a_lost_phone(office: Office) -> None:
    with pytest.raises(NotPermitted, match="Another admin"):
        office.stepup.reset("ada", "ada")
    records = office.stepup.reset("ada", "bo")
    assert isinstance(records[0], Decided)
    await office.write(records)
    assert not office.stepup.is_set_up("ada")
    with pytest.raises(NotUnderstood, match="No phone"):
        office.stepup.reset("ada", "bo")
    await with_phone(office)


@pytest.mark.parametrize("body", [b"\xc1", b"\x80", None])
async def test_a_damaged_phone_blocks_until_it_is_reset(
    office: Office, phone: Phone, body: bytes | None
) -> None:
    kept = (await office.store.open()).facts["totp"][0]
    damaged = Fact(kind="totp", key="ada", body=kept.body if body is None else body)
    office.stepup.apply(damaged)
    for attempt in (
        lambda: office.stepup.prove("ada", HERE, phone.shows()),
        lambda: office.stepup.begin("ada", "Mallory", HERE),
    ):
        with pytest.raises(NotPermitted, match=words.PHONE_BROKEN):
            attempt()
    await office.write(office.stepup.reset("ada", "bo"))
    await with_phone(office)
