"""adjustStrategy: checked, at its moment, acknowledged by the robot, and reversible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import AdminVerb
from rosic.features.robot_to_robot.strategies import ANSWER_WITHIN_S, IDLE_WITHIN_S
from rosic.stores.memory import MemoryStore
from tests.features.robot_to_robot.peers import PeerRobots, with_strategies
from tests.gateway.place import ADA, BO, VI, ask_as_operator

if TYPE_CHECKING:
    from typing import Any


def place(store: MemoryStore | None = None) -> PeerRobots:
    return PeerRobots(store, fleet=with_strategies())


async def say(here: PeerRobots, text: str, account: str = BO) -> str:
    return await here.say(text, account=account, chat=account)


async def asked(here: PeerRobots) -> dict[str, Any]:
    """Return the strategy that omni was told last."""
    await here.quiet()
    return here.heard("omni", "strategy")[-1]


async def answered(here: PeerRobots, *, ok: bool = True, why: str = "") -> str:
    """Let omni answer it, and return what people are told because of it."""
    before = len(here.chat.told)
    here.speaks("omni", "ack", id=(await asked(here))["id"], ok=ok, why=why)
    await here.clock.advance(0.5)
    await here.quiet()
    return "\n".join(t.outbound.text for t in list(here.chat.told)[before:])


async def test_it_is_checked_sent_acknowledged_and_undone() -> None:
    async with place().open() as here:
        assert await say(here, "/strategy omni") == ("omni: as usual. There are: brisk, careful.")
        told = await say(here, "/strategy omni careful speed=30 cm/s now")
        assert (
            told
            == "omni: Careful (speed 0.3 m/s, spacing 1 m), now. I say when it has taken it on."
        )
        sent = await asked(here)
        assert (sent["name"], sent["values"]) == ("careful", {"speed": 0.3, "spacing": 1.0})
        shown = await say(here, "/strategy omni")
        assert shown.startswith("omni: as usual."), "not before it has answered"
        assert "was told to take on Careful (speed 0.3 m/s, spacing 1 m)" in shown
        assert await answered(here) == ("omni has taken on: Careful (speed 0.3 m/s, spacing 1 m).")
        await say(here, "/strategy omni brisk manner=brave")
        await here.clock.advance(0.3)
        assert "brisk (manner bold)" in await answered(here)
        await say(here, "/strategy omni back now")
        assert (await asked(here))["values"] == {"speed": 0.3, "spacing": 1.0}
        await answered(here)
        assert "Careful (speed 0.3 m/s" in await say(here, "/strategy omni")


async def test_the_first_can_be_undone_to_what_was_usual() -> None:
    store = MemoryStore()
    async with place(store).open() as here:
        assert "had no other strategy" in await say(here, "/strategy omni back")
        await say(here, "/strategy omni careful now")
        await answered(here)
    async with place(store).open() as here:
        assert "Careful" in await say(here, "/strategy omni"), "kept over a restart"
        await say(here, "/strategy omni back now")
        assert (await asked(here))["name"] == ""
        await answered(here)
        assert "as usual" in await say(here, "/strategy omni")


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("wild", "omni has no strategy called wild. There are: brisk, careful."),
        ("careful speed=2", "speed must be from 0.05 to 0.5 m/s."),
        ("careful speed=nan", 'speed: "nan" is no such number.'),
        ("careful speed=1kg", 'speed: "1kg" is no such number.'),
        ("careful colour=red", 'There is no parameter "colour" there. There are: speed, spacing.'),
        ("brisk", "manner has to be said, too."),
        ("brisk manner=loud", "manner is one of calm, bold."),
        ("careful fast", "Write for example: /strategy omni careful speed=0.2 now, or"),
    ],
)
async def test_what_the_profile_does_not_declare_is_refused(said: str, why: str) -> None:
    async with place().open() as here:
        assert (await say(here, f"/strategy omni {said}")).startswith(why)
        assert here.heard("omni") == []
        assert await say(here, "/strategy cf1 careful") == "cf1 has no strategies."


async def test_when_idle_it_waits_until_the_robot_carries_out_nothing() -> None:
    async with place().open() as here:
        here.robot("omni").work_s = 3_600.0
        await say(here, "omni wave")
        await here.clock.advance(1)
        told = await say(here, "/strategy omni careful")
        assert told.endswith("as soon as it carries out nothing.")
        await here.clock.advance(5)
        assert here.heard("omni") == []
        here.robot("omni").finish()
        await here.clock.advance(1)
        assert (await asked(here))["name"] == "careful"
        assert "has taken on" in await answered(here)


async def test_whose_access_has_ended_by_that_moment_adjusts_nothing() -> None:
    async with place().open() as here:
        here.robot("omni").work_s = 3_600.0
        await say(here, "omni wave")
        await here.clock.advance(1)
        await say(here, "/strategy omni careful")
        await ask_as_operator(here.gateway, AdminVerb.REVOKE, "Bo")
        await here.clock.advance(5)
        await here.quiet()
        assert here.gateway.rooms.linker.current("omni") is None
        assert here.heard("omni", "strategy") == []


async def test_a_moment_that_does_not_come_is_said_and_nothing_is_sent() -> None:
    async with place().open() as here:
        here.robot("omni").work_s = 3_600.0
        await say(here, "omni wave")
        await say(here, "/strategy omni careful")
        before = len(here.chat.told)
        await here.clock.advance(IDLE_WITHIN_S + 5)
        told = [t.outbound.text for t in list(here.chat.told)[before:]]
        assert any("was at work the whole time" in text for text in told)
        assert here.heard("omni") == []
        here.robot("omni").finish()


async def test_a_robot_that_declines_or_does_not_answer_is_not_said_to_have_done_it() -> None:
    async with place().open() as here:
        await say(here, "/strategy omni careful now")
        told = await answered(here, ok=False, why="too little light")
        assert told.endswith("too little light. It goes on as before.")
        assert "as usual" in await say(here, "/strategy omni")
        await say(here, "/strategy omni careful now")
        before = len(here.chat.told)
        await here.clock.advance(ANSWER_WITHIN_S + 1)
        told = "\n".join(t.outbound.text for t in list(here.chat.told)[before:])
        assert "may or may not have done so" in told
        assert "and has not answered." in await say(here, "/strategy omni")
        here.robot("omni").listens = False
        before = len(here.chat.told)
        await say(here, "/strategy omni brisk manner=calm now")
        told = "\n".join(t.outbound.text for t in list(here.chat.told)[before:])
        assert "omni does not listen now, so this was not sent: " in told


async def test_rights_count_for_people_and_for_robots() -> None:
    async with place().open() as here:
        assert (await say(here, "/strategy omni careful", VI)).startswith("Strategy needs")
        refused = await here.says("cf2", "adjust", robot="omni", strategy="careful")
        assert refused["ok"] is False
        taken = await here.says("cf1", "adjust", robot="omni", strategy="careful", when="now")
        assert taken["ok"] is True
        assert "has taken on" in await answered(here)
        assert here.heard("cf1", "note")[-1]["text"].startswith("omni has taken on")
        refused = await here.says("omni", "ack", id="nothing", ok=True)
        assert refused["why"] == "You were not asked that, or have answered already."


async def test_nobody_adjusts_a_robot_that_somebody_else_has() -> None:
    async with place().open() as here:
        await say(here, "omni wave", BO)
        told = await say(here, "/strategy omni careful now", ADA)
        assert told == "omni is Bo's now. Its strategy was not changed."
        refused = await here.says("cf1", "adjust", robot="omni", strategy="careful", when="now")
        assert (refused["ok"], refused["code"]) == (False, "robot-taken")
        assert here.heard("omni") == []


async def test_a_further_change_takes_the_place_of_one_that_waits() -> None:
    async with place().open() as here:
        here.robot("omni").work_s = 3_600.0
        await say(here, "omni wave")
        await say(here, "/strategy omni careful")
        told = await say(here, "/strategy omni brisk manner=calm")
        assert "Careful (speed 0.2 m/s, spacing 1 m) was not sent, for another came." in told
        here.robot("omni").finish()
        await here.clock.advance(1)
        assert [s["name"] for s in here.heard("omni", "strategy")] == ["brisk"]
