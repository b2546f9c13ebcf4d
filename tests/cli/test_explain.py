"""`rosic explain`: the decision, and every rule that made it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.app.config import load_config
from rosic.app.containers import preferences_of
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.gateway.access_registry import person_of
from rosic.stores.database import DatabaseStore
from rosic.system import SystemClock
from tests.cli.offline import MEMORY, Place

if TYPE_CHECKING:
    from pathlib import Path

OWN = """
[role.junior]
scopes = ["kuka1:*"]
limits = ["force <= 20 N"]
"""


@pytest.fixture
def place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Place:
    return Place(tmp_path, capsys, MEMORY.replace('"operator"', '"junior"') + OWN).begun()


def no(place: Place, *asked: str) -> str:
    """Return an explanation that comes to a no; the exit status says so."""
    said = place.rosic("explain", *asked)
    assert (said.status, said.err) == (1, "")
    return said.out


def test_it_completes_the_arguments_and_names_every_rule(place: Place) -> None:
    lines = place.good("explain", "Ada", "kuka1 grasp").splitlines()

    assert lines[:2] == ["KUKA iiwa: grasp, 15 N", "Ada may."]
    assert [line.split(":")[0].split() for line in lines[2:]] == [
        ["ok", rule]
        for rule in (
            "key",
            "lock",
            "sight",
            "reach",
            "right",
            "channel",
            "limits",
            "stopped",
            "slot",
            "lease",
            "care",
        )
    ]


def test_a_limit_refuses_by_name(place: Place) -> None:
    *_, last = no(place, "Bob", "kuka1 grasp force=30").splitlines()

    assert last == "no  limits:   force <= 20 N is broken (force is 30.0, in SI); Ada can help"
    assert "Bob may.\n" in place.good("explain", "Bob", "kuka1", "grasp", "20", "N")


def test_who_may_not_see_a_robot_is_told_that_there_is_none(place: Place) -> None:
    said = no(place, "Bob", "omni arm home")

    assert said.startswith("To Bob there is no such robot; they are told so.\n")
    assert "no  sight:" in said
    assert "Bob may not." in said


def test_the_robots_own_bounds_are_said_beside_the_rules(place: Place) -> None:
    said = no(place, "Ada", "kuka1 grasp 300 N")

    assert "40 N" in said
    assert "ok  right:" in said


def test_stop_and_resume_are_explained_too(place: Place) -> None:
    assert "Bob may." in place.good("explain", "Bob", "stop kuka1")
    assert "ok  right:" in place.good("explain", "Ada", "resume kuka1")


def test_whoever_is_locked_may_only_stop(place: Place) -> None:
    place.good("lock", "Bob")

    assert "no  lock:" in no(place, "Bob", "kuka1 home")
    assert "Bob may." in place.good("explain", "Bob", "stop")


@pytest.mark.parametrize(
    ("who", "line", "sentence"),
    [
        ("Zed", "kuka1 home", "Nobody is called Zed. There are: Ada, Bob."),
        ("Bob", "kuka1 graps", 'KUKA iiwa has no "graps". Did you mean grasp?'),
        ("Bob", "help", "That asks nothing of a robot, so no rule is asked."),
        ("Bob", "kuka1 home\nkuka1 home", "Ask about one line at a time."),
        ("Bob", "", "There was nothing to read."),
    ],
)
def test_what_cannot_be_explained_is_one_sentence(
    place: Place, who: str, line: str, sentence: str
) -> None:
    assert sentence in place.wrong("explain", who, line)


def test_ones_own_highest_speed_counts_as_in_a_chat(place: Place) -> None:
    place.good("invite", "--role", "viewer")  # takes over who is in the file
    assert "Ada may.\n" in place.good("explain", "Ada", "omni move 1 m speed=0.5")
    asyncio.run(sets_speed(load_config(place.config).data, "Ada", "0.2 m/s"))

    assert "omni:move speed <= 0.2 m/s is broken" in no(place, "Ada", "omni move 1 m speed=0.5")
    assert "Ada may.\n" in place.good("explain", "Ada", "omni move 1 m speed=0.1")


def test_a_default_above_ones_own_limit_is_lowered_as_in_a_chat(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = OWN.replace("kuka1:*", "omni:*").replace("force <= 20 N", "speed <= 0.2 m/s")
    place = Place(tmp_path, capsys, MEMORY.replace('"operator"', '"junior"') + own).begun()
    first, *rest = place.good("explain", "Bob", "omni fahre 0,2 m").splitlines()
    assert first == "omni: move, 0.20 m, 0.2 m/s forward"
    assert rest[:2] == ["Bob may.", "What the line leaves open is lowered to their own limits."]
    assert not any(line.startswith("no  ") for line in rest)

    assert "is broken" in no(place, "Bob", "omni fahre 0,2 m speed=0.25")
    assert "lowered" not in place.good("explain", "Bob", "omni move 0.2 m speed=0.1")
    assert "lowered" not in place.good("explain", "Ada", "omni move 0.2 m")


async def sets_speed(data: Path, name: str, speed: str) -> None:
    """Keep somebody's own highest speed on the record, as `/settings speed` does."""
    clock = SystemClock()
    store = DatabaseStore(data, clock=clock)
    memory = await store.open()
    [who] = [p.id for p in map(person_of, memory.enrolled) if p.name == name]
    omni = load_profile(shipped_profiles()["omni"])
    book = preferences_of((omni,), known_units(), clock, memory)
    await store.write(*book.set_speed(who, speed))
    await store.close()
