"""A question that is not answered loses its buttons; one that is becomes its answer."""

from __future__ import annotations

from rosic.core.message import AnswerState
from tests.gateway.place import Place


def _labels(place: Place, message: str) -> list[str]:
    return [button.label for row in place.chat.shown(message).buttons for button in row]


async def test_a_question_that_nobody_answers_loses_its_buttons() -> None:
    async with Place().open() as place:
        await place.say("/start omni__wave")
        message, shown = place.last()
        await place.clock.advance(59.0)
        await place.quiet()
        assert "Do it" in _labels(place, message)
        assert place.chat.shown(message).state is AnswerState.ASKED
        await place.clock.advance(3.0)
        await place.quiet()
        assert _labels(place, message) == ["Ask again"]
        assert place.chat.shown(message).text == f"{shown.text}\nToo late: nothing was done."
        assert place.chat.shown(message).state is AnswerState.NOT_DONE


async def test_a_menu_lies_open_for_longer_and_keeps_what_stops() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        message = place.last()[0]
        await place.clock.advance(120.0)
        await place.quiet()
        await place.tap(*place.button("Wave"))
        await place.say("use omni")
        later = place.last()[0]
        await place.clock.advance(601.0)
        await place.quiet()
        assert _labels(place, later) == ["STOP", "Show again"]
        assert message != later


async def test_an_answer_is_not_stripped_when_the_questions_time_is_over() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("/start omni__wave")
        await place.tap(*place.button("Do it"))
        message, shown = place.last()
        assert "sent" in shown.text
        before = len(place.chat.told)
        await place.clock.advance(700.0)
        await place.quiet()
        assert len(place.chat.told) == before
        assert _labels(place, message) == ["STOP"]


async def test_the_question_becomes_the_life_it_asked_for() -> None:
    async with Place().open() as place:
        await place.say("/start omni__wave")
        question = place.last()[0]
        await place.tap(*place.button("Do it"))
        assert place.last()[0] == question
        assert "done" in place.last()[1].text
        assert _labels(place, question) == ["Again", "Back", "Menu"]


async def test_where_the_question_is_gone_the_life_has_a_message_of_its_own() -> None:
    async with Place().open() as place:
        await place.say("/start omni__wave")
        button, question = place.button("Do it")
        place.chat.tap(button, under=question)
        place.chat.delete(question)
        for _ in range(3):
            await place.clock.advance(1.0)
            await place.quiet()
        message, shown = place.last()
        assert message != question
        assert "done" in shown.text
        assert place.acted() == 1


async def test_what_expires_sooner_than_a_menu_that_was_shown_before_goes_in_its_time() -> None:
    async with Place().open() as place:
        await place.say("use omni")  # its menu lies open for ten minutes
        menu = place.last()[0]
        await place.clock.advance(1.0)
        await place.say("/start omni__wave")
        question = place.last()[0]
        await place.clock.advance(62.0)
        await place.quiet()
        assert _labels(place, question) == ["Ask again"]
        assert "Wave" in _labels(place, menu)


async def test_a_message_that_is_gone_is_not_said_again_only_to_lose_its_buttons() -> None:
    async with Place().open() as place:
        await place.say("/start omni__wave")
        question = place.last()[0]
        place.chat.delete(question)
        before = len(place.chat.told)
        await place.clock.advance(62.0)
        await place.quiet()
        assert len(place.chat.told) == before


async def test_what_asks_again_is_good_for_whoever_taps_it_and_moves_nothing_by_itself() -> None:
    async with Place().open() as place:
        await place.say("/start omni__wave")
        await place.clock.advance(62.0)
        await place.quiet()
        late = place.button("Ask again")
        for _ in range(2):
            await place.clock.advance(3_600.0)
            assert await place.tap(*late) == "omni: wave?"
        assert place.acted() == 0
        await place.tap(*place.button("Do it"))
        assert place.acted() == 1


async def test_it_is_said_in_the_language_of_whoever_was_asked() -> None:
    async with Place().open() as place:
        await place.say("/language de")
        await place.say("/start omni__wave")
        message = place.last()[0]
        await place.clock.advance(62.0)
        await place.quiet()
        assert place.chat.shown(message).text.endswith("\nZu spät: Es wurde nichts getan.")
        assert _labels(place, message) == ["Noch einmal fragen"]


async def test_what_cannot_be_asked_by_a_button_is_to_be_said_again() -> None:
    async with Place().open() as place:
        await place.say("/role student may omni:wave")
        message = place.last()[0]
        await place.clock.advance(700.0)
        await place.quiet()
        told = place.chat.shown(message).text
        assert told.endswith("\nToo late: nothing was done. Say it again.")
        assert _labels(place, message) == []


async def test_nothing_is_said_to_be_undone_where_a_button_was_used() -> None:
    """The answer to this tap is another message, so the question stays as it was."""
    async with Place().open() as place:
        await place.say("/start omni__wave")
        button, question = place.button("Do it")
        place.chat.tap(button, under="")
        await place.quiet()
        assert place.acted() == 1
        before = place.chat.shown(question).text
        await place.clock.advance(62.0)
        await place.quiet()
        assert place.chat.shown(question).text == before
        assert _labels(place, question) == []
