"""What is not understood is proposed by an interpreter; a tap of that person acts, nothing else."""

from __future__ import annotations

import asyncio
import logging
import time
from typing import TYPE_CHECKING, Any

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import ChatKind
from rosic.stores.memory import MemoryStore
from tests.features.interpreter.interpreted import PROPOSED, TOLD, Interpreted
from tests.gateway.place import ADA, BO, PEOPLE, VI, Place
from tests.interpreters.scripted import Call, ScriptedEndpoint, client_of, saying
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

CROWD = [str(100 + number) for number in range(12)]
GOOD = "omni move forward 0.5 m"
LABEL = "omni: move, 0.50 m forward"
UNREAD = "would you kindly shuffle a smidgen ahead"


def silent(call: Call) -> None:
    """Say nothing for as long as the server runs."""
    call.ended.wait()


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


async def test_somebody_is_told_once_before_anything_of_theirs_is_shown(
    endpoint: ScriptedEndpoint,
) -> None:
    store = MemoryStore()
    async with Interpreted(endpoint.client(), store).open() as place:
        _, notice = await place.ask(UNREAD)
        assert notice.startswith(TOLD)
        assert "on the machine that I run on" in notice
        assert "/interpreter off" in notice
        assert endpoint.calls == []
        await place.clock.advance(60)
        await place.ask(UNREAD)
        assert [call.text for call in endpoint.calls] == [UNREAD]
    async with Interpreted(endpoint.client(), store).open() as place:
        told = await place.ask(UNREAD)
        assert not any(TOLD in text for text in told)
        assert len(endpoint.calls) == 2


async def test_the_notice_says_whose_machine_it_is() -> None:
    async with Interpreted(client_of("https://llm.example.com")).open() as place:
        _, notice = await place.ask(UNREAD)
        assert "at llm.example.com, outside this place" in notice


async def test_a_yes_shows_the_line_that_was_asked_about(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.ask(UNREAD)
        button, under = place.button("Show it this one")
        await place.clock.advance(20)
        await place.tap(button, under)
        await place.answered()

        assert [call.text for call in endpoint.calls] == [UNREAD]
        assert [button.label for button, _ in place.proposals()] == [LABEL]


@pytest.mark.parametrize("way", ["tap", "typed"])
async def test_whoever_says_no_is_never_shown_to_it(endpoint: ScriptedEndpoint, way: str) -> None:
    store = MemoryStore()
    async with Interpreted(endpoint.client(), store).open() as place:
        await place.ask(UNREAD)
        if way == "tap":
            said = await place.tap(*place.button("Never show it anything"))
        else:
            said = await place.say("/interpreter off")
        assert "shown to nobody" in said
        for _ in range(3):
            await place.clock.advance(60)
            assert len(await place.ask(UNREAD)) == 1
    async with Interpreted(endpoint.client(), store).open() as place:
        assert len(await place.ask(UNREAD)) == 1
        assert "shown to nobody" in await place.say("/interpreter")
        assert endpoint.calls == []
        assert "is shown to an interpreter" in await place.say("/interpreter on")
        await place.clock.advance(60)
        await place.ask(UNREAD)
        assert len(endpoint.calls) == 1


async def test_a_no_while_it_is_asked_ends_it() -> None:
    with ScriptedEndpoint(silent) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=30)).open() as place:
            await place.allow()
            before = len(place.chat.told)
            await place.say(UNREAD)
            await _called(endpoint, 1)
            endpoint.script = saying(GOOD)
            await place.say("/interpreter off")
            await place.clock.advance(60)
            await place.say(UNREAD)
            assert len(endpoint.calls) == 1
            texts = [told.outbound.text for told in list(place.chat.told)[before:]]
            assert not any(text.startswith(PROPOSED) for text in texts)


async def test_nothing_is_asked_where_nothing_is_configured() -> None:
    async with Place().open() as place:
        assert "stays here" in await place.say("/interpreter")
        assert TOLD not in await place.say(UNREAD)


async def test_what_is_understood_is_not_shown(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        for text in ("omni wave", "status", "help", "/settings", "omni", "stop", "omni move 90 m"):
            await place.ask(text)
            await place.clock.advance(60)
        assert endpoint.calls == []


async def test_in_a_group_only_what_is_said_to_us_is_shown(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        group: dict[str, Any] = {"chat": "-7", "kind": ChatKind.GROUP}
        await place.ask(UNREAD, **group)
        await place.ask(f"omni, {UNREAD}", **group)
        assert endpoint.calls == []
        await place.say("status", **group)
        ours = place.chat.told[-1].message
        await place.ask(UNREAD, answers=ours, **group)
        assert [call.text for call in endpoint.calls] == [UNREAD]
        ((button, under),) = place.proposals()
        await place.tap(button, under)
        assert place.all_acted() == 1


async def test_a_group_tells_nobody_of_it(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        group: dict[str, Any] = {"chat": "-7", "kind": ChatKind.GROUP}
        await place.say("status", **group)
        ours = place.chat.told[-1].message
        assert len(await place.ask(UNREAD, answers=ours, **group)) == 1
        assert endpoint.calls == []


async def test_what_leaves_the_house_is_the_line_and_what_may_be_said() -> None:
    key = "sk-very-secret-123"
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        async with Interpreted(endpoint.client(key=key)).open() as place:
            await place.allow()
            await place.say("omni wave")
            await place.say("omni move 0.25 m left")
            await place.ask("tell Bo that omni shall do Vi's dance for @marvin", account=ADA)

            (call,) = endpoint.calls
            assert call.text == "tell somebody that omni shall do somebody dance for somebody"
            for name in ("Ada", "Bo ", "Vi ", "marvin", "memory", "0.25", "wave\\n"):
                assert name not in call.body["messages"][1]["content"].replace("somebody", "")
            whole = str(call.body)
            for name in ("Ada", "Bo", "Vi", "marvin", "hum hum", "0.25", key, "admin"):
                assert name not in whole, name
            assert set(call.body) == {"model", "messages", "temperature", "max_tokens", "stream"}
            assert "move; direction: forward | back | left (optional); distance: 0.01 to 5 m" in (
                call.instructions
            )
            assert "swarm: all of cf1, cf2" in call.instructions
            assert f"Authorization: Bearer {key}" in call.head


@pytest.mark.parametrize(
    "text",
    [
        "my password is hunter2",
        "mein passwort lautet sonne",
        "code 123 456",
        "it says 482913",
        "call me at +49 170 1234567",
        "7K3M-Q0ZD please",
        "use 7K3M Q0ZD please",
        "jion 7K3MQ0ZD",
        "/strat 7K3M-Q0ZD",
        "look at https://example.com/a?token=1",
        "write to ada@example.com",
        "the thing is JBSWY3DPEHPK3PXP ok",
        "123456789:AAHk3l2j4h5k6j7h8g9f0d1s2a3q4w5e6r7 is the bot",
        "x" * 41,
        "go on " * 60,
        "one thing\nand another thing",
    ],
)
async def test_what_may_be_a_secret_is_shown_to_nobody(
    endpoint: ScriptedEndpoint, text: str
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(text)
        assert endpoint.calls == []


async def test_an_invitation_however_it_is_written_is_shown_to_nobody(
    endpoint: ScriptedEndpoint,
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        made = await place.say("/invite viewer as Cy")
        code = next(word for word in made.split() if len(word) == 9 and word[4] == "-")
        for text in (f"give {code} to her", f"so {code[:4]} then {code[5:]}", " ".join(code)):
            await place.ask(text)
            await place.clock.advance(60)
        assert endpoint.calls == []


async def test_one_person_asks_one_thing_at_a_time_and_not_too_often() -> None:
    with ScriptedEndpoint(silent) as endpoint:
        async with Interpreted(endpoint.client(timeout_s=0.5)).open() as place:
            await place.allow()
            for _ in range(5):
                assert len(await place.say(UNREAD)) > 0
            await place.answered()
            assert len(endpoint.calls) == 1
            assert place.counts["dropped"] == 4
            endpoint.script = saying(GOOD)
            for _ in range(6):
                await place.ask(UNREAD)
            assert len(endpoint.calls) < 6


async def test_a_few_are_asked_about_at_once_and_the_rest_is_dropped() -> None:
    with ScriptedEndpoint(silent) as endpoint:
        async with Crowded(endpoint.client(timeout_s=1.0)).open() as place:
            for account in CROWD:
                await place.allow(account)
            for account in CROWD:
                answer = await place.say(UNREAD, account=account, chat=account)
                assert answer  # refused as always
            await place.answered()
            assert len(endpoint.calls) == 4
            assert place.counts["late"] == 4
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


async def _called(endpoint: ScriptedEndpoint, count: int) -> None:
    until = time.monotonic() + 60 * pace()
    while len(endpoint.calls) < count:
        assert time.monotonic() < until, "nobody calls"
        await asyncio.sleep(0.005)


class Crowded(Interpreted):
    """A place with twelve more operators."""

    people = (
        *PEOPLE,
        *(ConfiguredPerson(f"P{n}", (Address("memory", n),), ("operator",)) for n in CROWD),
    )
