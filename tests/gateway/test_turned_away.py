"""Whoever tries what they may not is refused, told why, and counted for the security report.

Each case goes the whole way of a message; the sentences are the ones that people read.
"""

from __future__ import annotations

import re
from base64 import b32decode
from typing import TYPE_CHECKING

import pytest

from rosic.authoriser import two_factor
from rosic.authoriser.security_report import KINDS
from rosic.core.message import ChatKind
from tests.gateway.place import ADA, BO, STRANGER, VI, Place

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from typing import TypeAlias

    Case: TypeAlias = "Callable[[Place], Awaitable[str]]"

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
NOT_GOOD = "This code is not good here. Ask whoever invited you for a new one. Nothing was done."


async def invited(place: Place, *, account: str = ADA) -> str:
    found = CODE.search(await place.say("/invite operator omni for 2h", account=account))
    assert found is not None
    return found[0]


async def stranger_says(place: Place, text: str) -> str:
    return await place.say(text, account=STRANGER, chat=STRANGER)


async def tapped(place: Place, label: str, account: str) -> str:
    """Tap the newest button with a label; return what the tap itself was answered, and the rest."""
    button, under = place.button(label)
    told = await place.tap(button, under, account=account)
    answer = place.chat.answers[-1][1]
    return "\n".join(filter(None, (answer, told)))


# ---- each: what is tried, and what whoever tries it is told in the end ----


async def a_guessed_code(place: Place) -> str:
    return await stranger_says(place, "0000-0000")


async def a_sixth_guess(place: Place) -> str:
    for number in range(5):
        await stranger_says(place, f"0000-000{number}")
    return await stranger_says(place, await invited(place))


async def guesses_of_many(place: Place) -> str:
    code = await invited(place)
    for number in range(50):
        await place.say(f"0000-00{number:02}", account=f"9{number}", chat=f"9{number}")
    assert place.gateway.access.counters["code-unknown"] == 50
    alarm = "50 wrong codes came in within 60 minutes: somebody may be guessing."
    alarms = [t.outbound for t in place.chat.told if t.outbound.text.startswith(alarm)]
    assert [(out.chat.id, out.urgent) for out in alarms] == [(ADA, True)]
    await place.clock.advance(60.0)  # of strangers' wrong codes only so many are answered at once
    await stranger_says(place, "0000-0010")  # the second: they were among the fifty
    return await stranger_says(place, code)


async def a_used_code(place: Place) -> str:
    code = await invited(place)
    await stranger_says(place, code)
    assert "You are in, as operator on omni" in await tapped(place, "Join", STRANGER)
    return await place.say(code, account="98", chat="98")


async def two_redeemers(place: Place) -> str:
    code = await invited(place)
    buttons = {}
    for account in (STRANGER, "98"):
        await place.say(code, account=account, chat=account)
        buttons[account] = place.button("Join")
    before = len(place.chat.told)
    for account, (button, under) in buttons.items():
        place.chat.tap(button, under=under, account=account)
    await place.quiet()
    told = {t.outbound.chat.id: t.outbound.text for t in list(place.chat.told)[before:]}
    inside = [who for who in buttons if told[who].startswith("You are in")]
    assert len(inside) == 1
    (outside,) = set(buttons) - set(inside)
    return told[outside]


async def a_code_in_a_group(place: Place) -> str:
    code = await invited(place)
    told = await place.say(f"it is {code}", account=BO, chat="g", kind=ChatKind.GROUP)
    alarm, sentence = told.split("\n")
    assert alarm == (
        "A code for operator on omni for 2 hours was shown in a group. It is not good any more. "
        "Invite again, and send the code to one person."
    )
    assert await stranger_says(place, code) == NOT_GOOD, "it is burnt"
    return sentence


async def an_expired_code(place: Place) -> str:
    code = await invited(place)
    await place.clock.advance(601.0)
    return await stranger_says(place, code)


async def a_code_of_an_issuer_who_was_locked(place: Place) -> str:
    code = await invited(place)
    access = place.gateway.access
    async with access.changes.turn() as turn:
        ada = place.gateway.rooms.authoriser.directory.named("Ada")[0].id
        await turn.act(access.locks.lock(ada, "operator"))
    return await stranger_says(place, code)


async def somebody_elses_button(place: Place) -> str:
    await place.say("use omni")
    await place.tap(*place.button("Wave"))
    return await tapped(place, "Do it", BO)


async def a_double_tap(place: Place) -> str:
    await place.say("use omni")
    await place.tap(*place.button("Wave"))
    button, under = place.button("Do it")
    await place.tap(button, under)
    assert place.acted() == 1
    assert await place.tap(button, under) == ""
    assert place.acted() == 1
    return place.chat.answers[-1][1]


async def a_late_tap(place: Place) -> str:
    await place.say("use omni")
    await place.tap(*place.button("Wave"))
    button, under = place.button("Do it")
    await place.clock.advance(61.0)  # it is on the screen no more; a tap may be on its way
    said = await place.tap(button, under)
    return "\n".join(filter(None, (place.chat.answers[-1][1], said)))


async def somebody_elses_invitation(place: Place) -> str:
    await stranger_says(place, await invited(place))
    return await tapped(place, "Join", BO)


async def phone(place: Place) -> Callable[[], str]:
    """Set up Bo's phone; return what shows its code now."""
    said = await place.say("/authenticator", account=BO, chat=BO)
    key = said.partition("Or type this key there: ")[2].splitlines()[0].replace(" ", "")
    secret = b32decode(key + "=" * (-len(key) % 8))

    def shows() -> str:
        return two_factor.hotp(secret, two_factor.step_at(place.gateway.access.time.wall_ns()))

    await place.say(f"/code {shows()}", account=BO, chat=BO)
    return shows


async def a_phone_code_again(place: Place) -> str:
    shows = await phone(place)
    return await place.say(f"/code {shows()}", account=BO, chat=BO)


async def a_phone_code_again_in_another_chat(place: Place) -> str:
    shows = await phone(place)
    await place.clock.advance(31.0)
    code = shows()
    await place.say(f"/code {code}", account=BO, chat=BO)
    return await place.say(f"/code {code}", account=BO, chat="g", kind=ChatKind.GROUP)


async def a_sixth_wrong_phone_code(place: Place) -> str:
    await phone(place)
    for _ in range(5):
        told = await place.say("/code 000000", account=BO, chat=BO)
        assert told == "This code is not right. Nothing was done."
    return await place.say("/code 000000", account=BO, chat=BO)


async def a_stranger(place: Place) -> str:
    return await stranger_says(place, "omni wave")


async def a_person_without_the_right(place: Place) -> str:
    return await place.say("omni wave", account=VI, chat=VI)


async def a_locked_person(place: Place) -> str:
    await place.say("/lock Bo")
    return await place.say("omni wave", account=BO, chat=BO)


CASES: list[tuple[Case, str, dict[str, int]]] = [
    (a_guessed_code, NOT_GOOD, {"code-unknown": 1}),
    (
        a_sixth_guess,
        "Too many wrong codes. Try again in 15 minutes, or ask whoever invited you.",
        {"code-unknown": 5, "code-paused": 1},
    ),
    (
        guesses_of_many,
        "Too many wrong codes. Try again in 60 minutes, or ask whoever invited you.",
        {"code-unknown": 51, "code-breaker": 1, "code-paused": 1},
    ),
    (a_used_code, NOT_GOOD, {"code-used": 1}),
    (two_redeemers, NOT_GOOD, {"code-used": 1}),
    (
        a_code_in_a_group,
        (
            "A code is only good in a private chat with me, and one that was shown here is not "
            "good any more. Ask whoever invited you for a new one."
        ),
        {"code-in-group": 1, "code-burnt": 1},
    ),
    (an_expired_code, NOT_GOOD, {"code-expired": 1}),
    (a_code_of_an_issuer_who_was_locked, NOT_GOOD, {"code-withdrawn": 1}),
    (somebody_elses_button, "This question was asked of somebody else.", {"button-other": 1}),
    (a_double_tap, "This button is no longer good. Nothing was done.", {"button-used": 1}),
    (a_late_tap, "This button is too old. Nothing was done.", {"button-late": 1}),
    (
        somebody_elses_invitation,
        "This question was asked of somebody else.",
        {"button-other": 1},
    ),
    (
        a_phone_code_again,
        "This code was used before. Wait for the next one. Nothing was done.",
        {"totp-replayed": 1},
    ),
    (
        a_phone_code_again_in_another_chat,
        "This code was used before. Wait for the next one. Nothing was done.",
        {"totp-replayed": 1},
    ),
    (
        a_sixth_wrong_phone_code,
        "Too many wrong codes. Try again in 15 minutes. Nothing was done.",
        {"totp-wrong": 5, "totp-paused": 1},
    ),
    (
        a_stranger,
        "Hello. I work for people I know, and I do not know you yet. Ask the admin here.",
        {"stranger": 1},
    ),
    (
        a_person_without_the_right,
        'Wave needs the right "operator" on omni. Ada can give it. It counts at once.',
        {"no-right": 1},
    ),
    (
        a_locked_person,
        "Your access is locked. The admin of this place can unlock it. Stop still works.",
        {"locked": 1},
    ),
]


@pytest.mark.parametrize(("case", "told", "counted"), CASES, ids=[c[0].__name__ for c in CASES])
async def test_it_is_refused_told_and_counted(
    case: Case, told: str, counted: dict[str, int]
) -> None:
    async with Place().open() as place:
        acted = 1 if case is a_double_tap else 0
        assert await case(place) == told
        assert place.acted() == acted, "nothing more moved"
        counters = place.gateway.access.counters.by_kind()
        assert counters == counted
        lines = place.gateway.access.security.text().splitlines()
        assert f"Unauthorised attempts since the first start: {sum(counted.values())}" in lines
        for kind, count in counted.items():
            assert f"  {KINDS[kind]}: {count}" in lines


async def test_what_was_counted_is_not_lost_by_ending() -> None:
    async with Place().open() as place:
        await a_stranger(place)
        await a_person_without_the_right(place)
    async with Place(place.store, clock=place.clock).open() as again:
        assert again.gateway.access.counters.by_kind() == {"stranger": 1, "no-right": 1}


async def test_a_stranger_is_told_once_and_not_again_soon() -> None:
    async with Place().open() as place:
        assert "I do not know you yet" in await stranger_says(place, "omni wave")
        for text in ("hello", "omni wave", "/me"):
            await place.clock.advance(60.0)
            assert await stranger_says(place, text) == ""
        other = await place.say("hello", account="98", chat="98")
        assert "I do not know you yet" in other, "nobody is kept out by somebody else"
        await place.clock.advance(600.0)
        assert "I do not know you yet" in await stranger_says(place, "hello")
        assert place.acted() == 0


async def test_a_stranger_hears_that_nothing_was_stopped_whatever_was_said_before() -> None:
    nothing = (
        "I do not know you, so I stopped nothing. Use the stop button of the robot itself, or ask "
        "the admin here."
    )
    async with Place().open() as place:
        assert "I do not know you yet" in await stranger_says(place, "hello")
        assert await stranger_says(place, "STOP!") == nothing
        for text in ("stop", "stop omni", "notaus", "hello"):
            await place.clock.advance(60.0)
            assert await stranger_says(place, text) == "", "once, and not again soon"
        await place.clock.advance(600.0)
        assert await stranger_says(place, "hör auf") == nothing
        assert not any(robot.gate.latched for robot in place.gateway.robots.values())


async def test_whose_access_has_ended_hears_that_nothing_was_stopped() -> None:
    async with Place().open() as place:
        await place.revoke("Bo")
        await place.say("resume all")
        told = await place.say("stop", account=BO, chat=BO)
        assert told == (
            "I stopped nothing. Use the stop button of the robot itself. Your access here has "
            "ended. The admin of this place can renew it."
        )
        assert await place.say("stop", account=BO, chat="g", kind=ChatKind.GROUP) == ""
        assert not any(robot.gate.latched for robot in place.gateway.robots.values())
