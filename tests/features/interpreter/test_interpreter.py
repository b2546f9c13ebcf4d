"""What is not understood is proposed by an interpreter; a tap of that person acts, nothing else."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.robots.ros2.profile import Ros2Link
from tests.features.interpreter.interpreted import (
    GOOD,
    LABEL,
    PROPOSED,
    TOLD,
    UNREAD,
    Held,
    Interpreted,
    called,
    silent,
)
from tests.gateway.place import BO, FLEET, PEOPLE, VI, Place
from tests.interpreters.scripted import ScriptedEndpoint, saying
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

CROWD = [str(100 + number) for number in range(12)]


@pytest.fixture
def endpoint() -> Iterator[ScriptedEndpoint]:
    with ScriptedEndpoint(saying(GOOD)) as running:
        yield running


async def test_a_good_answer_is_proposed_and_acts_on_the_tap(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        refusal, proposal = await place.ask(UNREAD)

        assert "I do not know" in refusal or "no order" in refusal
        assert proposal.startswith(PROPOSED)
        assert LABEL in proposal
        assert place.all_acted() == 0

        ((button, under),) = place.proposals()
        assert button.label == LABEL
        assert "done" in await place.tap(button, under)
        assert place.acted() == place.all_acted() == 1


async def test_a_tap_acts_once(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(UNREAD)
        ((button, under),) = place.proposals()
        await place.tap(button, under)
        await place.tap(button, under)

        assert place.all_acted() == 1


async def test_the_tap_of_another_person_is_refused(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(UNREAD)
        ((button, under),) = place.proposals()
        await place.tap(button, under, account=BO)

        assert place.all_acted() == 0
        await place.tap(button, under)
        assert place.all_acted() == 1


async def test_what_somebody_may_not_do_is_not_proposed_to_them(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow(VI)
        told = await place.ask(UNREAD, account=VI)

        assert len(told) == 1
        assert place.proposals() == []
        shown = endpoint.calls[-1].instructions
        assert "look" in shown
        assert "move" not in shown
        assert "wave" not in shown
        assert place.counts["nothing to propose"] == 1


@pytest.mark.parametrize("text", ["omni move a smidgen ahead", "omni move very far", "omni mvoe"])
async def test_a_line_that_lacks_a_value_is_asked_about_too(
    endpoint: ScriptedEndpoint, text: str
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(text)
        assert [call.text for call in endpoint.calls] == [text]
        assert [button.label for button, _ in place.proposals()] == [LABEL]


@pytest.mark.parametrize("change", ["no", "revoked", "locked"])
async def test_whatever_ends_it_meanwhile_ends_it(change: str) -> None:
    later = Held()
    with ScriptedEndpoint(later) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=60 * pace())).open() as place:
            await place.allow(BO)
            before = len(place.chat.told)
            await place.say(UNREAD, account=BO, chat=BO)
            await called(endpoint, 1)
            if change == "no":
                await place.say("/interpreter off", account=BO, chat=BO)
            elif change == "revoked":
                await place.revoke("Bo")
            else:
                await place.say("/lock Bo")
            later.let.set()
            await place.answered()
            assert place.counts["answered"] == 1
            assert "proposed" not in place.counts
            texts = [told.outbound.text for told in list(place.chat.told)[before:]]
            assert not any(text.startswith(PROPOSED) for text in texts)


async def test_the_refusal_and_whatever_else_is_said_wait_for_nothing() -> None:
    with ScriptedEndpoint(silent) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=60 * pace())).open() as place:
            await place.allow()
            assert "I do not know" in await place.say(UNREAD)
            await called(endpoint, 1)
            assert "done" in await place.say("omni wave")
            assert "stop" in (await place.say("stop")).casefold()
            assert not place.feature.quiet


async def test_what_is_being_asked_ends_with_the_gateway() -> None:
    with ScriptedEndpoint(silent) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=60 * pace())).open() as place:
            await place.allow()
            await place.say(UNREAD)
            await called(endpoint, 1)
            client = place.feature.client
        assert client.quiet


TELL = Skill(id="tell", parameters={"text": Parameter(text=True)})
SIGNAL = Skill(id="signal", parameters={"what": Parameter(choices={"go": (), "off": ()})})
TURN = Skill(
    id="turn",
    parameters={name * 12: Parameter(unit="m", min=0.1, max=5.0) for name in ("one", "two")},
)
ODD = Profile(
    id="odd", link=Link(kind="memory"), skills={each.id: each for each in (TELL, SIGNAL, TURN)}
)
TALKER = Profile(id="talker", link=Ros2Link(kind="memory", dialogue=True))


@pytest.mark.parametrize(
    ("line", "labels"),
    [
        ("odd signal go", ["odd: signal, go"]),
        ("odd tell open the door", []),
        ("odd tell text=open", []),
        ("talker open the door", []),
        ("talker say open the door", []),
        (f"odd turn {'one' * 12}=1 m {'two' * 12}=2 m", []),
    ],
)
async def test_words_to_robots_are_not_proposed_nor_what_no_button_shows(
    endpoint: ScriptedEndpoint, line: str, labels: list[str]
) -> None:
    endpoint.script = saying(line)
    async with Interpreted(endpoint.client(), fleet=(*FLEET, ODD, TALKER)).open() as place:
        await place.allow()
        await place.ask(UNREAD)
        assert place.counts["answered"] == 1
        assert [button.label for button, _ in place.proposals()] == labels


async def test_a_line_that_would_stop_if_it_was_typed_is_not_proposed(
    endpoint: ScriptedEndpoint,
) -> None:
    light = Skill(id="light", parameters={"what": Parameter(choices={"go": (), "stop": ()})})
    lamp = Profile(id="lamp", link=Link(kind="memory"), skills={"light": light})
    async with Interpreted(endpoint.client(), fleet=(*FLEET, lamp)).open() as place:
        await place.allow()
        for what, labels in (("stop", []), ("go", ["lamp: light, go"])):
            endpoint.script = saying(f"lamp light {what}")
            await place.ask(UNREAD)
            assert [button.label for button, _ in place.proposals()] == labels
            await place.clock.advance(60)


async def test_nothing_is_asked_where_nothing_is_configured() -> None:
    async with Place().open() as place:
        assert "stays here" in await place.say("/interpreter")
        assert TOLD not in await place.say(UNREAD)


async def test_one_person_asks_one_thing_at_a_time() -> None:
    held = Held()
    with ScriptedEndpoint(held) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=60 * pace())).open() as place:
            await place.allow()
            for _ in range(5):
                assert await place.say(UNREAD)  # refused as always
            await called(endpoint, 1)
            held.let.set()
            await place.answered()
            assert len(endpoint.calls) == 1
            assert place.counts == {"answered": 1, "dropped": 4, "proposed": 1}


async def test_one_person_does_not_ask_too_often(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        for _ in range(10):
            await place.ask(UNREAD)
        assert len(endpoint.calls) == place.counts["proposed"] == 3
        await place.clock.advance(5)
        await place.ask(UNREAD)
        assert len(endpoint.calls) == 4


async def test_a_few_are_asked_about_at_once_and_the_rest_is_dropped() -> None:
    held = Held()
    with ScriptedEndpoint(held) as endpoint:
        async with Crowded(endpoint.client(timeout_s=60 * pace())).open() as place:
            for account in CROWD:
                await place.allow(account)
            for account in CROWD:
                assert await place.say(UNREAD, account=account, chat=account)
            await called(endpoint, 4)
            held.let.set()
            await place.answered()
            assert len(endpoint.calls) == place.counts["proposed"] == 4
            assert place.counts["dropped"] == 8


async def test_counts_are_logged_and_no_text(
    endpoint: ScriptedEndpoint, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(UNREAD)
        await place.clock.advance(61)
        await place.quiet()
    logged = [r.getMessage() for r in caplog.records if r.name == "rosic.interpreter"]
    assert logged == ["answered: 1, proposed: 1"]
    assert not any("smidgen" in r.getMessage() for r in caplog.records)


async def test_three_lines_are_proposed_at_most_each_once() -> None:
    answer = "\n".join([GOOD, "", "omni move 0.5 m", "kuka1 wave", "cf1 wave", "cf2 wave"])
    with ScriptedEndpoint(saying(answer)) as endpoint:
        async with Interpreted(endpoint.client()).open() as place:
            await place.allow()
            await place.ask(UNREAD)
            labels = [button.label for button, _ in place.proposals()]
            assert labels == [LABEL, "kuka1: wave"]


async def test_what_was_meant_when_it_was_proposed_is_what_a_tap_does(
    endpoint: ScriptedEndpoint,
) -> None:
    endpoint.script = saying("move 0.5 m")
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.say("use omni")
        await place.ask(UNREAD)
        ((button, under),) = place.proposals()
        assert button.label == LABEL
        await place.say("use kuka1")
        await place.tap(button, under)
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0)


async def test_whoever_lost_the_right_meanwhile_gets_nothing_by_a_tap(
    endpoint: ScriptedEndpoint,
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow(BO)
        await place.ask(UNREAD, account=BO)
        ((button, under),) = place.proposals()
        await place.revoke("Bo")
        await place.tap(button, under, account=BO)
        assert place.all_acted() == 0


class Crowded(Interpreted):
    """A place with twelve more operators."""

    people = (
        *PEOPLE,
        *(ConfiguredPerson(f"P{n}", (Address("memory", n),), ("operator",)) for n in CROWD),
    )
