"""Nothing is said of rest or motion that was not measured (I7), whatever a robot's side sends."""

from __future__ import annotations

import asyncio
import signal
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.messages import rests, status_line
from rosic.core.order import OrderEnding, Outcome, Stop
from rosic.errors import RobotOffline, RobotUnreachable
from rosic.robots.ros2.profile import AtRest, StopBinding
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.ros2.base_profile import base_profile
from tests.real.ros2.simulated import opened, until

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument
    from rosic.testing.ros2.graph import RosGraph, RosProcess

NODE = Path(__file__).with_name("doubtful_node.py")
SLOWLY: dict[str, Argument] = {"linear": 0.2, "duration": 1.0}
LONG: dict[str, Argument] = {"linear": 0.2, "duration": 20.0}


@pytest.fixture
def base(graph: RosGraph) -> RosProcess:
    return graph.start(NODE)


def profile() -> Profile:
    return replace(base_profile(), rest_timeout_s=2.0)


async def told(base: RosProcess, line: str) -> int:
    """Tell the base something; return how many velocities it has had so far."""
    base.say(line)
    return int(await asyncio.to_thread(base.expect, "ok"))


# ---- a velocity and a place that contradict each other ----


async def test_a_twist_that_is_never_filled_confirms_no_stop_while_the_pose_changes(
    base: RosProcess,
) -> None:
    await told(base, "twist=zero zero=false stop=false by_hand=0.3")
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().doubt != "")
        assert robot.presence().doubt == "its velocity is zero while its position changes"
        rest = await robot.stop(Stop("base", 1))
        assert not rest.confirmed
        await told(base, "by_hand=0")
        await until(lambda: robot.presence().at_rest is True)


async def test_a_pose_that_is_never_filled_is_no_way_of_nothing(base: RosProcess) -> None:
    await told(base, "pose=fixed")
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        running = asyncio.create_task(robot.do("drive", LONG))
        await until(lambda: robot.presence().at_rest is False or running.done())
        await asyncio.sleep(1.0)  # it drives on meanwhile
        await told(base, "zero=false")
        await asyncio.to_thread(base.process.send_signal, signal.SIGSTOP)
        try:
            with pytest.raises(RobotUnreachable, match="s; how far was not measured"):
                await running
        finally:
            base.process.send_signal(signal.SIGCONT)


async def test_what_a_relay_repeats_is_no_new_reading(base: RosProcess) -> None:
    """It rested when that was said, and drives now."""
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        await told(base, "stamp=old")
        await told(base, "by_hand=0.3 zero=false stop=false")
        await until(lambda: robot.presence().doubt == "what is reported is old, or is repeated")
        assert robot.presence().at_rest is None
        rest = await robot.stop(Stop("base", 1))
        assert not rest.confirmed
        await told(base, "stamp=live")
        await until(lambda: robot.presence().moves)


# ---- what is measured too seldom ----


async def test_what_was_sent_is_said_though_it_was_not_measured(base: RosProcess) -> None:
    await told(base, "hz=0.7")
    slow = replace(profile(), rest_timeout_s=5.0)
    async with opened(slow, SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is None)
        await until(lambda: robot.presence().at_rest is True)
        outcome = await robot.do("drive", LONG)
    assert outcome.ending is OrderEnding.FAILED
    sent, _, ended = outcome.note.partition("; ")
    assert float(sent.removeprefix("sent velocities for ").removesuffix(" s")) > 0.5
    assert ended.startswith(
        ("broken off because its motion was not measured", "broken off because it was not heard")
    ), ended


# ---- a stop that says that it failed ----


async def test_what_its_own_stop_answers_is_logged_and_shown(
    base: RosProcess, caplog: pytest.LogCaptureFixture
) -> None:
    await told(base, "stop=false")
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        rest = await robot.stop(Stop("base", 1))
    assert rest.declined == "brake circuit open"
    said = "/base/stop answered that it failed: brake circuit open"
    assert caplog.text.count(said) == 1
    assert rests({"base": robot.profile}, [rest]).endswith(
        "Base's own stop answered that it failed: brake circuit open."
    )


async def test_of_a_stop_that_never_answers_is_said_so_though_zero_brought_it_to_rest(
    base: RosProcess,
) -> None:
    await told(base, "stop=hangs")
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        running = asyncio.create_task(robot.do("drive", LONG))
        await until(lambda: robot.presence().at_rest is False or running.done())
        rest = await robot.stop(Stop("base", 1))
        await running
        assert rest.confirmed
        assert rests({"base": robot.profile}, [rest]).endswith(
            " s). Base's own stop did not answer."
        )
        await told(base, "stop=true")
        await until(lambda: robot.presence().at_rest is True)
        again = await robot.stop(Stop("base", 2))
    assert not again.unanswered


async def test_of_a_stop_that_is_not_there_is_said_so(base: RosProcess) -> None:
    await told(base, "stop=true")
    mistyped = replace(profile(), stop=StopBinding(service="/base/halt", zero="/base/cmd_vel"))
    async with opened(mistyped, SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        rest = await robot.stop(Stop("base", 1))
    assert (rest.confirmed, rest.unanswered) == (True, True)


@pytest.mark.parametrize("own", ["", "/base/stop"])
async def test_a_drive_that_ends_late_names_its_own_stop_only_where_that_ended_it(
    base: RosProcess, own: str
) -> None:
    """Three zeros end a drive; those after them are sent once more when they did not."""
    await told(base, "zero=5 stop=hangs")
    stop = StopBinding(service=own, zero="/base/cmd_vel")
    async with opened(replace(profile(), stop=stop), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        outcome = await robot.do("drive", SLOWLY)
    assert outcome == Outcome(OrderEnding.FAILED, "it came to rest late, and not by its own stop")


# ---- more than one that reports it ----


@pytest.mark.usefixtures("base")
async def test_two_that_report_rest_measure_none(
    graph: RosGraph, caplog: pytest.LogCaptureFixture
) -> None:
    """Whichever rested first would speak for the other, which drives on."""
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        second = await asyncio.to_thread(
            graph.start, NODE, "second", "zero=false", "stop=false", "by_hand=0.2"
        )
        await until(lambda: robot.presence().doubt != "")
        assert robot.presence().at_rest is None
        assert status_line(
            robot.profile, robot.presence(), holder="", stopped_by=None, waiting=0
        ).startswith(
            "Base: whether it rests is not measured: more than one program reports it · free"
        )
        rest = await robot.stop(Stop("base", 1))
        assert not rest.confirmed
        await robot.resume(1)
        with pytest.raises(RobotOffline, match="whether it rests cannot be measured now"):
            await robot.do("drive", SLOWLY)
        await until(lambda: "more than one program reports it" in caplog.text)
        await asyncio.to_thread(second.kill)
        await until(lambda: robot.presence().at_rest is True)


# ---- numbers that are missing, or are none ----


def by_joints() -> Profile:
    rest = AtRest(
        topic="/base/joints", type="sensor_msgs/msg/JointState", field="velocity", below=0.005
    )
    return replace(profile(), at_rest=rest)


async def test_joints_without_velocities_are_neither_rest_nor_motion(base: RosProcess) -> None:
    await told(base, "joints=empty")
    async with opened(by_joints(), SystemClock()) as robot:
        await until(lambda: robot.presence().online is True)
        assert robot.presence().at_rest is None
        assert not robot.presence().moves
        with pytest.raises(RobotOffline, match="whether it rests cannot be measured now"):
            await robot.do("drive", SLOWLY)
        assert await told(base, "velocities") == 0, "nothing was sent"
        await told(base, "joints=full")
        await until(lambda: robot.presence().at_rest is True)
        assert (await robot.do("drive", SLOWLY)).ending is OrderEnding.DONE


async def test_a_velocity_that_is_no_number_is_neither_rest_nor_motion(base: RosProcess) -> None:
    async with opened(profile(), SystemClock()) as robot:
        await told(base, "twist=nan")
        await until(lambda: robot.presence().at_rest is None)
        with pytest.raises(RobotOffline, match="whether it rests cannot be measured now"):
            await robot.do("drive", SLOWLY)
        assert await told(base, "velocities") == 0, "nothing was sent"
        rest = await robot.stop(Stop("base", 1))
        assert not rest.confirmed
        assert not robot.presence().moves


@pytest.mark.limit(240)
async def test_nothing_new_moves_what_did_not_come_to_rest_after_a_break(base: RosProcess) -> None:
    """It is told to stop three times; then it is let be, but for as long as it moves it is so."""
    lands = profile()
    skills = {**lands.skills, "land": replace(lands.skills["drive"], id="land", to_safety=True)}
    async with opened(replace(lands, skills=skills), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        running = asyncio.create_task(robot.do("drive", LONG))
        await until(lambda: robot.presence().at_rest is False or running.done())
        await told(base, "twist=nan zero=false stop=false by_hand=0.3")
        with pytest.raises(RobotUnreachable, match="whether it rests could not be measured"):
            await running
        await told(base, "twist=true")
        before = await told(base, "velocities")
        refused = ""
        async with asyncio.timeout(60 * pace()):
            while "Base still moves, though it was told to stop" not in refused:
                with pytest.raises(RobotOffline) as why:
                    await robot.do("drive", SLOWLY)
                refused = str(why.value)
        assert "Nothing was sent. Use its own stop button." in refused
        assert await told(base, "velocities") == before
        with suppress(RobotUnreachable):
            await robot.do("land", SLOWLY)
        assert await told(base, "velocities") > before, "a drone may always land"

        await told(base, "zero=true stop=true by_hand=0")
        await until(lambda: robot.presence().at_rest is True and robot._settling._task is None)
        assert (await robot.do("drive", SLOWLY)).ending is OrderEnding.DONE


async def test_a_battery_that_is_no_number_does_not_vanish_without_a_word(
    base: RosProcess,
) -> None:
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: "battery" in robot.presence().values)
        await told(base, "battery=nan")
        await until(lambda: robot.presence().no_number == ("battery",))
        presence = robot.presence()
        assert "battery" not in presence.values
        assert status_line(robot.profile, presence, holder="", stopped_by=None, waiting=0).endswith(
            " · battery not known, as the robot gives no number"
        )
        await told(base, "battery=0.5")
        await until(lambda: robot.presence().no_number == () and bool(robot.presence().values))


async def test_a_drive_is_broken_off_once_its_motion_is_not_measured(base: RosProcess) -> None:
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is True)
        running = asyncio.create_task(robot.do("drive", LONG))
        await until(lambda: robot.presence().at_rest is False or running.done())
        await told(base, "twist=nan")
        with pytest.raises(RobotUnreachable, match="whether it rests could not be measured") as why:
            await running
        assert "broken off because its motion was not measured for 1." in str(why.value)
