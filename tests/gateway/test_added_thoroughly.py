"""What hears of a robot besides the rooms: what was remembered, limits, samples, other robots."""

from __future__ import annotations

import json

from msgspec.structs import replace

from rosic.core.rate_limit import RateLimit
from rosic.core.robot.benchmark import DEVIATION
from rosic.features.benchmarks import BenchmarkFeature
from rosic.features.media import MediaFeature
from tests.gateway.place import ADA, BO, Place
from tests.gateway.rover import ROVER, add, draft

SPEED = "      speed: { unit: m/s, min: 0.05, max: 1, default: 0.5 }\n"
TIMES = "      times: { min: 1, max: 9, integer: true, default: 3 }\n"


async def test_a_word_that_was_taken_for_a_stop_is_a_name_now() -> None:
    async with Place().open() as place:
        assert "STOP" in await place.say("stob")
        for robot in ("omni", "kuka1", "cf1", "cf2"):
            await place.say(f"resume {robot}")
        await add(place, draft(rover="stob"))
        assert "STOP" not in await place.say("stob")
        assert "done" in await place.say("stob wiggle")


async def test_the_limit_of_every_robot_holds_for_it() -> None:
    place = Place()
    limit = RateLimit(burst=1.0, per_s=0.01)
    place.gateway._settings = replace(place.gateway._settings, robot_limit=limit)
    store = place.store
    async with place.open():
        await add(place)
        assert "done" in await place.say("rover wiggle")
        assert "Rover 3" in await place.say("rover wiggle")
        assert place.acted("rover") == 1
    after = Place(store, clock=place.clock)
    after.gateway._settings = replace(after.gateway._settings, robot_limit=limit)
    async with after.open():
        await after.say("rover wiggle")
        assert after.acted("rover") == 0


async def test_the_speed_that_somebody_has_set_holds_for_it() -> None:
    async with Place(fleet=()).open() as place:
        await add(place, draft(**{TIMES: SPEED}))
        assert "0.2 m/s" in await place.say("/settings speed 0.2 m/s", account=BO)
        other = ROVER.replace("rover", "other").replace("Rover 3", "Other").replace("buggy", "bug")
        await add(place, draft(other, **{TIMES: SPEED}))
        for robot in ("rover", "other"):
            said = await place.say(f"{robot} wiggle 0.4 m/s", account=BO)
            assert "0.2 m/s" in said
            assert place.acted(robot) == 0
        assert "done" in await place.say("other wiggle 0.4 m/s", account=ADA)


async def test_what_it_reports_is_sampled_though_nobody_did() -> None:
    async with Place().open() as place:
        await add(place)
        place.robot("rover").values["battery"] = 70.0
        for _ in range(6):
            await place.clock.advance(0.5)
        now_s = place.clock.monotonic_ns() / 1e9
        assert place.gateway.features.get(MediaFeature).sampler.samples.points(
            "rover", "battery", now_s
        )


async def test_it_is_held_against_its_benchmarks_though_nobody_was() -> None:
    benchmark = "    benchmark: { duration_s: 4 }\n"
    async with Place().open() as place:
        await add(place, draft(**{TIMES: TIMES + benchmark}))
        assert "done" in await place.say("rover wiggle")
        assert "Wiggle" in await place.say("/benchmark rover")
        evaluation = place.gateway.features.get(BenchmarkFeature).evaluation
        assert "wiggle" in evaluation.verdicts["rover"]
        seen = place.gateway.kernel.assessment.presence("rover", place.robot("rover").presence())
        assert DEVIATION in seen.values


async def test_it_takes_part_among_robots() -> None:
    async with Place().open() as place:
        await add(place)
        words = {"kind": "share", "topic": "map", "value": {"x": 1}, "id": "1"}
        place.robot("rover").speak(json.dumps(words).encode(), 0)
        for _ in range(5):
            await place.clock.advance(0.5)
        assert place.robot("rover").heard
