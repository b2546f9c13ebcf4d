"""A person who reads German is taken through everything, and reads no English word."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic_sim.robots.robot import SimulatedRobot
from tests.gateway.place import ADA, BO, VI, Place
from tests.texts import read

if TYPE_CHECKING:
    from rosic.core.message import Outbound

FLEET = tuple(
    load_profile(shipped_profiles()[name], link="simulated")
    for name in ("kuka1", "omni", "yumi", "cf1", "cf2")
)
CHATS = {"A": ADA, "B": BO, "V": VI}
_WORD = re.compile(r"(?<![\w/:*-])[A-Za-zÄÖÜäöüß]{2,}(?![\w:*])")
_FIELD = re.compile(r"\{[^}]*\}")
# What is typed, after a slash and between quotation marks, says nothing of what the code says.
_TYPED = re.compile(r"/\S+(?: [^\s.,·)]+)*|\"[^\"]*\"")
# In both languages (a right has the name by which it is given), or names of this place.
_NAMES = frozenset(
    "ada bo vi omni yumi kuka iiwa crazyflie stop clip admin english read".split()  # noqa: SIM905
)
_QUOTED = re.compile(r"\"([^\"]*)\"")
# Words of profiles: German sentences have them where they show what to type.
_IN_PROFILES = frozenset(
    word.casefold()
    for profile in FLEET
    for skill in profile.skills.values()
    for text in (
        skill.id,
        skill.title,
        *skill.parameters,
        *profile.telemetry,
        *(choice for p in skill.parameters.values() for choice in p.choices or ()),
    )
    for word in _WORD.findall(text.replace("_", " "))
) - frozenset(["arm", "formation", "in"])

# Who says what; [ taps the button of that label, + lets seconds pass.
SCRIPT = """
A hilfe
A hilfe flotte
A hilfe aufgabe
A aufgabe hilfe
A help move
A help see
A help share
A help fleet
A help alarms
A help omni
A help kuka1
A help yumi
A help cf1
A omni
A zustand
A roboter
A omni fahre links 20 cm
A omni fahre 0,2 m nach rechts mit 0,4 m/s
A omni drehe um 90 grad nach rechts
A omni arm grundstellung
A omni arm transport
A fahre 0,3 m zurück
A fahre 0,3 m zurück
A omni
A omni move 40 m
A omni move
A omni move 1 kg
A omni move oben
A omni move 1 m 1 m
A omni move distance=1 strecke=2
A omni move foo=3
A omni arm
A omni drive 1 m/s 9 s
A kuka1 greifen kraft=20
A kuka1 move joint 9 20
A kuka1 loslassen
A yumi handover
A yumi home
A cf1 abheben höhe=1 m
A cf1 follow cf2
A cf1 landen
A omni fahre 3 m
B omni fahre 1 m
A omni fahre 1 m
A weiter
A pause
A weiter omni
A stopp omni
B omni fahre 1 m
B freigeben omni
A freigeben omni
A freigeben omni
A /settings
A /settings speed 0.2 m/s
A /settings
A omni move 1 m speed=0.5
A omni move 1 m
A /me
A /settings speed none
A buchen
A buchen omni morgen 14:00 1h
A buchen omni am dienstag
A buchen omni jeden dienstag 9 uhr 1 stunde 5 mal
B buchen omni morgen 14:30 1h
B buchen omni übermorgen um 9 uhr für 2 stunden
A zeiten omni
A abbrechen buchung
A abbrechen
B fahre 1 m
B warten omni
B warten
V omni fahre 1 m
V /me
V bitten omni move
V bitten omni freigeben
V bitten
A bitten
A aufgabe
A aufgabe omni fahre 10 cm dann fahre 10 cm
A wunsch
A wunsch omni
A wunsch omni 1h morgen 9:00 bis 17:00
A zeiten omni irgendwann
A noch einmal
A rückgängig
A verlauf omni akku
A verlauf omni
A weg omni
A bild omni
A karte omni
A tafel
A flotte
A aufgabe omni fahre 10 cm
A aufgaben
A alarme
A /strategy omni
A /strategy omni careful speed=10cm/s now
A /strategy omni careful speed=90 m/s
A /role
A /rolle gast darf omni:move mit tempo <= 0,2 m/s
A /mute
A /share
A /teilen bay mit Bo
A /invite
A /grant
A /settings einheiten krumm
A /settings tempo 0,2 m/s
A aufgabe omni fahre 10 cm
A omni fahre 1 m mit 0,5 m/s
A /settings tempo keins
A hilfe broadcast
A aufgabe omni fahre 50 m
A übergeben Bo
A /files foo
A /quiet
A /lock
A /revoke
A /unlock
A wunsch aus 7
A hilfe mitteilen
A hilfe mission
A leute
A einladen viewer
A einladen bediener omni
A geben bo bediener omni for 1h
A protokoll
A protokoll omni
A daten
A /broadcast cf1 abheben
A stopp
"""


class Simulated(Place):
    """Its robots say what they do."""

    kind = SimulatedRobot


def words_of(text: str) -> set[str]:
    """Return the words of a text, without what is typed as it stands."""
    return {word.casefold() for word in _WORD.findall(_TYPED.sub(" ", text))}


def _typed_here(quoted: str) -> bool:
    """Whether somebody typed what is quoted, in part if it is long."""
    return quoted.replace("\N{DIVISION SLASH}", "/").removesuffix(" …") in SCRIPT


def read_of(text: str) -> set[str]:
    """Return the words that somebody reads: what they are to type, too, and not what they typed."""
    text = _QUOTED.sub(lambda quoted: "" if _typed_here(quoted[1]) else quoted[0], text)
    typed = {word.casefold() for part in _TYPED.findall(text) for word in _WORD.findall(part)}
    return words_of(text) | typed


def english() -> frozenset[str]:
    """Return the words that the code says in English, and that German never uses."""
    said, german = set[str](), set[str]()
    for message in read("de"):
        for kept, forms in ((said, message.id), (german, message.string or "")):
            for form in (forms,) if isinstance(forms, str) else forms:
                kept |= words_of(_FIELD.sub(" ", form))  # noqa: PLW2901 - a set that grows
    return frozenset((said - german) | _IN_PROFILES) - _NAMES


def unsaid_in(outbound: Outbound, words: frozenset[str]) -> list[str]:
    """Return English words of a message and its buttons, and decimals with a point."""
    labels = [
        button.label
        for row in outbound.buttons
        for button in row
        if button.label.strip("/") != button.command.lstrip("/?!")
    ]
    found = [word for text in (outbound.text, *labels) for word in read_of(text) & words]
    points = [
        p
        for text in (outbound.text, *labels)
        for p in re.findall(r"\d\.\d+ ?[a-zA-Z%°]+", _TYPED.sub(" ", text))
    ]
    return [*found, *points]


async def follow(place: Place, line: str) -> list[Outbound]:
    """Let somebody say a line, and let what it began end; return what was told because of it."""
    who, _, text = line.partition(" ")
    place.chat.told.clear()
    if text.startswith("["):
        button, under = place.button(text[1:])
        await place.tap(button, under, CHATS[who])
    else:
        await place.say(text, account=CHATS[who], chat=CHATS[who])
    for _ in range(2 if text == "omni fahre 3 m" else 60):
        await place.clock.advance(0.25)
    return [told.outbound for told in list(place.chat.told)]


@pytest.mark.limit(300)
async def test_a_german_person_reads_no_english_word_anywhere() -> None:
    words, found = english(), []
    assert {"direction", "distance", "battery", "busy", "straight", "move"} <= words
    async with Simulated(fleet=FLEET).open() as place:
        for account in CHATS.values():
            await place.say("/language de", account=account, chat=account)
        for line in filter(None, SCRIPT.splitlines()):
            told = await follow(place, line)
            assert told, line
            for outbound in told:
                unsaid = sorted(set(unsaid_in(outbound, words)))
                found += [f"{line}: {unsaid} in {outbound.text!r}"] * bool(unsaid)
    assert not found, "\n".join(dict.fromkeys(found))
