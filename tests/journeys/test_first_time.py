"""First times: joining, driving and stopping, booking, being refused. Taps are counted."""

from __future__ import annotations

import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.testing.telegram.newcomer import Newcomer
from rosic.testing.telegram.picture import draw, in_picture
from rosic.testing.telegram.transcript import ENGLISH as IN_ENGLISH
from rosic.testing.telegram.transcript import App
from tests.journeys.lab import Lab, lab
from tests.journeys.pictures import (
    ASKED_TO_DRAW,
    FOLDER,
    PAGE,
    check_counts,
    check_picture,
    lines_of,
    row,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ('[[robot]]\nprofile = "omni"\nlink = "simulated"',)
CODE = re.compile(r"start=([A-Za-z0-9_-]+)")
TAPS_TO_A_MOTION = 4


class Tongue(NamedTuple):
    """A language that somebody's phone speaks.

    Attributes:
        code: As Telegram says it.
        app: Telegram's own words on that phone.
    """

    code: str
    app: App

    def __call__(self, english: str, german: str) -> str:
        """Return what is read in this language."""
        return german if self.code == "de" else english

    def picture(self, name: str) -> str:
        """Return what the picture of a path is called."""
        return self(name, f"{name}-de")

    async def newcomer(self, place: Lab, account: int) -> Newcomer:
        """Return somebody who is known already, with a phone of this language."""
        if self.code != "en":
            await place.control.call("set_language", user=account, language_code=self.code)
        return Newcomer(place, account, app=self.app)


ENGLISH = Tongue("en", IN_ENGLISH)
GERMAN = Tongue("de", App("STARTEN", "bearbeitet"))


@asynccontextmanager
async def one_robot(folder: Path, launcher: Launcher) -> AsyncIterator[Lab]:
    """Run a gateway with one simulated robot, whose time is not soon over."""
    async with lab(folder, launcher, robots=OMNI) as place:
        await place.start()
        yield place
        assert await place.control.violations() == []


async def finished(name: str, somebody: Newcomer, capsys: pytest.CaptureFixture[str]) -> None:
    """Count, say so, and hold it against the documentation."""
    await somebody.place.drained()
    shown = await somebody.saw()
    assert (shown.taps, shown.typed) == (somebody.taps, somebody.typed)
    with capsys.disabled():
        counts = f"{shown.taps} taps, {shown.typed} typed, {shown.read} to read"
        print(f"\nfirst time, {name}: {counts}")  # noqa: T201 - the figures are the point
    check_picture(name, shown)
    check_counts(name, shown)


async def test_from_start_to_a_first_motion_in_four_taps(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        said = await place.ask(place.ada, "/invite operator omni for 2h", "start=")
        [code] = CODE.findall(said["text"])
        cy = Newcomer(place, await place.control.create_user("Cy"))

        await cy.start(code, "You are invited as operator on omni")
        await cy.tap("Join", "What should omni do?")
        await cy.tap("🚗 Move in a straight line", "0.50 m forward?")
        await cy.tap("Do it", "moved 0.50 m forward")

        assert cy.taps <= TAPS_TO_A_MOTION
        assert cy.typed == 0
        await place.ask(place.ada, "status omni", "x 0.50 m")
        await finished("join", cy, capsys)


async def test_the_same_in_german(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        said = await place.ask(place.ada, "/invite operator omni for 2h", "start=")
        [code] = CODE.findall(said["text"])
        account = await place.control.create_user("Cy", language_code="de")
        cy = Newcomer(place, account, app=App("STARTEN", "bearbeitet"))

        await cy.start(code, "eingeladen")
        await cy.tap("Beitreten", "Was soll omni tun?")
        await cy.tap("🚗 Ein Stück fahren", "0,50 m vorwärts?")
        await cy.tap("Mach es", "0,50 m vorwärts gefahren")

        assert cy.taps <= TAPS_TO_A_MOTION
        await finished("join-de", cy, capsys)


@pytest.mark.parametrize("said", [ENGLISH, GERMAN], ids=["en", "de"])
async def test_asking_for_a_right(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str], said: Tongue
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        told = await place.ask(place.ada, "/invite viewer omni", "start=")
        [code] = CODE.findall(told["text"])
        account = await place.control.create_user("Vi", language_code=said.code)
        vi = Newcomer(place, account, app=said.app)
        ada = Newcomer(place, place.ada)

        await vi.start(code, said("You are invited as viewer", "eingeladen"))
        await vi.tap(said("Join", "Beitreten"), said("You are in, as", "Du bist dabei"))
        await vi.type("omni move 0.5 m", said("needs the right", "das Recht"))
        await vi.tap(
            said("Ask for it", "Darum bitten"), said("I have asked Ada", "Ich habe gefragt (Ada)")
        )
        await ada.tap("Allow 1 h", "Vi may now")
        await vi.reads(said("Ada allows it. You may now", "Ada erlaubt es"))
        await vi.type("omni move 0.5 m", said("moved 0.50 m forward", "0,50 m vorwärts gefahren"))

        await finished(said.picture("ask"), vi, capsys)


@pytest.mark.parametrize("said", [ENGLISH, GERMAN], ids=["en", "de"])
async def test_driving_and_stopping_with_buttons(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str], said: Tongue
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        bo = await said.newcomer(place, place.bo)

        await bo.start("", said("What should omni do?", "Was soll omni tun?"))
        straight = said("🚗 Move in a straight line", "🚗 Ein Stück fahren")
        await bo.tap(straight, said("0.50 m forward?", "0,50 m vorwärts?"))
        await bo.tap("+", said("1.00 m forward?", "1,00 m vorwärts?"))
        await bo.tap("+", said("2.00 m forward?", "2,00 m vorwärts?"))
        await bo.tap(said("Do it", "Mach es"), said("driving", " %"))
        await bo.tap("STOP", said("STOP: omni at rest", "STOP: omni steht still"))
        await bo.reads(said("stopped before it ended", "vor dem Ende angehalten"))
        await bo.type("resume omni", said("omni is ready again.", "omni ist wieder bereit."))

        await finished(said.picture("drive"), bo, capsys)


@pytest.mark.parametrize("said", [ENGLISH, GERMAN], ids=["en", "de"])
async def test_booking_a_time(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str], said: Tongue
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        bo = await said.newcomer(place, place.bo)

        await bo.type("book", said("When, and for how long?", "Wann"))
        tomorrow = said("Book omni, tomorrow 14:00 1h", "omni, morgen 14:00 1h buchen")
        await bo.tap(tomorrow, said("omni is yours on", "omni gehört dir"))

        await finished(said.picture("book"), bo, capsys)


@pytest.mark.parametrize("said", [ENGLISH, GERMAN], ids=["en", "de"])
async def test_being_refused_and_asking_to_be_next(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str], said: Tongue
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        ada, bo = Newcomer(place, place.ada), await said.newcomer(place, place.bo)
        await ada.type("book omni now 1h", "omni is yours")

        await bo.start("", said("not just now. omni is taken by Ada", "nur gerade nicht."))
        await bo.type("omni move 0.5 m", said("omni is taken by Ada until", "Ada"))
        await bo.tap(
            said("Wait for omni", "Auf omni warten"),
            said("You are number 1 in the queue for omni", "Du bist Nummer 1"),
        )
        await ada.tap("Cancel it", "omni is given back")
        await bo.reads(said("omni is free and it is your turn", "omni ist frei, und du bist dran"))
        await bo.tap(
            said("Take it", "Übernehmen"), said("omni is yours now", "omni gehört jetzt dir")
        )
        await bo.tap("omni", said("Its name may be left out now.", "Der Name darf jetzt fehlen."))

        await finished(said.picture("refused"), bo, capsys)


# ---- the pictures themselves ----


def test_every_picture_is_drawn_as_one_is_drawn_today_and_is_on_the_page() -> None:
    page = PAGE.read_text()
    pictures = sorted(FOLDER.glob("*.svg"))
    assert pictures
    for file in pictures:
        assert draw(in_picture(file.read_text())) == file.read_text(), f"{file.name}: make pictures"
        assert f"(pictures/{file.name})" in page


def test_a_picture_that_says_something_else_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(ASKED_TO_DRAW, raising=False)
    shown = in_picture((FOLDER / "join.svg").read_text())
    other = in_picture((FOLDER / "join.svg").read_text().replace("You are in, ", "You are here, "))
    assert lines_of(other) != lines_of(shown)
    with pytest.raises(AssertionError, match="make pictures"):
        check_picture("join", other)
    with pytest.raises(AssertionError, match="should say"):
        check_counts("drive", shown)
    assert row("join", shown) in PAGE.read_text()


@pytest.mark.parametrize("said", [ENGLISH, GERMAN], ids=["en", "de"])
async def test_first_words_of_ones_own(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str], said: Tongue
) -> None:
    async with one_robot(tmp_path, launcher) as place:
        ada = await said.newcomer(place, place.ada)

        await ada.type(
            said("hello", "hallo"), said("Hello. What should omni do?", "Hallo. Was soll omni tun?")
        )
        await ada.type(
            said("can you move omni half a meter forward?", "omni fahr mal 50 cm vor"),
            said("moved 0.50 m forward", "0,50 m vorwärts gefahren"),
        )
        proposed = said("Is that what you mean?", "Ist das gemeint?")
        await ada.type(said("a bit more", "noch ein bisschen"), proposed)
        await ada.tap(
            said("omni move forward 0.25 m", "omni fahre vorwärts 0,25 m"),
            said("moved 0.25 m forward", "0,25 m vorwärts gefahren"),
        )
        await ada.type(said("where is omni?", "wo ist omni?"), said("at rest", "steht"))
        await ada.type(
            said("omni should never move 1 m", "omni soll nie 1 m fahren"),
            said("I read no order in that", "keinen Befehl"),
        )
        await ada.type(said("undo", "rückgängig"), proposed)
        await ada.tap(
            said("omni move back 0.25 m", "omni fahre zurück 0,25 m"),
            said("moved 0.25 m back", "0,25 m zurück gefahren"),
        )

        await finished(said.picture("words"), ada, capsys)
