"""An alarm that the last run raised and could not say: said by the next, and answered as ever."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.robot.alert_config import Severity
from rosic.core.robot.profile import Telemetry
from rosic.features.alerts.recipients import ALONE
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.features.alerts.test_alert_storm import WINDOW_S, fleet, low, unseen
from tests.features.alerts.test_alerts import LOW, battery, heard, say
from tests.features.alerts.test_reactions import THUMB, Reactive, react
from tests.gateway.place import ADA, BO, FLEET, VI, Place
from tests.gateway.test_outbox import AGAIN

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.robot.alert_config import AlertConfig

CRITICAL = replace(LOW, severity=Severity.CRITICAL)


def omni(rules: tuple[AlertConfig, ...], store: MemoryStore, clock: ManualClock) -> Place:
    robot = replace(FLEET[0], telemetry={"battery": Telemetry(unit="%")}, alerts=rules)
    return Place(store, clock=clock, fleet=(robot,))


@asynccontextmanager
async def unsaid(*rules: AlertConfig, over: bool = False) -> AsyncIterator[Place]:
    """Raise alarms on a robot while nothing can be said, then open the place anew.

    Args:
        rules: The robot's.
        over: They were over before the end, which could not be said either.
    """
    store, clock = MemoryStore(), ManualClock()
    async with omni(rules, store, clock).open() as here:
        here.chat.down = True
        battery(here, 15)
        assert await heard(here, 11) == {}
        if over:
            battery(here, 50)
            await heard(here, 2)
    again = omni(rules, store, clock)
    again.chat.__class__ = Reactive
    async with again.open():
        battery(again, 15)
        await again.quiet()
        yield again


def said_to(here: Place, account: str) -> tuple[str, str, list[str]]:
    """Return the message that somebody was told anew, its text, and its buttons' labels."""
    [told] = [t for t in here.chat.told if t.outbound.chat.id == account]
    shown = here.chat.shown(told.message)
    return told.message, shown.text, [b.label for row in shown.buttons for b in row]


@pytest.mark.parametrize("rule", [LOW, CRITICAL], ids=["warning", "critical"])
async def test_it_is_said_with_its_buttons_and_seen_by_one(rule: AlertConfig) -> None:
    async with unsaid(rule) as here:
        message = ""
        for who in (ADA, BO):
            message, text, labels = said_to(here, who)
            assert "omni: Battery is low." in text
            assert text.endswith(AGAIN)
            assert labels == ["Seen", "Mute 1 h", "Status"]
        assert not any(told.outbound.chat.id == VI for told in here.chat.told)
        [[seen, *_]] = here.chat.shown(message).buttons
        assert "omni: Battery is low: Bo has seen it." in await here.tap(seen, message, BO)
        assert "seen by Bo" in await say(here, ADA, "/alerts")
        assert await heard(here, 600) == {}, "it goes no further"


async def test_a_thumb_beside_it_has_seen_it() -> None:
    async with unsaid(CRITICAL) as here:
        message, *_ = said_to(here, BO)
        told = await react(here, BO, message, *THUMB)
        assert told == {ADA: "omni: Battery is low: Bo has seen it."}
        assert here.chat.nods == [(BO, message, "👌")]  # type: ignore[attr-defined]


async def test_a_button_that_is_not_theirs_moves_nothing() -> None:
    async with unsaid(CRITICAL) as here:
        message, *_ = said_to(here, BO)
        [[seen, *_]] = here.chat.shown(message).buttons
        assert await here.tap(seen, message, ADA) == ""
        assert "seen by" not in await say(here, ADA, "/alerts")


async def test_what_is_over_is_said_and_offers_nothing() -> None:
    async with unsaid(CRITICAL, over=True) as here:
        told = [t.outbound for t in here.chat.told if t.outbound.chat.id == BO]
        assert [("over" in one.text, one.buttons) for one in told] == [(False, ()), (True, ())]
        message = here.chat.told[0].message
        assert await react(here, BO, message, *THUMB) == {}


async def test_many_in_one_message_are_seen_by_one_tap() -> None:
    store, clock, robots = MemoryStore(), ManualClock(), 20
    async with Place(store, clock=clock, fleet=fleet(robots)).open() as here:
        here.chat.down = True
        low(here, robots)
        await heard(here, 2 + WINDOW_S)
        assert len(unseen(here)) == robots
    again = Place(store, clock=clock, fleet=fleet(robots))
    async with again.open():
        low(again, robots)
        await again.quiet()
        button, message = again.button("Seen, all of them")
        told = again.chat.shown(message)
        assert told.text.endswith(AGAIN)
        await again.tap(button, message, told.chat.id)
        assert unseen(again) == {f"r{n}/battery_low" for n in range(ALONE)}, "each told for itself"
