"""What is shown to an interpreter, to whom that is told before, and what is shown to nobody."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from rosic.core.message import ChatKind, MessageValidity
from rosic.stores.memory import MemoryStore
from tests.features.interpreter.interpreted import GOOD, LABEL, TOLD, UNREAD, Interpreted
from tests.features.interpreter.test_hostile_answers import LI, NarrowPlace
from tests.gateway.place import ADA
from tests.interpreters.scripted import ScriptedEndpoint, client_of, saying

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def endpoint() -> Iterator[ScriptedEndpoint]:
    with ScriptedEndpoint(saying(GOOD)) as running:
        yield running


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
        assert "may be shown to an interpreter" in await place.say("/settings")
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
        assert "What I do not understand: is shown to nobody" in await place.say("/settings")
        assert endpoint.calls == []
        assert "is shown to an interpreter" in await place.say("/interpreter on")
        await place.clock.advance(60)
        await place.ask(UNREAD)
        assert len(endpoint.calls) == 1


async def test_what_was_sent_while_nobody_listened_is_not_shown(
    endpoint: ScriptedEndpoint,
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        sent_ns = place.clock.wall_ns()
        await place.clock.advance(1)
        place.chat.gap()
        await place.ask(UNREAD, sent_ns=sent_ns)
        assert endpoint.calls == []


@pytest.mark.parametrize("standing", [s for s in MessageValidity if s is not MessageValidity.FRESH])
async def test_what_may_change_nothing_is_not_shown(
    endpoint: ScriptedEndpoint, standing: MessageValidity
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        await place.ask(UNREAD, standing=standing)
        assert endpoint.calls == []


@pytest.mark.parametrize(
    "text", ["they said we had to stop there", "omni, we had to stop there yesterday"]
)
async def test_whoever_speaks_of_stopping_is_offered_that_alone(
    endpoint: ScriptedEndpoint, text: str
) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.allow()
        assert len(await place.ask(text)) == 1
        assert endpoint.calls == []
        assert place.all_acted() == 0


async def test_a_stranger_is_not_shown(endpoint: ScriptedEndpoint) -> None:
    async with Interpreted(endpoint.client()).open() as place:
        await place.ask(UNREAD, account="99")
        await place.clock.advance(60)
        await place.ask(UNREAD, account="99")
        assert endpoint.calls == []


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
        await place.ask(f"omni {UNREAD}", **group)
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


async def test_whom_somebody_chose_is_shown_while_they_see_it(endpoint: ScriptedEndpoint) -> None:
    meant = "Where no robot is named, this one is meant: kuka1\n"
    async with NarrowPlace(endpoint.client()).open() as place:
        await place.allow(LI)
        granted = await place.say("/grant Li kuka1:wave for 10 min")
        assert "kuka1" in granted
        await place.say("use kuka1", account=LI, chat=LI)
        await place.ask(UNREAD, account=LI)
        assert meant in endpoint.calls[-1].instructions
        await place.clock.advance(15 * 60)
        await place.ask(UNREAD, account=LI)
        assert len(endpoint.calls) == 2
        assert "kuka1" not in endpoint.calls[-1].instructions
