"""Bad input about rights, times and containers: one sentence each, nothing changed, nothing moved.

The order is that of what has to be shown: slots that overlap, lie in the past, are empty, last a
year, fall into the hour that the clocks skip; a rule that is none; a time zone that is none; roles
that include themselves; wildcards that match nothing; a container that was erased while it was in
use; a disk that is full when somebody is locked.
"""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.config.profiles import known_units
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules
from rosic.core.policy.validation import rulebook_mistakes
from rosic.testing.clock import ManualClock
from tests.gateway.place import BO, STRANGER, VI, BrokenStore, Place
from tests.gateway.test_rights import who
from tests.organiser.booking import NOW

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

WRITE_IT = "Write it as tomorrow 14:00 1h, or the day as 2027-02-01."
RULE = "Write it as FREQ=WEEKLY;BYDAY=TU;COUNT=10."
STRANGERS = "Hello. I work for people I know, and I do not know you yet. Ask the admin here."


@asynccontextmanager
async def vienna(store: BrokenStore | None = None) -> AsyncIterator[Place]:
    """Run a place in Vienna; it is 10:00 on 21 November 2026, and Bo has omni from 14:00."""
    place = Place(store, clock=ManualClock(NOW))
    place.gateway._settings = replace(place.gateway._settings, zone="Europe/Vienna")
    async with place.open():
        assert await place.say("/book omni 14:00 1h", account=BO, chat=BO) == (
            "omni is yours on Sat 21 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        yield place


SLOTS = [
    (
        "overlapping",
        "omni 14:30 1h",
        "omni is taken by Bo from 14:00 to 15:00. It is free from 15:00 on.",
    ),
    (
        "around another",
        "omni 13:00 3h",
        "omni is taken by Bo from 14:00 to 15:00. It is free from 15:00 on.",
    ),
    (
        "past",
        "omni 2026-11-20 14:00 1h",
        (
            "That time is over: it would have begun at Fri 20 Nov 14:00, and it is 10:00. "
            "Nothing was booked."
        ),
    ),
    ("zero", "omni 16:00 0h", "A time has to be longer than nothing. Nothing was booked."),
    ("below zero", "omni 16:00 -1h", f"A time cannot be shorter than nothing. {WRITE_IT}"),
    ("a year, in words", "omni 16:00 1 year", "One time may be at most 1 day. Nothing was booked."),
    (
        "a year, in days",
        "omni 16:00 365 days",
        "One time may be at most 1 day. Nothing was booked.",
    ),
    (
        "in the hour that the clocks skip",
        "omni 2027-03-28 02:30 1h",
        (
            "On Sun 28 Mar the clocks in Europe/Vienna go forward, and there is no 02:30. The next "
            "possible time is 03:00. Nothing was booked."
        ),
    ),
    (
        "a rule that is none",
        "omni FREQ=SOMETIMES;COUNT=2 14:00 1h",
        f'I cannot use "FREQ=SOMETIMES" in a rule. {RULE}',
    ),
    (
        "a rule of every second",
        "omni FREQ=SECONDLY;COUNT=2 14:00 1h",
        f'I cannot use "FREQ=SECONDLY" in a rule. {RULE}',
    ),
    (
        "a rule with a day that is none",
        "omni FREQ=WEEKLY;BYDAY=XX;COUNT=2 14:00 1h",
        f'I cannot use "BYDAY=XX" in a rule. {RULE}',
    ),
    (
        "a rule in pieces",
        "omni FREQ=WEEKLY;;COUNT=2 14:00 1h",
        f'I cannot use "FREQ=WEEKLY;;COUNT=2" in a rule. {RULE}',
    ),
    (
        "a rule without an end",
        "omni FREQ=WEEKLY;BYDAY=TU 14:00 1h",
        "Until when? A time that comes again needs a last day, or how many times.",
    ),
    (
        "a rule of a year of days that overlap",
        "omni FREQ=DAILY;COUNT=365 13:30 1h",
        "One of these times is taken: omni is Bo's at 14:00. Nothing was booked.",
    ),
    ("a day that is none", "omni every blursday 14:00 1h", "Every which day?"),
    ("an hour that is none", "omni 25:00 1h", f'There is no "25:00" on a clock. {WRITE_IT}'),
]


@pytest.mark.parametrize(("asked", "told"), [s[1:] for s in SLOTS], ids=[s[0] for s in SLOTS])
async def test_a_slot_that_is_none(asked: str, told: str) -> None:
    async with vienna() as place:
        calendar = place.gateway.rooms.organiser.calendar
        assert await place.say(f"/book {asked}") == told
        assert len(calendar) == 1, "nothing was booked"


async def test_a_time_after_the_right_to_it() -> None:
    async with vienna() as place:
        grants_book, vi = place.gateway.authority.grants_book, who(place, "Vi")
        ends_ns = place.clock.wall_ns() + 2 * 3_600 * 10**9
        grant = Grant(id="g1", scopes=("kuka1:*",), expires_ns=ends_ns)
        async with place.gateway.access.changes.turn() as turn:
            await turn.write(grants_book.give(vi, (grant,), "test"))
        calendar = place.gateway.rooms.organiser.calendar
        kept = len(calendar)

        told = await place.say("/book kuka1 tomorrow 14:00 1h", account=VI, chat=VI)
        assert "Your right to kuka1 ends" in told
        assert "before that time. Nothing was booked." in told
        told = await place.say("/book kuka1 every day 14:00 1h 3 times", account=VI, chat=VI)
        assert len(calendar) == kept, told
        told = await place.say("/book kuka1 now 3h", account=VI, chat=VI)
        assert "But your right to kuka1 ends" in told
        await place.clock.advance(1)
        cancel, under = place.button("Cancel it")
        await place.tap(cancel, under, account=VI)
        told = await place.say("/book kuka1 now 2h", account=VI, chat=VI)
        assert "is yours" in told
        assert "your right" not in told, "they mean the same two hours"


async def test_a_time_zone_that_is_none() -> None:
    async with vienna() as place:
        # Nothing that is said back is a command to tap: of a path, the sign before a name is not.
        for name, back in (
            ("Mars/Olympus", "Mars/Olympus"),
            ("CET+25", "CET+25"),
            ("../../etc/passwd", "../..\N{DIVISION SLASH}etc/passwd"),
        ):
            assert await place.say(f"/settings zone {name}") == (
                f'I know no time zone "{back}". Write it as Europe/Vienna or UTC.'
            )
        assert "Time zone: Europe/Vienna" in await place.say("/settings")


ROLES = [
    (
        "a role that includes itself",
        {"a": Role(includes=("a",))},
        "The role a includes itself: a includes a. Take one of these includes out.",
    ),
    (
        "two roles in a circle",
        {"a": Role(includes=("b",)), "b": Role(includes=("a",))},
        "The role a includes itself: a includes b includes a. Take one of these includes out.",
    ),
    (
        "a pattern that matches no robot",
        {"a": Role(scopes=("abb*:*",))},
        "No robot matches 'abb*'. Known here: cf1, cf2, kuka1, omni.",
    ),
    (
        "a pattern that matches no skill",
        {"a": Role(scopes=("*:fly*",))},
        (
            "No robot of '*' has a skill 'fly*'. "
            "Known here: ask, files, grant, help, look, move, places, read, resume, share, "
            "strategy, wave."
        ),
    ),
    (
        "a wildcard without a skill",
        {"a": Role(scopes=("*",))},
        "'*' is no right: write robot, colon and skill, for example omni:move.",
    ),
    (
        "a regular expression",
        {"a": Role(scopes=("(cf1|cf2):wave",))},
        "'(cf1|cf2):wave' is no right: write robot, colon and skill, for example omni:move.",
    ),
    (
        "capital letters",
        {"a": Role(scopes=("CF1:wave",))},
        "'CF1:wave' is no right: write robot, colon and skill, for example omni:move.",
    ),
]


async def test_no_wildcard_gives_the_right_to_give_rights() -> None:
    async with Place().open() as place:
        rights = place.gateway.rooms.organiser.rights
        all_of_it = (Grant(scopes=("*:*",)),)
        for scope in ("*:*", "omni:*", "*:gran?", "fl*:*", "*:gr*"):
            given = rights.with_grants(9, "x", (Grant(scopes=(scope,)),))
            held = [r for r in ("omni", "fleet") if given.holds("x", r, "grant", 0)]
            assert held == [], scope
        assert rights.with_grants(9, "x", all_of_it).holds("x", "omni", "wave", 0)


@pytest.mark.parametrize(("roles", "told"), [r[1:] for r in ROLES], ids=[r[0] for r in ROLES])
async def test_a_role_that_is_none_is_said_at_the_start_and_gives_nothing(
    roles: dict[str, Role], told: str
) -> None:
    """The command that starts a gateway refuses the file; whoever starts one anyway is safe."""
    book = RoleRules(roles={**DEFAULT_ROLES, **roles})
    place = Place()
    settings = place.gateway._settings
    people = tuple(replace(s, roles=("a",)) if s.name == "Bo" else s for s in settings.people)
    place.gateway._settings = replace(settings, rulebook=book, people=people)
    async with place.open():
        mistakes = rulebook_mistakes(
            book, place.gateway.rooms.organiser.rights.fleet, unit_converter(known_units())
        )
        assert told in [f"{m.sentence} {m.hint}".strip() for m in mistakes]
        answer = await place.say("cf1 wave", account=BO, chat=BO)
        assert place.acted("cf1") == 0
        assert answer, "they are told why"


async def test_a_container_erased_while_in_use() -> None:
    async with vienna() as place:
        robot = place.robot("omni")
        await place.clock.advance(4 * 3600)
        robot.work_s = 3600.0
        await place.say("/data plan = secret words", account=BO, chat=BO)
        await place.say("omni move 1 m", account=BO, chat=BO)
        assert robot.presence().doing == "move"
        await place.say("/forget me", account=BO, chat=BO)
        button, under = place.button("Forget me for good")
        said = await place.tap(button, under, account=BO)
        for _ in range(20):
            await place.clock.advance(1.0)
            await place.quiet()
        assert "stopped before it ended" in said
        told = [t.outbound.text for t in place.chat.told if t.outbound.chat.id == BO]
        assert told[-1] == "You are forgotten here. Farewell."
        assert robot.gate.latched
        assert robot.presence().at_rest
        robot.work_s = 0.0
        asked = ("omni move 1 m", "/mydata", "/data plan")
        heard = [await place.say(line, account=BO, chat=BO) for line in asked]
        assert heard == [STRANGERS, "", ""], "they are a stranger"
        assert place.acted() == 1
        await place.say("resume omni")
        await place.say("omni wave")
        assert place.acted() == 2, "the others go on"


async def test_a_full_disk_keeps_nobody_from_being_locked() -> None:
    store = BrokenStore()
    async with vienna(store) as place:
        robot = place.robot("kuka1")
        robot.work_s = 3600.0
        await place.say("kuka1 move 1 m", account=BO, chat=BO)
        assert robot.presence().doing == "move"
        store.broken = True
        told = await place.say("/lock Bo")
        assert (
            "Bo is locked: nothing they send is carried out until an admin unlocks them. I could "
            "not write this down: it holds until ROSIC is restarted. The operator has to look."
        ) in told
        assert robot.gate.latched
        assert robot.presence().at_rest
        assert await place.say("cf1 wave", account=BO, chat=BO) == (
            "Your access is locked. The admin of this place can unlock it. Stop still works."
        )
        assert place.acted("cf1") == 0
        assert await place.say("cf1 wave") == (
            "I cannot write down what is decided, so nothing may move. Stop still works. The "
            "operator has to look at the disk."
        )
        assert "STOP" in await place.say("stop cf1", account=BO, chat=BO)
        store.broken = False
        await place.say("/unlock Bo")
        await place.say("resume cf1")
        await place.say("cf1 wave", account=BO, chat=BO)
        assert place.acted("cf1") == 1, "it works again without a restart"


async def test_a_full_disk_lets_nobody_in_and_changes_no_time() -> None:
    store = BrokenStore()
    async with vienna(store) as place:
        store.broken = True
        sentence = "I cannot write this down now, so nothing was changed. The operator has to look."
        for asked in ("/book omni 16:00 1h", "/invite viewer omni for 2h", "/unlock Bo"):
            assert await place.say(asked) in (sentence, "Bo is not locked. Nothing was done.")
        assert len(place.gateway.rooms.organiser.calendar) == 1
        assert not place.gateway.access.enrolment.invitations.open()
        assert await place.say("omni wave", account=STRANGER, chat=STRANGER) == STRANGERS
