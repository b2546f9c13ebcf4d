"""A thousand alarms at once: a few messages, none of them lost, all of them seen by one tap."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.core.robot.alert_config import AlertConfig, Severity
from rosic.core.robot.profile import Link, Profile, Telemetry
from rosic.features.alerts import AlertFeature
from rosic.features.alerts.recipients import ALONE, WINDOW_NS
from rosic.stores.memory import MemoryStore
from tests.features.alerts.test_alerts import heard, say
from tests.features.alerts.test_reactions import THUMB, Reactive, react
from tests.gateway.place import ADA, BO, VI, WAVE, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

ROBOTS = 1_000
WINDOW_S = WINDOW_NS / 1e9
LOW = AlertConfig(name="battery_low", when="battery < 20 %", lasting="1 s", say="Battery is low")
HOT = AlertConfig(
    name="hot", when="heat > 60 °C", lasting="1 s", say="Too hot", severity=Severity.CRITICAL
)


def fleet(robots: int) -> tuple[Profile, ...]:
    telemetry = {"battery": Telemetry(unit="%"), "heat": Telemetry(unit="°C")}
    return tuple(
        Profile(
            id=f"r{n}",
            link=Link(kind="memory"),
            telemetry=telemetry,
            alerts=(LOW, HOT),
            skills={"wave": WAVE},
        )
        for n in range(robots)
    )


@asynccontextmanager
async def storm(
    robots: int = ROBOTS, store: MemoryStore | None = None
) -> AsyncIterator[tuple[Place, dict[str, list[str]]]]:
    """Open a place where all batteries are low at once, and the last robot is hot as well.

    Yields the place, and what each account was told of it.
    """
    here = Place(store, fleet=fleet(robots))
    here.chat.__class__ = Reactive
    async with here.open():
        low(here, robots)
        here.robot(f"r{robots - 1}").values["heat"] = 80.0
        yield here, await heard(here, 2 + WINDOW_S)


def low(here: Place, robots: int, battery: float = 10.0) -> None:
    for n in range(robots):
        here.robot(f"r{n}").values = {"battery": battery, "heat": 20.0}


def unseen(here: Place) -> set[str]:
    following = here.gateway.features.get(AlertFeature).alerting.following
    return {f.rule.key for row in following.values() for f in row if f.unseen}


async def test_a_thousand_alarms_are_a_few_messages_and_one_tap_has_seen_them() -> None:
    async with storm() as (here, told):
        assert set(told) == {ADA, BO}
        for messages in told.values():
            assert len(messages) == ALONE + 1
            rest = ROBOTS - ALONE
            head, worst, others = messages[-1].splitlines()
            assert head == f"Alarms of {rest} robots, the worst first:"
            assert worst == "ALARM · Too hot: r999"
            assert others.startswith("Battery is low: r")
            assert others.endswith(f" and {rest - 5} more")
        assert len(unseen(here)) == ROBOTS + 1
        shown = await say(here, BO, "/alerts all")
        assert all(f" r{n}," in shown or f" r{n}\n" in shown for n in range(ROBOTS - 1))
        button, under = here.button("Seen, all of them")
        mine = next(t for t in here.chat.told if t.message == under).outbound.chat.id
        before = len(here.chat.told)
        await here.tap(button, under, mine)
        answer = [t.outbound.text for t in list(here.chat.told)[before:]]
        assert f"Noted, for {ROBOTS - ALONE} robots." in "\n".join(answer)
        alone = {f"{text.partition(':')[0]}/battery_low" for text in told[mine][:ALONE]}
        assert unseen(here) == alone
        await heard(here, WINDOW_S + 1)
        later = [t.outbound for t in list(here.chat.told)[before:] if t.outbound.chat.id != mine]
        assert len(later) <= ALONE + 1, "the others hear of it in as few messages"
        assert any(f"alarms of {ROBOTS - ALONE} robots" in o.text for o in later)


async def test_one_thumb_has_seen_all_that_its_message_tells_of_and_no_other() -> None:
    async with storm(40) as (here, told):
        assert len(told[BO]) == ALONE + 1
        many = next(
            t.message
            for t in reversed(here.chat.told)
            if t.outbound.chat.id == BO and t.outbound.text.startswith("Alarms of")
        )
        await react(here, VI, many, *THUMB)
        assert len(unseen(here)) == 41, "only who may operate them answers"
        await react(here, BO, many, *THUMB)
        assert unseen(here) == {f"r{n}/battery_low" for n in range(ALONE)}


async def test_what_is_over_is_gathered_too_and_a_later_alarm_is_not_seen_by_an_old_tap() -> None:
    async with storm(40) as (here, _told):
        button, under = here.button("Seen, all of them")
        mine = next(t for t in here.chat.told if t.message == under).outbound.chat.id
        low(here, 40, battery=90.0)
        over = await heard(here, 1 + 2 * WINDOW_S)
        assert [text.splitlines()[0] for text in over[BO]] == ["Over at 40 robots:"]
        await heard(here, WINDOW_S)
        low(here, 40)
        again = await heard(here, 2 + WINDOW_S)
        assert len(again[BO]) == ALONE + 1
        assert "No alarm that nobody has seen is open." in await _tapped(here, button, under, mine)
        assert len(unseen(here)) == 40


async def _tapped(here: Place, button: object, under: str, account: str) -> str:
    return await here.tap(button, under, account)  # type: ignore[arg-type]


async def test_a_storm_that_goes_on_is_one_message_a_window() -> None:
    async with storm(30) as (here, _told):
        for n in range(30):
            here.robot(f"r{n}").values["heat"] = 20.0 + 50.0 * (n % 2 == 0)
        second = await heard(here, 2 + 2 * WINDOW_S)
        assert [text.splitlines()[1] for text in second[BO] if text.startswith("Alarms")] == [
            "ALARM · Too hot: r0, r2, r4, r6, r8 and 10 more"
        ]
        assert len([text for text in second[BO] if text.startswith("Alarms")]) == 1


async def test_what_is_gathered_when_it_ends_is_told_then() -> None:
    here = Place(fleet=fleet(30))
    async with here.open():
        low(here, 30)
        told = await heard(here, 2)
        assert len(told[BO]) == ALONE
    last = [t.outbound.text for t in here.chat.told if t.outbound.chat.id == BO][-1]
    assert last.startswith("Alarms of 27 robots")


async def test_what_was_not_told_before_a_crash_is_told_after_it() -> None:
    store = MemoryStore()
    first = Place(store, fleet=fleet(30))
    async with first.open() as here:
        low(here, 30)
        await heard(here, 2)
        here.gateway.features.get(AlertFeature).alerting.telling.close = lambda: None  # type: ignore[method-assign]
    second = Place(store, fleet=fleet(30))
    second.clock.jump_wall((first.clock.wall_ns() - second.clock.wall_ns()) / 1e9)
    async with second.open() as here:
        low(here, 30)
        told = await heard(here, 2 + WINDOW_S)
        assert len(told[BO]) == ALONE + 1
        assert "Alarms of 27 robots" in told[BO][-1]
