"""Robots that answer each other for ever are cut, and people hear of it once."""

from __future__ import annotations

import msgspec

from rosic.features.robot_to_robot.inbox import CONVERSATION, CUT_NS, HOPS_AT_MOST
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import BO, VI


class Echo:
    """Two robots whose nodes answer whatever they are told."""

    def __init__(self, here: PeerRobots, *, names_cause: bool) -> None:
        self.said = 0
        self._here = here
        self._names_cause = names_cause
        for name in ("omni", "cf1"):
            here.robot(name).hear = lambda words, name=name: self._hear(name, words)  # type: ignore[method-assign,misc]

    def _hear(self, name: str, words: bytes) -> bool:
        heard = msgspec.json.decode(words)
        if heard["kind"] == "told":
            self.said += 1
            cause = {"re": heard["id"]} if self._names_cause else {}
            self._here.speaks(name, "tell", to=heard["from"], data="and you?", **cause)
        return True


def cuts(here: PeerRobots, account: str) -> list[str]:
    said = [t.outbound for t in here.chat.told if "without end" in t.outbound.text]
    return [outbound.text for outbound in said if outbound.chat.id == account]


async def test_a_chain_of_answers_ends_and_is_told_once() -> None:
    async with PeerRobots().open() as here:
        echo = Echo(here, names_cause=True)
        here.speaks("omni", "tell", to="cf1", data="hello")
        await here.clock.advance(120)
        assert echo.said == HOPS_AT_MOST + 1
        assert len(cuts(here, BO)) == 1
        assert cuts(here, BO)[0].startswith(("omni and cf1 answered", "cf1 and omni answered"))
        assert cuts(here, VI) == []


async def test_who_hides_why_it_speaks_is_cut_by_the_budget_of_the_pair() -> None:
    async with PeerRobots().open() as here:
        echo = Echo(here, names_cause=False)
        here.speaks("omni", "tell", to="cf1", data="hello")
        await here.clock.advance(200)
        assert echo.said <= CONVERSATION.burst + 200 * CONVERSATION.per_s
        assert len(cuts(here, BO)) == 1
        said = echo.said
        for _ in range(5):
            here.speaks("omni", "tell", to="cf1", data="again")
            await here.clock.advance(1)
        assert echo.said == said, "nothing passes while they are cut"


async def test_who_begins_again_at_once_is_cut_again_without_being_told_again() -> None:
    async with PeerRobots().open() as here:
        Echo(here, names_cause=False)
        for _ in range(3):
            here.speaks("omni", "tell", to="cf1", data="hello")
            await here.clock.advance(CUT_NS / 1e9 + 5)
        assert len(cuts(here, BO)) == 1


async def test_others_go_on_and_so_do_they_later() -> None:
    async with PeerRobots().open() as here:
        Echo(here, names_cause=True)
        here.speaks("omni", "tell", to="cf1", data="hello")
        await here.clock.advance(30)
        del here.robot("omni").hear, here.robot("cf1").hear
        assert (await here.says("omni", "tell", to="cf2", data="you too?"))["ok"] is True
        assert (await here.says("omni", "tell", to="cf1", data="?"))["ok"] is False
        await here.clock.advance(CUT_NS / 1e9)
        assert (await here.says("omni", "tell", to="cf1", data="calm now"))["ok"] is True


async def test_sharing_because_of_what_was_shared_is_a_chain_too() -> None:
    async with PeerRobots().open() as here:
        await here.says("cf1", "follow", robot="omni")
        await here.says("omni", "follow", robot="cf1")
        said = 0

        def hear(name: str, words: bytes) -> bool:
            nonlocal said
            heard = msgspec.json.decode(words)
            if heard["kind"] == "shared":
                said += 1
                here.speaks(name, "share", topic="pong", data=said, re=heard["id"])
            return True

        for name in ("omni", "cf1"):
            here.robot(name).hear = lambda words, name=name: hear(name, words)  # type: ignore[method-assign,misc]
        here.speaks("omni", "share", topic="ping", data=0)
        await here.clock.advance(60)
        assert said == HOPS_AT_MOST + 1
        assert len(cuts(here, BO)) == 1


async def test_speaking_to_another_needs_the_right_and_answering_does_not() -> None:
    async with PeerRobots().open() as here:
        refused = await here.says("cf2", "tell", to="cf1", data="hello")
        assert (refused["ok"], refused["code"]) == (False, "not-permitted")
        here.robot("cf2").heard.clear()
        await here.says("cf1", "tell", to="cf2", data="where are you?")
        [told] = here.heard("cf2", "told")
        answered = await here.says("cf2", "tell", to="cf1", data="here", re=told["id"])
        assert answered["ok"] is True
        assert here.heard("cf1", "told")[-1]["re"] == told["id"]
