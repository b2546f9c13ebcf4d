"""`/grant`: a right for somebody who is in, for a while, by somebody who may give it."""

from __future__ import annotations

import pytest

from tests.features.access.access_gateway import ADA, BO, EVE, TIM, VI, house


async def test_an_admin_gives_a_role_for_a_while_and_takes_it_back() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi operator kuka1 with distance <= 1 m for 2h")
        what = "operator on kuka1, with distance <= 1 m, until tomorrow 00:13"
        assert told == f"Vi has been told: {what}."
        assert place.newest(VI).text == f"Ada gave you: {what}."
        assert place.newest(EVE).text == f"Ada gave Vi: {what}."
        assert what in await place.line(VI, "/me")
        assert what in await place.line(ADA, "/people")
        await place.line(VI, "kuka1 move 2 m")
        assert place.acted("kuka1") == 0
        await place.line(VI, "kuka1 move 1 m")
        assert place.acted("kuka1") == 1
        told = await place.line(ADA, "/grant Vi operator omni for 2h")
        await place.press(ADA, "Take it back")
        assert place.newest(VI).text == "Ada took back: operator on omni, until tomorrow 00:13."
        await place.line(VI, "omni wave")
        assert place.acted() == 0


async def test_what_ends_soon_ends_what_moves_under_it_though_it_was_given_just_now() -> None:
    async with house() as place:
        place.robot("omni").work_s = 60.0
        await place.line(ADA, "/grant Vi operator omni for 10 s")
        await place.line(VI, "omni move 1 m")
        before = len(place.chat.told)
        await place.pass_s(9.5)
        assert not place.told(VI, before)
        await place.pass_s(1.0)
        assert "Your right has ended: operator on omni." in place.told(VI, before)
        assert place.gateway.rooms.organiser.holder("omni") is None
        [life] = [t for t in place.chat.told if "omni: move" in t.outbound.text][-1:]
        assert "stopped before it ended" in place.chat.shown(life.message).text


async def test_nobody_gives_what_outlives_their_own_right() -> None:
    async with house() as place:
        await place.line(ADA, "/grant Bo admin for 1h")
        for line in ("operator omni for 2h", "admin for 61 min"):
            told = await place.line(BO, f"/grant Vi {line}")
            assert "your own right to give it ends sooner. Say a shorter time." in told
        assert "ends sooner" in await place.line(BO, "/grant Vi admin")
        assert (await place.line(BO, "/grant Vi operator omni for 50 min")).startswith("Vi has")
        await place.line(VI, "omni wave")
        assert place.acted() == 1


async def test_what_is_given_for_good_is_confirmed_first() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi operator omni")
        assert told == "Give Vi for good: operator on omni?"
        await place.line(VI, "omni wave")
        assert place.acted() == 0
        assert await place.press(ADA, "Give it") == "Vi has been told: operator on omni."
        await place.line(VI, "omni wave")
        assert place.acted() == 1


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("/grant", "Whom, what, where and for how long?"),
        ("/grant Xaver operator omni", 'I know nobody called "Xaver". Nothing was done.'),
        ("/grant Vi", "As what? The roles here are"),
        ("/grant Vi operator omni for ever", 'I cannot read "ever" as a length of time.'),
        ("/grant Vi operator omni with force <= 5 N", "No skill given here has a parameter"),
        ("/grant Vi operatr omni", 'I know no role and no robot called "operatr".'),
        ("/grant Vi operator omni for 0 min", "A right lasts at least a second."),
        ("/grant Vi operator omni for 2 bananas", 'I cannot read "2 bananas" as a length of'),
        ("/grant Vi operator omni for", "How long?"),
        ("/grant Vi omni:fly for 2h", "omni has no skill 'fly'."),
        ("/grant Vi onmi:move for 2h", "No robot or group is called 'onmi'. Did you mean omni?"),
        ("/grant Vi omni:move on kuka1 for 2h", "omni:move says already on which robot"),
        ("/grant Vi omni:move with distance <= 1 kg for 2h", "On omni, 'distance <= 1 kg'"),
        ("/grant Vi omni:move with distance < 1 m for 2h", "'distance < 1 m' leaves open"),
    ],
)
async def test_a_gift_that_makes_no_sense_gives_nothing(line: str, said: str) -> None:
    async with house() as place:
        assert (await place.line(ADA, line)).startswith(said)
        assert not place.gateway.authority.grants_book.next_end_ns(0)


async def test_a_single_right_is_given_with_its_limit_and_ends() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi omni:move with distance <= 1 m for 2h")
        assert told == (
            "Vi has been told: move on omni, with distance <= 1 m, until tomorrow 00:13."
        )
        await place.line(VI, "omni move 2 m")
        await place.line(VI, "omni wave")
        assert place.acted() == 0
        await place.line(VI, "omni move 1 m")
        assert place.acted() == 1
        await place.pass_s(2 * 3_600 + 1)
        await place.line(VI, "omni move 1 m")
        assert place.acted() == 1


async def test_a_single_right_after_with_only_says_what_is_limited() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi operator with omni:move distance <= 1 m for 2h")
        assert "operator, with omni:move distance <= 1 m, until" in told
        await place.line(VI, "omni move 2 m")
        assert place.acted() == 0
        await place.line(VI, "kuka1 move 2 m")
        assert place.acted("kuka1") == 1


async def test_whoever_gives_rights_on_one_robot_gives_single_ones_there_only() -> None:
    async with house() as place:
        told = await place.line(TIM, "/grant Vi kuka1:wave for 1h")
        assert told.startswith("Vi has been told: wave on kuka1")
        for scope in ("omni:wave", "kuka1:grant", "*:wave", "fleet:lock"):
            told = await place.line(TIM, f"/grant Vi {scope} for 1h")
            assert "it is more than you may give" in told, scope


async def test_who_gives_no_rights_learns_nobodys_name() -> None:
    async with house() as place:
        for line in ("/grant Vi operator omni for 1h", "/grant Xaver operator omni", "/grant"):
            told = await place.line(BO, line)
            assert told == "That is not yours to give. Ada or Eve can. Nothing was done."
        told = await place.line(TIM, "/grant Vi operator omni for 1h")
        assert told.startswith("You cannot give operator on omni")
        assert (await place.line(TIM, "/grant Vi operator kuka1 for 1h")).startswith("Vi has been")
        assert (await place.line(TIM, "/grant Vi senior kuka1 for 1h")).startswith("You cannot")
