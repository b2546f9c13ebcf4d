"""Alarms from what a robot reports: who is told, who has seen it, and what outlives a restart."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.core.robot.alert_config import AlertConfig, RecipientCircle, Severity
from rosic.core.robot.profile import Telemetry
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, FLEET, VI, BrokenStore, Place

LOW = AlertConfig(
    name="battery_low",
    when="battery < 20 %",
    lasting="10 s",
    clear="battery > 25 %",
    say="Battery is low",
    escalate_after="2 min",
)


def place(*alerts: AlertConfig, store: MemoryStore | None = None) -> Place:
    omni = replace(FLEET[0], telemetry={"battery": Telemetry(unit="%")}, alerts=alerts)
    return Place(store, fleet=(omni, *FLEET[1:]))


def battery(here: Place, percent: float) -> None:
    here.robot("omni").values["battery"] = percent


async def say(here: Place, account: str, text: str) -> str:
    """Say something in one's private chat; return all that was told because of it."""
    return await here.say(text, account=account, chat=account)


async def heard(here: Place, seconds: float) -> dict[str, list[str]]:
    """Let time pass; return what each account was told meanwhile."""
    before = len(here.chat.told)
    await here.clock.advance(seconds)
    await here.quiet()
    found: dict[str, list[str]] = {}
    for told in list(here.chat.told)[before:]:
        found.setdefault(told.outbound.chat.id, []).append(told.outbound.text)
    return found


async def test_it_is_told_after_its_time_to_who_may_operate_and_again_when_it_is_over() -> None:
    async with place(LOW).open() as here:
        battery(here, 15)
        assert await heard(here, 9) == {}
        told = await heard(here, 2)
        assert told == {who: ["omni: Battery is low.\nNow: battery 15 %."] for who in (ADA, BO)}
        battery(here, 23)
        assert await heard(here, 60) == {}, "hysteresis: 23 % is neither bad nor good"
        battery(here, 26)
        told = await heard(here, 2)
        assert told[BO] == ["omni: over: Battery is low.\nNow: battery 26 %."]
        assert VI not in told


async def test_a_value_that_is_missing_or_no_number_raises_nothing_but_silence_does() -> None:
    silent = AlertConfig(
        name="quiet", when="battery silent", lasting="10 s", say="No battery report"
    )
    async with place(LOW, silent).open() as here:
        battery(here, float("nan"))
        told = await heard(here, 11)
        assert told[BO] == ["omni: No battery report."]
        battery(here, 50)
        assert (await heard(here, 2))[BO] == ["omni: over: No battery report.\nNow: battery 50 %."]


async def test_one_who_has_seen_it_tells_the_others_and_it_is_not_told_again() -> None:
    async with place(LOW).open() as here:
        battery(here, 15)
        await heard(here, 11)
        button, under = here.button("Seen")
        account = here.chat.told[-1].outbound.chat.id
        other = BO if account == ADA else ADA
        before = len(here.chat.told)
        await here.tap(button, under, account)
        told = {t.outbound.chat.id: t.outbound.text for t in list(here.chat.told)[before:]}
        assert told[account].startswith("Noted.")
        assert told[other] == (
            f"omni: Battery is low: {'Ada' if account == ADA else 'Bo'} has seen it."
        )
        assert await heard(here, 600) == {}
        assert "seen by" in await say(here, other, "/alerts")
        assert "has seen it already" in await say(here, other, "/seen omni")


async def test_what_nobody_sees_goes_on_to_the_next_circle_and_ends() -> None:
    rule = replace(LOW, tell=RecipientCircle.HOLDER, escalate_after="1 min")
    async with place(rule).open() as here:
        await say(here, BO, "omni wave")
        battery(here, 15)
        first = await heard(here, 11)
        assert set(first) == {BO}
        second = await heard(here, 60)
        assert set(second) == {ADA, BO}
        assert "Nobody has said in 1 min that they saw it." in second[ADA][0]
        third = await heard(here, 60)
        assert set(third) == {ADA}
        assert len((await heard(here, 3600))[ADA]) == 9, "twelve times in all"
        assert await heard(here, 3600) == {}


async def test_whoever_may_only_look_is_not_told_and_cannot_answer() -> None:
    async with place(LOW).open() as here:
        battery(here, 15)
        assert VI not in await heard(here, 11)
        for line in ("/seen omni", "/mute omni battery 1h", "/unmute omni"):
            assert "Only who may operate omni" in await say(here, VI, line)
        assert "Battery is low" in await say(here, VI, "/alerts")
        assert [b.label for row in here.last()[1].buttons for b in row] == []
        assert "No alarm that nobody has seen" in await say(here, VI, "/seen")


async def test_a_mute_is_told_kept_over_a_restart_and_ends() -> None:
    store = MemoryStore()
    first = place(LOW, store=store)
    async with first.open() as here:
        battery(here, 15)
        await heard(here, 11)
        before = len(here.chat.told)
        assert "muted until" in await say(here, BO, "/mute omni battery 1h")
        others = [t.outbound for t in list(here.chat.told)[before:] if t.outbound.chat.id == ADA]
        assert [o.text.startswith("omni: Bo has muted battery_low") for o in others] == [True]
        assert await heard(here, 1800) == {}
        assert "is muted until" in await say(here, ADA, "/alerts")
    second = place(LOW, store=store)
    second.clock.jump_wall((first.clock.wall_ns() - second.clock.wall_ns()) / 1e9)
    async with second.open() as here:
        battery(here, 15)
        assert await heard(here, 1700) == {}
        told = await heard(here, 200)
        assert told[ADA] == ["omni: Battery is low.\nIt is still so.\nNow: battery 15 %."]


async def test_an_alarm_outlives_a_restart_and_is_told_again_only_if_nobody_saw_it() -> None:
    for seen in (False, True):
        store = MemoryStore()
        first = place(LOW, store=store)
        async with first.open() as here:
            battery(here, 15)
            await heard(here, 11)
            if seen:
                await say(here, BO, "/seen")
        async with place(LOW, store=store).open() as here:
            battery(here, 15)
            told = await heard(here, 30)
            assert told == ({} if seen else told)
            assert bool(told) is not seen
            battery(here, 30)
            assert (await heard(here, 2))[ADA][0].startswith("omni: over")


async def test_it_is_told_although_nothing_can_be_written() -> None:
    store = BrokenStore()
    async with place(LOW, store=store).open() as here:
        store.broken = True
        battery(here, 15)
        assert set(await heard(here, 11)) == {ADA, BO}
        assert "Noted" in await say(here, BO, "/seen")
        store.broken = False


async def test_a_critical_one_overtakes_and_says_so() -> None:
    async with place(replace(LOW, severity=Severity.CRITICAL)).open() as here:
        battery(here, 15)
        await heard(here, 11)
        outbound = here.chat.told[-1].outbound
        assert outbound.urgent
        assert outbound.text.startswith("ALARM · omni: Battery is low.")


async def test_whoever_is_locked_or_whose_key_is_over_is_not_told() -> None:
    async with place(LOW).open() as here:
        authoriser = here.gateway.rooms.authoriser
        bo, ada = (authoriser.directory.named(name)[0].id for name in ("Bo", "Ada"))
        key = authoriser.directory.key_of(bo)
        assert key is not None
        authoriser.directory.add_key(replace(key, expires_ns=here.clock.wall_ns() + 10**9))
        battery(here, 15)
        assert set(await heard(here, 11)) == {ADA}
        assert "Noted" in await say(here, ADA, "/seen")
        battery(here, 50)
        assert set(await heard(here, 2)) == {ADA}
        here.gateway.rooms.organiser.locked = {ada}
        battery(here, 15)
        assert await heard(here, 11) == {}


async def test_whoever_has_lost_their_access_hears_nothing_more() -> None:
    async with place(LOW).open() as here:
        battery(here, 15)
        await heard(here, 11)
        await here.revoke("Bo")
        battery(here, 50)
        told = await heard(here, 2)
        assert BO not in told
        assert any("over" in text for text in told[ADA])


async def test_offline_and_link_age_are_rules_too_and_a_name_is_found_by_its_beginning() -> None:
    gone = AlertConfig(name="gone", when="offline", lasting="3 s", say="Not there")
    old = AlertConfig(name="old_link", when="link_age > 5 s", lasting="0 s", say="Old news")
    async with place(gone, old).open() as here:
        here.robot("omni").online = False
        assert (await heard(here, 5))[BO] == ["omni: Not there."]
        here.robot("omni").age_s = 6.0
        assert (await heard(here, 1))[BO] == ["omni: Old news.\nNow: link age 6.00 s."]
        assert "old_link muted until" in await say(here, BO, "/mute omni old for 2h")
        assert "no rule called nothing" in await say(here, BO, "/mute omni nothing")
        assert "tells again" in await say(here, BO, "/unmute omni old")
        assert "a minute at least" in await say(here, BO, "/mute omni gone 1s")
        assert "for example" in await say(here, BO, "/mute")
        assert "no robot" in await say(here, BO, "/mute zzz")
        assert "has no rules" in await say(here, BO, "/alerts kuka1")
