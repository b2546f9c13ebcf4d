"""Programs in a whole gateway: what they may say, and that they confirm nothing."""

from __future__ import annotations

import asyncio
import socket
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as some
from msgspec.structs import replace

from rosic.app.features import command_table
from rosic.app.people import ConfiguredPerson
from rosic.config.profiles import known_units
from rosic.core.identity import PROGRAM, Address
from rosic.core.language import Do, LanguageReader, Vocabulary, VocabularyHolder
from rosic.core.message import AnswerState, Button, Chat, Outbound
from rosic.core.policy.roles import SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.skill import Parameter, Skill, SkillClass
from rosic.core.secret import Secret
from rosic.errors import (
    ConfigurationError,
    MessengerFault,
    NotUnderstood,
    TooManyRequests,
    Unrecognised,
)
from rosic.gateway.programs import ProgramService, _given, _says, _word
from rosic.gateway.replies import CONFIRMED
from rosic.messengers.mcp.messenger import (
    CALLS_AT_MOST,
    McpMessenger,
    McpSettings,
    mcp_messenger,
)
from rosic.testing.clock import ManualClock
from tests.gateway.place import BO, FLEET, MOVE, PEOPLE, VI, Place
from tests.gateway.test_rights import rules

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.message import Inbound
    from rosic.messengers.program.calls import Answer

HAL, SAL = Address(PROGRAM, "hal"), Address(PROGRAM, "sal")
SAY = Skill(id="tell", kind=SkillClass.TASK, parameters={"words": Parameter(text=True)})


def programs_of(clock: ManualClock) -> McpMessenger:
    return McpMessenger("mcp", McpSettings(wait_s=60), clock)


class Lab(Place):
    """A place with two programs; what they say waits in a task of the test's."""

    people = (
        *PEOPLE,
        ConfiguredPerson("Hal", (HAL,), ("operator",)),
        ConfiguredPerson("Sal", (SAL,), ("operator",)),
    )
    besides = (programs_of,)

    @property
    def programs(self) -> McpMessenger:
        found = self.gateway._parts.messengers[1]
        assert isinstance(found, McpMessenger)
        return found

    async def call(self, text: str, *, who: Address = HAL, robot: str = "") -> Call:
        """Let a program say a line; return the call once everything has happened that can."""
        await self.clock.advance(0.001)
        call = Call(self, text, who, robot)
        await self.quiet()
        return call


class Call:
    """A call under way."""

    def __init__(self, lab: Lab, text: str, who: Address, robot: str) -> None:
        self.told: list[str] = []
        self.task: asyncio.Task[Answer] = asyncio.create_task(
            lab.programs.say(who, text, self._tell, robot=robot)
        )

    async def _tell(self, text: str) -> None:
        self.told.append(text)

    @property
    def answer(self) -> Answer:
        assert self.task.done(), self.told
        return self.task.result()


@asynccontextmanager
async def lab(*care: SkillPrecondition, limit: RateLimit | None = None) -> AsyncIterator[Lab]:
    place = Lab(limit=limit)
    place.gateway._settings = replace(place.gateway._settings, rulebook=rules(*care))
    async with place.open():
        yield place


async def test_what_has_to_be_confirmed_is_asked_of_people_and_then_begun() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), confirm=True)) as place:
        call = await place.call("omni wave")
        asked = "A person has to confirm that first. I have asked Ada or Bo; you will hear from me."
        assert (call.told, call.task.done(), place.acted()) == ([asked], False, 0)
        await place.tap(*place.button("I agree"), account=BO)
        await place.clock.advance(1.0)
        await place.quiet()
        assert place.acted() == 1
        assert "Bo agrees: omni: wave." in call.told
        assert call.answer.good
        assert call.answer.text.startswith("omni: wave\n")
        again = await place.call("omni wave")
        assert not again.task.done(), "what was agreed to was agreed to once"


async def test_a_no_is_the_answer_and_one_that_gives_up_takes_its_question_back() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), confirm=True)) as place:
        call = await place.call("omni wave")
        await place.tap(*place.button("No"), account=BO)
        assert not call.answer.good
        assert call.answer.text == "Bo does not agree: omni: wave. Nothing was done."
        gone = await place.call("omni wave", robot="omni")
        gone.task.cancel()
        await place.quiet()
        assert place.gateway.pipeline.confirmation._requests == {}
        await place.tap(*place.button("I agree"), account=BO)
        assert place.acted() == 0


async def test_a_program_confirms_nothing_whatever_it_gets_hold_of() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), confirm=True)) as place:
        own = await place.call(f"{CONFIRMED}omni wave")
        assert not own.answer.good
        # Even a button, which no program is ever offered.
        directory = place.gateway.rooms.authoriser.directory
        found = directory.at(HAL)
        assert found is not None
        caller = place.gateway.rooms.authoriser.stand_for(found[0].id)
        pipeline, chat = place.gateway.pipeline, Chat(PROGRAM, HAL.account)
        bound = pipeline.agreements.bind(Button("Do it", f"{CONFIRMED}omni wave"), caller, chat)
        issued = place.gateway.rooms.authoriser.buttons.issue(bound, found[0].id, chat.id)
        inbound = replace(place.programs.inbound(HAL, ""), nonce=issued.nonce, tap="t")
        await pipeline.receive(place.programs, inbound)
        await place.quiet()
        assert place.acted() == 0
        said = place.programs.unsolicited.take(HAL.account)
        assert said == ("Only a person can agree to it.",)


async def refusals(_text: str) -> None:
    """Hear how a stop goes."""


async def test_no_program_is_asked_or_may_agree_for_somebody_else() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), second_person=True)) as place:
        told = await place.say("omni wave", account=BO, chat=BO)
        assert "I have asked Ada; you" in told, "not Hal, and not Sal"
        button, under = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[button.nonce].command
        tried = await place.call(command)
        assert tried.answer.text == "Only a person can agree to it."
        assert not tried.answer.good
        assert "Bo is told" in await place.tap(button, under)


async def test_a_second_factor_is_asked_of_people_alone() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), step_up=True)) as place:
        call = await place.call("omni wave")
        assert not call.answer.good
        assert "a program has none" in call.answer.text


async def test_a_program_is_told_each_time_that_it_asks_too_much() -> None:
    async with lab(limit=RateLimit(burst=2, per_s=0.001)) as place:
        answers = [(await place.call("status")).answer for _ in range(6)]
        assert [answer.good for answer in answers] == [True, True, False, False, False, False]
        assert all("Again in" in answer.text for answer in answers[2:])
        stopped = asyncio.create_task(place.programs.stop(HAL, (), refusals))
        await place.quiet()
        await place.clock.advance(1.0)
        assert (await stopped).good
        assert place.gateway.rooms.stops["omni"].latched


async def test_what_is_said_to_a_program_unsolicited_comes_with_its_next_answer() -> None:
    async with lab() as place:
        who = place.gateway.rooms.authoriser.directory.at(HAL)
        assert who is not None
        place.gateway.kernel.reach.tell((who[0].id,), "The dock is closed.")
        await place.quiet()
        assert (await place.call("status")).answer.besides == ("The dock is closed.",)
        assert (await place.call("status")).answer.besides == ()


async def test_one_program_hears_nothing_of_another() -> None:
    async with lab() as place:
        call = await place.call("omni wave", who=SAL)
        await place.clock.advance(1.0)
        await place.quiet()
        assert call.answer.good
        refused = await place.call("omni wave")
        assert "taken by Sal" in refused.answer.text
        assert place.programs.unsolicited.take(HAL.account) == ()
        assert call.answer.besides == ()


async def test_what_is_said_in_another_conversation_is_not_told() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), confirm=True)) as place:
        call = await place.call("omni wave")
        [cause] = place.programs.calls._calls
        other = Outbound(chat=Chat(PROGRAM, SAL.account), text="For Sal.", cause=cause)
        await place.programs.send(other)
        await place.quiet()
        assert not call.task.done()
        assert place.programs.unsolicited.take(SAL.account) == ("For Sal.",)


GO = Skill(
    id="go",
    parameters={
        "where": Parameter(choices={"Dock": (), "top left": (), "x=y": ()}),
        "times": Parameter(min=0, max=9, default=1),
    },
)


@pytest.mark.parametrize(("where", "said"), [("Dock", True), ("top left", True), ("x=y", False)])
async def test_a_text_that_would_say_something_else_is_not_said(where: str, said: bool) -> None:
    fleet = (replace(FLEET[0], skills={GO.id: GO}),)
    async with Lab(fleet=fleet).open() as place:
        service = ProgramService(place.gateway.rooms, place.gateway.access.programs)
        values = {"where": where, "times": 2}
        if said:
            assert service.line(HAL, "omni", "go", values) == f"omni go where={where} times=2.0"
            return
        with pytest.raises(NotUnderstood, match="cannot be said in one line"):
            service.line(HAL, "omni", "go", values)


@pytest.mark.parametrize(
    "settings",
    [{"port": 70_000}, {"port": "8765"}, {"wait_s": 0}, {"host": "0.0.0.0"}],  # noqa: S104 - refused
)
def test_a_wrong_setting_is_named(settings: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match=r"The messenger mcp: .* It knows: port, wait_s\."):
        mcp_messenger("mcp", settings, ManualClock())


async def test_a_port_that_is_taken_is_one_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        messenger = mcp_messenger("mcp", {"port": port}, ManualClock())
        with pytest.raises(ConfigurationError, match=f"Port {port} of this machine cannot be"):
            await messenger.run(nobody)


async def nobody(_inbound: Inbound) -> None:
    """Receive nothing."""


async def test_nothing_is_said_before_anybody_listens() -> None:
    messenger = mcp_messenger("mcp", {}, ManualClock())
    with pytest.raises(MessengerFault, match="does not listen yet"):
        await messenger.say(HAL, "status", refusals)
    with pytest.raises(MessengerFault, match="does not listen yet"):
        messenger.attach(Secret("rosic_k1_x"))


async def test_no_more_than_so_many_calls_at_once_but_for_stops() -> None:
    async with lab(SkillPrecondition(scopes=("omni:*",), confirm=True)) as place:
        calls = [await place.call("omni wave") for _ in range(CALLS_AT_MOST)]
        over = await place.call("status")
        assert isinstance(over.task.exception(), TooManyRequests)
        assert not (await place.call("status", who=SAL)).task.exception()
        stopped = asyncio.create_task(place.programs.stop(HAL, ("omni",), refusals))
        await place.quiet()
        await place.clock.advance(1.0)
        assert (await stopped).good
        for call in calls:
            call.task.cancel()


async def test_an_answer_says_what_it_comes_to_for_people_too() -> None:
    async with lab() as place:
        await place.say("omni wave", account=BO, chat=BO)
        assert place.last()[1].state is AnswerState.DONE
        await place.say("omni fly", account=BO, chat=BO)
        assert place.last()[1].state is AnswerState.NOT_DONE
        await place.say("status", account=VI, chat=VI)
        assert place.last()[1].state is AnswerState.FINAL


VOCABULARY = Vocabulary.build(
    (replace(FLEET[0], skills={MOVE.id: MOVE, SAY.id: SAY}),), known_units(), command_table()
)
READER = LanguageReader(VocabularyHolder(VOCABULARY))


@given(
    some.floats(min_value=0.01, max_value=5.0, allow_nan=False),
    some.sampled_from(["forward", "back", "left", None]),
)
def test_values_become_a_line_that_says_just_these(distance: float, direction: str | None) -> None:
    compiled = VOCABULARY.compiled_skill("omni", "move")
    assert compiled is not None
    given_values = _given(compiled, {"distance": distance, "direction": direction})
    line = " ".join(["omni", compiled.spoken, *(_word(*one) for one in given_values)])
    [read] = READER.lines(line, "", frozenset({"omni"}))
    assert isinstance(read, Do)
    assert _says(read, "omni", "move", given_values)


@given(some.text(max_size=60))
def test_a_text_says_no_more_than_itself(text: str) -> None:
    compiled = VOCABULARY.compiled_skill("omni", "tell")
    assert compiled is not None
    try:
        given_values = _given(compiled, {"words": text})
    except NotUnderstood:
        return
    line = " ".join(["omni", compiled.spoken, *(_word(*one) for one in given_values)])
    read = READER.lines(line, "", frozenset({"omni"}))
    if len(read) == 1 and _says(read[0], "omni", "tell", given_values):
        assert "\n" not in line


@pytest.mark.parametrize(
    "values",
    [
        {"distance": float("nan")},
        {"distance": float("inf")},
        {"distance": "1 m"},
        {"distance": [1]},
        {"distance": None},
        {"distance": 1, "direction": "left\nomni move 5 m"},
        {"distance": 1, "direction": 3},
        {"distance": 1, "speed": 2},
    ],
)
def test_values_of_another_kind_become_no_line(values: dict[str, object]) -> None:
    compiled = VOCABULARY.compiled_skill("omni", "move")
    assert compiled is not None
    with pytest.raises(NotUnderstood):
        _given(compiled, values)


async def test_what_a_program_may_see_and_ask_for_is_what_its_key_gives() -> None:
    async with lab(SkillPrecondition(scopes=("omni:move",), confirm=True)) as place:
        service = ProgramService(place.gateway.rooms, place.gateway.access.programs)
        assert set(service.robots(HAL)) == {"omni", "kuka1", "cf1", "cf2"}
        asks = {(one.robot, one.skill.id): one.asks for one in service.skills(HAL)}
        assert asks["omni", "move"]
        assert not asks["omni", "wave"]
        with pytest.raises(Unrecognised):
            service.robots(Address(PROGRAM, "nobody"))
        with pytest.raises(NotUnderstood):
            service.line(HAL, "omni2", "move", {"distance": 1})
        assert service.line(HAL, "omni", "move", {"distance": 1e-2}) == "omni move distance=0.01"
