"""Nothing said in a chat is English by oversight: every word is from the reader's catalogue."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from rosic.core.i18n import in_language, joined, said
from rosic.gateway.chat_handler import FAULT
from tests.gateway.place import ADA, BO, VI, BrokenStore, Place
from tests.gateway.tongue import Bracketed, forgotten, forgotten_in

if TYPE_CHECKING:
    from rosic.core.message import Outbound

PEOPLE = {"A": ADA, "B": BO, "V": VI}
# Robots, people, roles, skills and what they take; what people type; what is called as it is.
NAMES = frozenset(
    [
        "omni",
        "kuka1",
        "cf1",
        "cf2",
        "swarm",
        "ada",
        "bo",
        "vi",
        "operator",
        "viewer",
        "senior",
        "admin",
        "wizard",
        "move",
        "wave",
        "look",
        "distance",
        "direction",
        "forward",
        "back",
        "left",
        "stop",
        "help",
        "for",
        "join",
        "tomorrow",
        "europe",
        "vienna",
        "utc",
        "deutsch",
        "english",
        "kg",
    ]
)
CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b|\bi[0-9a-f]{16}\b")

# Who says what; [ taps the button of that label, + lets seconds pass.
SCRIPT = """
A status
A help
A help omni
A robots
A use omni
A move 1 m
A status
A move 9 m
A move 0.001 m
A move -1 m
A move 5 kg
A move 1 m 2 m
A move up
A move distance=1 distance=2
A move foo=3
A move
A wave 3
A grasp
A jump high
A xyzzy
A omni dance
A foo move 1 m
A kuka2 move 1 m
A please stop now
A swarm wave
A swarm dance
A use none
A wave
A use omni
A [Wave
A use omni
A [Move
A use nobody
A use swarm
B omni wave
V omni wave
V omni look
B kuka1 move 1 m
B kuka1 move 1 m
A stop omni
B omni wave
A omni wave
A resume omni
A resume omni
A stop
A resume
A resume kuka1
A resume cf1
A resume cf2
A resume omni
A +3600
A /start
V /start
A information
V information
A /me
B /me
A /people
A /people zz
A /invite
A /invite operator omni for 2h
A /invite operator for
A /invite wizard
A /invite operator omni for 2h code 10 min as Eve
A /invite operator kuka9
B /invite operator
A /lock Bo
A /people
A /unlock
A /unlock Bo
A /unlock Bo
A /lock
A /lock nobody
A /lock me
A [⟦Leave it⟧
A /revoke
A /revoke Vi
A [⟦Leave it⟧
A /revoke me
A /code 123456
A /code abc
A /authenticator reset
A /authenticator reset Bo
A /book omni tomorrow 14:00 1h
A /book omni tomorrow 14:00 1h
B /book omni tomorrow 14:30 1h
B book omni yesterday
B book omni tomorrow 14:00
B book omni 1h
B book omni tomorrow
B book omni
B book
B book omni tomorrow 15:00 30 days
B book omni every tue 9:00 1h 5 times
B book omni every tue 9:00 1h
B book omni 2020-01-01 14:00 1h
B book omni feb 30 14:00 1h
B book omni tomorrow 14:00 1h until 15:00
B book omni tomorrow 25:00 1h
B book omni now 0 min
B book omni now 1h
B slots
B slots omni
B slots omni tomorrow
A slots
A slots kuka1
B cancel
B /me
A wait omni
A wait omni
B wait
B wait none
A wait none
A take over omni
A take over kuka1
B end omni
B end kuka1
A cancel
A /settings
A /settings units imperial
A /settings units foo
A /settings robot omni
A /settings robot zz
A /settings speed 0.2 m/s
A /settings speed
A /settings speed 3 kg
A /settings speed 0 m/s
A /settings speed fast
A /settings zone Europe/Vienna
A /settings zone Mars
A /settings zone
A /settings foo
A /settings
A /settings speed none
A /settings zone none
A /settings robot none
A /language
A /language klingon
A /mydata
A /forget
A /forget me
A /forget Bo
A /archive
A /archive on
A /archive
A /archive on 9999 days
A /archive off
A /archive off
A /archive erase
B /archive on
A /data
A /data omni
A /data note = hello
A /data omni note = hello
A /data me
A /data note =
A /security
A /approve x
A /decline x
A join ABCD-EFGH
A ?
A ?omni wave
A rm -rf
A omni wave|kuka1 wave
A cf1 wave
A /slots omni tomorrow
A cancel all
"""


async def follow(place: Place, line: str) -> list[Outbound]:
    """Let somebody say a line of the script; return what was told because of it."""
    who, _, text = line.partition(" ")
    before = len(place.chat.told)
    if text.startswith("+"):
        await place.clock.advance(float(text[1:]))
    elif text.startswith("["):
        button, under = place.button(text[1:])
        await place.tap(button, under, PEOPLE[who])
    else:
        account = PEOPLE[who]
        await place.say(text.replace("|", "\n"), account=account, chat=account)
    return [told.outbound for told in list(place.chat.told)[before:]]


async def bracketed(place: Place) -> None:
    """Let everybody speak the language that shows what was forgotten."""
    place.gateway.languages._catalogues["de"] = Bracketed()
    for account in PEOPLE.values():
        await place.say("/language de", account=account, chat=account)


@pytest.mark.limit(120)
async def test_nothing_was_forgotten() -> None:
    found: list[str] = []
    async with Place().open() as place:
        await bracketed(place)
        for line in filter(None, SCRIPT.splitlines()):
            for outbound in await follow(place, line):
                words = [w for w in forgotten_in(outbound, NAMES) if not CODE.search(w)]
                if words:
                    found.append(f"{line}: {words} in {outbound.text!r}")
    assert not found, "\n".join(found)


@pytest.mark.limit(120)
async def test_german_says_all_of_it() -> None:
    """No translation stumbles over its fields, and the English is not what is heard."""
    english: set[str] = set()
    async with Place().open() as place:
        for line in filter(None, SCRIPT.replace("⟦", "").replace("⟧", "").splitlines()):
            english |= {outbound.text for outbound in await follow(place, line)}
    async with Place().open() as place:
        for account in PEOPLE.values():
            await place.say("/language de", account=account, chat=account)
        heard: set[str] = set()
        for line in filter(None, SCRIPT.splitlines()):
            if " [" not in line:
                heard |= {outbound.text for outbound in await follow(place, line)}
    assert FAULT not in heard
    assert not [text for text in heard if "schiefgegangen" in text]
    same = [text for text in english & heard if forgotten(text, NAMES)]
    assert not same


async def test_a_disk_that_is_full_is_told_in_ones_own_language() -> None:
    store = BrokenStore()
    async with Place(store).open() as place:
        await bracketed(place)
        store.broken = True
        for line in ("A omni wave", "A /lock Bo", "A /book omni tomorrow 14:00 1h"):
            for outbound in await follow(place, line):
                assert not forgotten_in(outbound, NAMES), outbound.text


def test_the_check_can_fail() -> None:
    catalogue = Bracketed()
    name = said("{name} is here, {how}.", name="Ada", how="in English")
    assert forgotten(in_language(name, catalogue), NAMES) == ["in"]
    glued = f"{said('at rest')} · {said('free')}"
    assert forgotten(in_language(glued, catalogue), NAMES) == ["at", "rest", "free"]
    kept = joined(" · ", (said("at rest"), said("free")))
    assert forgotten(in_language(kept, catalogue), NAMES) == []
