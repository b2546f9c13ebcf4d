"""A robot that is not as expected: late on its way, off at its end; who hears, what is done."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.fleet.task import TaskState
from rosic.core.robot.alert_config import AlertConfig, RecipientCircle
from rosic.core.robot.benchmark import Benchmark, ErrorBound
from rosic.core.robot.profile import Profile, Telemetry
from rosic.core.robot.skill import Parameter, SkillClass
from rosic.core.robot.view import Pose
from rosic.features.alerts import AlertFeature
from rosic.robots.ros2.profile import ParametersBinding, PoseSource, Ros2Skill, ServiceBinding
from rosic.stores.memory import MemoryStore
from tests.features.alerts.test_alerts import heard
from tests.features.fleet.test_tasks import WAREHOUSE, tasks, warehouse
from tests.gateway.place import ADA, BO, FLEET, MOVE, WAVE, Place

if TYPE_CHECKING:
    from rosic.testing.clock import ManualClock

TUNE = Ros2Skill(
    id="tune",
    title="Tune",
    kind=SkillClass.CONFIG,
    parameters={"gain": Parameter(min=0, max=10)},
    set_parameters=ParametersBinding(node="/omni/base", values={"gain": "$gain", "mode": "slow"}),
)
CALIBRATE = Ros2Skill(
    id="calibrate",
    kind=SkillClass.CONFIG,
    service=ServiceBinding(name="/omni/calibrate", type="std_srvs/srv/Trigger"),
)
BENCH = Benchmark(
    duration_s=2.0,
    per_s={"distance": 4.0},
    energy=1.0,
    errors={"place": ErrorBound(measured="pose.x", wanted="$distance", within=0.1)},
)


def robot(*alerts: AlertConfig) -> Profile:
    skills = {
        "move": replace(MOVE, benchmark=BENCH),
        "wave": WAVE,
        "tune": TUNE,
        "calibrate": CALIBRATE,
    }
    return replace(
        FLEET[0],
        skills=skills,
        telemetry={"battery": Telemetry(unit="%")},
        alerts=alerts,
        pose=PoseSource(topic="/omni/pose"),
    )


def place(
    *alerts: AlertConfig, store: MemoryStore | None = None, clock: ManualClock | None = None
) -> Place:
    return Place(store, clock=clock, fleet=(robot(*alerts), *FLEET[1:]))


async def begin(here: Place, said: str = "omni move forward 1 m", account: str = ADA) -> None:
    omni = here.robot("omni")
    omni.values.setdefault("battery", 80.0)
    omni.pose = omni.pose or Pose(1.0, 0.0, yaw_rad=0.0)
    omni.work_s = 1e6
    await here.say(said, account=account, chat=account)


async def done(here: Place) -> dict[str, list[str]]:
    here.robot("omni").finish()
    return await heard(here, 3)


async def test_what_is_as_expected_tells_nobody_and_is_kept_to_be_asked_for() -> None:
    async with place().open() as here:
        await begin(here)
        await heard(here, 5)
        told = await done(here)
        assert not any("benchmark" in text for texts in told.values() for text in texts)
        assert await here.say("/benchmark omni") == (
            "omni, against what is expected of it:\nMove: took 5.0 s, expected 6.0 s · as expected"
        )


async def test_a_task_that_is_late_is_told_while_it_is_under_way() -> None:
    async with place().open() as here:
        await begin(here)
        assert await heard(here, 8.5) == {}
        told = await heard(here, 3)
        assert told[ADA] == ["omni: Off its benchmark.\nNow: it takes too long."]
        assert BO not in told, "first whoever has the robot"
        await done(here)
        assert "took 11.5 s, expected 6.0 s · 11.5 s instead of 9.0 s" in await here.say(
            "/benchmark omni"
        )
        await begin(here)
        told = await done(here)
        assert any("over: Off its benchmark" in text for text in told[ADA])


async def test_energy_and_error_are_judged_at_the_end() -> None:
    async with place().open() as here:
        await begin(here)
        here.robot("omni").values["battery"] = 77.5
        here.robot("omni").pose = Pose(0.7, 0.0, yaw_rad=0.0)
        told = await done(here)
        assert any("Now: it took more of the battery than expected" in text for text in told[ADA])
        assert "2.5 % of the battery instead of 1.0 % · place off by 0.3, at most 0.1" in (
            await here.say("/benchmark omni")
        )


async def test_what_was_cut_short_is_not_judged() -> None:
    async with place().open() as here:
        await begin(here)
        here.robot("omni").values["battery"] = 10.0
        await here.say("stop omni")
        await heard(here, 3)
        assert "not measured yet" in await here.say("/benchmark omni")


async def test_a_rule_recalibrates_and_then_nothing_deviates() -> None:
    rule = AlertConfig(
        name="off",
        when="deviation is error",
        lasting="1 s",
        run="tune 2",
        author="Ada",
        tell=RecipientCircle.ADMINS,
    )
    store = MemoryStore()
    async with place(rule, store=store).open() as here:
        await begin(here)
        here.robot("omni").pose = Pose(0.0, 0.0, yaw_rad=0.0)
        here.robot("omni").finish()
        here.robot("omni").work_s = 0.0
        told = await heard(here, 6)
        assert here.acted() == 2
        assert any("omni: over: Off" in text for text in told[ADA])
        assert "Set from here:\n/omni/base:gain = 2, by Ada 12:00:00" in await here.say(
            "/benchmark omni"
        )
    async with place(rule, store=store, clock=here.clock).open() as here:
        answer = await here.say("/benchmark omni")
        assert "/omni/base:gain = 2, by Ada" in answer, "kept over a restart"
        await here.say("omni tune 3")
        answer = await here.say("/benchmark omni")
        assert "/omni/base:gain = 3" in answer
        assert "/omni/base:mode = slow" in answer
        await here.say("omni calibrate")
        answer = await here.say("/benchmark omni")
        assert "calibrate = True" in answer
        assert "/omni/base:gain = 3" in answer, "merged with what was set before"


async def test_a_rule_pauses_without_latching_anything() -> None:
    rule = AlertConfig(
        name="late", when="deviation is late", lasting="1 s", run="pause", author="Ada"
    )
    async with place(rule).open() as here:
        await begin(here, account=BO)
        told = await heard(here, 13)
        assert any("omni was paused by the rule late." in text for text in told[BO])
        assert here.robot("omni").presence().at_rest
        here.robot("omni").work_s = 0.0
        assert "done" in await here.say("omni wave", account=BO, chat=BO)


@dataclass
class Tasks:
    """Keeps tasks as a fleet would."""

    asked: list[tuple[str, str]] = field(default_factory=list)

    async def pause(self, robot: str, _by: str, _why: str) -> bool:
        self.asked.append(("pause", robot))
        return True

    async def reallocate(self, robot: str, _by: str, _why: str) -> None:
        self.asked.append(("reallocate", robot))


async def test_a_rule_reallocates_where_there_are_tasks_and_says_so_where_there_are_none() -> None:
    rule = AlertConfig(
        name="late",
        when="deviates",
        lasting="1 s",
        run="reallocate",
        author="Ada",
        tell=RecipientCircle.ADMINS,
    )
    async with place(rule).open() as here:
        await begin(here)
        told = await heard(here, 13)
        assert any("omni has no task that another robot could take." in t for t in told[ADA])
    async with place(rule).open() as here:
        running, tasks = here.gateway.features.get(AlertFeature).alerting._running, Tasks()
        assert running is not None
        running._tasks = tasks
        await begin(here)
        told = await heard(here, 13)
        assert tasks.asked == [("reallocate", "omni")]
        assert any("The rule late gave the task of omni to another." in t for t in told[ADA])


async def test_a_fleet_moves_a_late_task_to_another_robot_or_pauses_it() -> None:
    for run, state in (("reallocate", TaskState.RUNNING), ("pause", TaskState.PAUSED)):
        rule = AlertConfig(name="late", when="deviates", lasting="1 s", run=run, author="Ada")
        slow = replace(WAVE, benchmark=Benchmark(duration_s=2.0))
        first, second, third = WAREHOUSE
        benched = replace(first, skills={**first.skills, "wave": slow}, alerts=(rule,))
        async with warehouse(fleet=(benched, second, third)).open() as here:
            await here.say("/task warehouse wave")
            assert tasks(here)["1"].robot == "w1"
            await heard(here, 8)
            task = tasks(here)["1"]
            assert task.state is state
            assert task.robot != "w1"
            assert here.robot("w1").presence().at_rest


async def test_a_card_says_what_is_expected_and_what_is_not_as_expected() -> None:
    async with place().open() as here:
        await here.say("/card omni")
        await begin(here)
        await heard(here, 4)
        assert "expected to take 6.0 s" in card(here)
        await heard(here, 8)
        assert "late: expected to take 6.0 s" in card(here)
        await done(here)
        await heard(here, 5)
        assert "Move was off its benchmark: 12.0 s instead of 9.0 s" in card(here)


def card(here: Place) -> str:
    shown = [here.chat.shown(told.message).text for told in here.chat.told]
    return next(text for text in reversed(shown) if "updated" in text)
