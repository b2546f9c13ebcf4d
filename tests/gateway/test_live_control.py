"""Live orders in a whole gateway: begun like any other, steered by samples, ended for good."""

from __future__ import annotations

from math import inf, nan, radians
from typing import TYPE_CHECKING

import pytest

from rosic.core.order import OrderEnding
from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules, SkillPrecondition
from rosic.core.records import Fact
from rosic.core.sample_gate import CONTROLS_SILENT, LIVE_TIME_OVER, SampleVerdict
from rosic.errors import Expired, RobotBusy
from rosic.gateway.requests import line_id
from tests.gateway.place import BO, VI
from tests.gateway.steering import (
    Hand,
    driven,
    hand,
    live,
    ordered,
    person,
    said,
    steered,
    tapped_live,
)

if TYPE_CHECKING:
    from tests.gateway.place import Place

TAKEN, LATE, OVER = SampleVerdict.TAKEN, SampleVerdict.LATE, SampleVerdict.OVER


async def test_it_is_an_order_like_any_other_and_done_when_let_go() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.5, linear=0.3)
        await steers.hold(0.5, linear=-0.2, angular=45)
        steers.input.release()
        await place.quiet()
        outcome = await steers.input.ended()
        assert outcome.ending is OrderEnding.DONE
        assert outcome.note == "drove live for 1.0 s"
        assert driven(place) == [0.3, -0.2, 0.0]
        assert driven(place, "angular")[1] == pytest.approx(radians(45))
        assert place.acted() == 1
        assert "omni: drive, live" in said(place)
        assert "done" in said(place)
        # Not where it began, with the least duration there is.
        [past] = (await place.say("/history")).splitlines()
        assert " · omni: drive, live · done " in past
        assert past.endswith(": drove live for 1.0 s")


async def test_nothing_moves_before_the_first_sample_and_without_one_it_ends() -> None:
    async with steered() as place:
        steers = await hand(place)
        await place.clock.advance(1.9)
        assert steers.input.outcome is None
        assert place.acted() == 0
        await place.clock.advance(0.2)
        outcome = steers.input.outcome
        assert outcome is not None
        assert (outcome.ending, outcome.code) == (OrderEnding.CANCELLED, CONTROLS_SILENT)
        assert outcome.note == "the controls never said anything, so it did not move"
        assert place.acted() == 0


@pytest.mark.parametrize("again_after_s", [0.31, 1.0])
async def test_silence_ends_it_for_good(again_after_s: float) -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.5, linear=0.3)
        # The last of them was sent 0.05 s ago.
        await place.clock.advance(again_after_s - 0.05)
        assert steers.put(linear=0.3).verdict is OVER
        await steers.hold(1.0, linear=0.3)
        outcome = await steers.input.ended()
        assert (outcome.ending, outcome.code) == (OrderEnding.CANCELLED, CONTROLS_SILENT)
        assert outcome.note.startswith("the controls fell silent; drove live for ")
        assert driven(place) == [0.3, 0.0]
        assert "the controls fell silent" in said(place)


async def test_a_gap_that_is_shorter_ends_nothing() -> None:
    async with steered() as place:
        steers = await hand(place)
        for _ in range(10):
            assert steers.put(linear=0.3).taken
            await place.clock.advance(0.29)
        assert steers.input.outcome is None


async def test_it_counts_from_when_a_sample_was_sent() -> None:
    """One that took 0.25 s keeps it moving for 0.05 s, not for 0.3 s."""
    async with steered() as place:
        steers = await hand(place)
        assert steers.put(linear=0.3).taken
        await place.clock.advance(0.25)
        assert steers.put(0.25, linear=0.4).taken
        await place.clock.advance(0.06)
        assert steers.input.outcome is not None


async def test_samples_that_are_late_or_out_of_order_steer_nothing() -> None:
    async with steered() as place:
        steers = await hand(place)
        assert steers.put(linear=0.3).taken
        await place.clock.advance(0.1)
        now_ns = steers.now_ns()
        assert steers.input.put({"linear": 0.5}, now_ns, 5).taken
        assert steers.input.put({"linear": 0.6}, now_ns, 5).verdict is SampleVerdict.DISORDERED
        assert steers.input.put({"linear": 0.6}, now_ns, 4).verdict is SampleVerdict.DISORDERED
        late_ns = steers.now_ns(0.31)
        assert steers.input.put({"linear": 0.6}, late_ns, 6).verdict is LATE
        other = steers.input.put({"linear": 0.6}, now_ns, 7, b"another order")
        assert other.verdict is SampleVerdict.ANOTHER
        await place.clock.advance(0.05)
        assert driven(place) == [0.3, 0.5]
        assert steers.input.counts[LATE] == 1
        assert steers.input.counts[SampleVerdict.DISORDERED] == 2


@pytest.mark.parametrize("value", [nan, inf, -inf, 10**400, True, "0.5", None, [0.5]])
async def test_what_is_no_finite_number_steers_nothing(value: object) -> None:
    async with steered() as place:
        steers = await hand(place)
        assert steers.put(linear=0.3).taken
        result = steers.put(linear=value)  # type: ignore[arg-type]
        assert result.verdict is SampleVerdict.NO_NUMBER
        assert result.sentence == "linear is no finite number."
        await place.clock.advance(0.05)
        assert driven(place) == [0.3]


@pytest.mark.parametrize("number", [nan, 1.0, "7", None, True])
async def test_a_number_or_a_time_that_is_none_steers_nothing(number: object) -> None:
    async with steered() as place:
        steers = await hand(place)
        no_time = steers.input.put({"linear": 0.3}, number, 1)  # type: ignore[arg-type]
        no_number = steers.input.put({"linear": 0.3}, steers.now_ns(), number)  # type: ignore[arg-type]
        assert {no_time.verdict, no_number.verdict} == {SampleVerdict.NO_NUMBER}


async def test_what_the_skill_does_not_take_is_said() -> None:
    async with steered() as place:
        steers = await hand(place)
        for name in ("duration", "height"):
            result = steers.put(**{name: 0.1})
            assert result.verdict is SampleVerdict.UNFIT
            assert result.sentence == f"{name} cannot be steered."


async def test_bounds_hold_and_that_is_told() -> None:
    async with steered() as place:
        steers = await hand(place)
        result = steers.put(linear=5.0, lateral=-5.0, angular=10)
        assert result.taken
        assert result.clamped == ("linear", "lateral")
        await place.clock.advance(0.05)
        assert place.robot("omni").steered[-1]["linear"] == 0.8
        assert place.robot("omni").steered[-1]["lateral"] == -0.8


CAPPED = RoleRules(
    roles={**DEFAULT_ROLES, "junior": Role(scopes=("*:*",), limits=("linear <= 0.2 m/s",))}
)


async def test_the_limits_of_whoever_steers_hold() -> None:
    async with steered(CAPPED, {"Bo": "junior"}) as place:
        steers = await hand(place, BO)
        assert steers.put(linear=0.8, angular=20).clamped == ("linear",)
        await place.clock.advance(0.05)
        assert steers.put(linear=-0.8).clamped == ("linear",)
        await place.clock.advance(0.05)
        assert driven(place) == pytest.approx([0.2, -0.2])


async def test_limits_that_leave_no_rest_let_nobody_drive() -> None:
    """Else letting the stick go would be clamped to a motion."""
    junior = Role(scopes=("*:*",), limits=("linear >= 0.1 m/s", "lateral >= 0 m/s"))
    rulebook = RoleRules(roles={**DEFAULT_ROLES, "junior": junior})
    async with steered(rulebook, {"Bo": "junior"}) as place:
        line = live(place).line("omni", "drive").replace("linear=0 ", "linear=0.1 ")
        await ordered(place, account=BO, text=line)
        assert "omni cannot be driven live here: its linear can never be zero." in said(place)
        assert place.acted() == 0


@pytest.mark.parametrize(("limit", "lasts_s"), [("duration <= 2 s", 2.0), ("linear <= 1 m/s", 600)])
async def test_nobody_drives_for_ever(limit: str, lasts_s: float) -> None:
    junior = Role(scopes=("*:*",), limits=(limit,))
    rulebook = RoleRules(roles={**DEFAULT_ROLES, "junior": junior})
    async with steered(rulebook, {"Bo": "junior"}) as place:
        steers = await hand(place, BO)
        held_s = 0.0
        while steers.input.outcome is None and held_s < 2 * lasts_s:
            await steers.hold(0.25, linear=0.1)
            held_s += 0.25
        outcome = steers.input.outcome
        assert outcome is not None
        assert lasts_s <= held_s <= lasts_s + 0.5
        assert (outcome.ending, outcome.code) == (OrderEnding.CANCELLED, LIVE_TIME_OVER)
        said_so = "10 minutes" if lasts_s == 600 else "no longer than 2 s"
        assert said_so in outcome.note


@pytest.mark.parametrize("before_s", [0.0, 0.05, 0.5])
async def test_a_stop_ends_it_at_any_moment(before_s: float) -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(before_s, linear=0.3)
        assert "at rest" in await place.say("stop")
        assert steers.put(linear=0.3).verdict is OVER
        await steers.hold(1.0, linear=0.3)
        assert (await steers.input.ended()).ending is OrderEnding.CANCELLED
        assert driven(place) == ([0.3, 0.0] if before_s else [])


async def test_a_cancel_ends_it() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        await place.say("cancel")
        assert steers.put(linear=0.3).verdict is OVER
        assert (await steers.input.ended()).ending is OrderEnding.CANCELLED


async def test_whoever_is_revoked_steers_no_further() -> None:
    async with steered() as place:
        steers = await hand(place, BO)
        await steers.hold(0.2, linear=0.3)
        await place.revoke("Bo")
        assert steers.put(linear=0.3).verdict is OVER
        outcome = await steers.input.ended()
        assert outcome.ending is OrderEnding.CANCELLED
        assert driven(place) == [0.3, 0.0]


async def test_other_limits_hold_from_the_next_sample_on() -> None:
    """The policy has moved: it is admitted once more, and what it allows counts."""
    async with steered(CAPPED) as place:
        steers = await hand(place, BO)
        await steers.hold(0.2, linear=0.5)
        regrant(place, BO, "junior")
        await steers.hold(0.2, linear=0.5)
        assert steers.input.outcome is None
        assert driven(place) == pytest.approx([0.5, 0.2])


async def test_a_right_that_is_gone_ends_it_and_says_why() -> None:
    async with steered() as place:
        steers = await hand(place, BO)
        await steers.hold(0.2, linear=0.5)
        regrant(place, BO, "viewer")
        assert steers.put(linear=0.5).verdict is OVER
        outcome = await steers.input.ended()
        assert outcome.ending is OrderEnding.CANCELLED
        assert outcome.note.startswith("it may not go on: ")
        assert driven(place) == [0.5, 0.0]


def regrant(place: Place, account: str, role: str, *grants: Grant) -> None:
    """Give somebody other rights; what is under way is not looked at because of it."""
    policy, who = place.gateway.authority, person(place, account)
    policy.grants_book.set_roles(who, (role,))
    for record in policy.grants_book.give(who, grants, ""):
        if isinstance(record, Fact):
            policy.grants_book.apply(record)
    policy.renew(who)


async def test_a_clock_of_whoever_steers_that_is_set_forward_ends_it() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        steers.ahead_s = 2.0
        results = await steers.hold(0.5, linear=0.3)
        assert results[0].verdict is SampleVerdict.AHEAD
        assert (await steers.input.ended()).code == CONTROLS_SILENT


async def test_a_clock_of_whoever_steers_that_is_set_back_ends_it() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        steers.ahead_s = -2.0
        results = await steers.hold(0.5, linear=0.3)
        assert results[0].verdict is LATE
        assert (await steers.input.ended()).code == CONTROLS_SILENT


async def test_a_clock_that_was_asked_first_makes_no_sample_younger_than_it_is() -> None:
    async with steered() as place:
        steers = await hand(place)
        asked_ns = place.clock.monotonic_ns()
        await place.clock.advance(0.02)
        steers.input.measure(steers.now_ns(), asked_ns)
        await place.clock.advance(0.02)
        assert steers.put(0.29, linear=0.3).verdict is LATE
        assert steers.put(0.2, linear=0.3).taken


async def test_our_own_clock_on_the_wall_does_not_matter() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        place.clock.jump_wall(1.5)
        assert all(result.taken for result in await steers.hold(0.2, linear=0.3))


async def test_our_own_clock_on_the_wall_that_is_set_back_ends_it() -> None:
    """Nothing new moves then until somebody has looked: an order whose rights count by it, too."""
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        place.clock.jump_wall(-60)
        assert steers.put(linear=0.3).verdict is OVER
        assert (await steers.input.ended()).ending is OrderEnding.CANCELLED
        assert driven(place) == [0.3, 0.0]


async def test_a_right_that_ends_by_the_clock_ends_it() -> None:
    async with steered() as place:
        ends_ns = place.clock.wall_ns() + 1_000_000_000
        regrant(place, VI, "viewer", Grant(id="g1", role="operator", expires_ns=ends_ns))
        steers = await hand(place, VI)
        results = await steers.hold(2.0, linear=0.3)
        assert results[10].taken
        assert results[-1].verdict is OVER
        outcome = await steers.input.ended()
        assert outcome.ending is OrderEnding.CANCELLED
        assert driven(place) == [0.3, 0.0]


async def test_two_people_at_once_are_told() -> None:
    async with steered() as place:
        first = await hand(place)
        await first.hold(0.2, linear=0.3)
        second = await ordered(place, account=BO)
        assert "omni is" in said(place)
        with pytest.raises(Expired):
            live(place).open(line_id(second, 0), person(place, BO))
        cid = first.input.order.cid
        with pytest.raises(Expired, match="no live order of yours"):
            live(place).open(cid, person(place, BO))
        with pytest.raises(RobotBusy, match="steered from elsewhere"):
            live(place).open(cid, person(place))
        assert place.acted() == 1


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("omni move 1 m", "cannot be driven live: it does not send velocities. Nothing was done."),
        ("omni arm home", "cannot be driven live: it does not send velocities. Nothing was done."),
    ],
)
async def test_what_does_not_stream_is_not_driven_live(line: str, why: str) -> None:
    async with steered() as place:
        await ordered(place, text=line)
        assert why in said(place)
        assert place.acted() == 0


async def test_a_chat_never_drives_live() -> None:
    async with steered() as place:
        await place.say(live(place).line("omni", "drive"))
        assert place.acted() == 1
        assert "live" not in said(place)


CONFIRM = RoleRules(
    roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("*:drive",), confirm=True),)
)


async def test_what_is_confirmed_is_to_be_steered() -> None:
    async with steered(CONFIRM) as place:
        asked = await ordered(place)
        assert said(place) == "omni: drive, live? It moves only if you confirm it."
        await tapped_live(place, *place.button("Do it"))
        steers = Hand(place, live(place).open(line_id(asked, 0), person(place)))
        assert steers.put(linear=0.3).taken


async def test_what_was_confirmed_to_be_steered_is_not_done_otherwise() -> None:
    async with steered(CONFIRM) as place:
        await ordered(place)
        await place.tap(*place.button("Do it"))
        assert "This is not what was shown any more" in said(place)
        assert place.acted() == 0


async def test_what_was_confirmed_with_its_values_is_not_steered() -> None:
    async with steered(CONFIRM) as place:
        await place.say("omni drive 0.3 m/s for 1 s")
        tapped = await tapped_live(place, *place.button("Do it"))
        with pytest.raises(Expired):
            live(place).open(line_id(tapped, 0), person(place))
        assert place.acted() == 0


async def test_whoever_may_not_drive_does_not_drive_live() -> None:
    async with steered() as place:
        inbound = await ordered(place, account=VI)
        with pytest.raises(Expired):
            live(place).open(line_id(inbound, 0), person(place, VI))
        assert place.acted() == 0


async def test_closing_brings_it_to_rest() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
    assert steers.put(linear=0.3).verdict is OVER
    assert driven(place) == [0.3, 0.0]
    assert (await steers.input.ended()).ending is OrderEnding.CANCELLED
