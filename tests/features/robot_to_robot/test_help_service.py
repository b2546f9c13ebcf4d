"""A robot is stuck: another robot or a person helps it, one of them, and people are told."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.core.fleet.task import TaskState
from rosic.core.records import Decided
from rosic.features.fleet import FleetFeature
from rosic.stores.memory import MemoryStore
from tests.features.fleet.test_tasks import Worker
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import ADA, BO, VI, BrokenStore, SlowStore, profile


class TwoTasks:
    """Keeps tasks, and writes down what it is asked to adjust."""

    def __init__(self, *, breaks: bool = False) -> None:
        self.adjusted: list[tuple[str, str]] = []
        self._breaks = breaks

    async def helped(self, helper: str, asker: str) -> str:
        self.adjusted.append((helper, asker))
        if self._breaks:
            raise ZeroDivisionError
        return f"{helper} leaves its task; that of {asker} waits."


async def asked(here: PeerRobots, what: str = "stuck at aisle 4", **how: object) -> str:
    answer = await here.says("omni", "help", what=what, **how)
    assert answer["ok"], answer
    return str(answer["id"])


async def told_to(here: PeerRobots, account: str, since: int) -> list[str]:
    await here.quiet()
    told = list(here.chat.told)[since:]
    return [t.outbound.text for t in told if t.outbound.chat.id == account]


async def test_another_robot_accepts_both_tasks_are_adjusted_and_operators_told() -> None:
    async with PeerRobots().open() as here:
        tasks = here.keep_tasks(TwoTasks())
        before = len(here.chat.told)
        ident = await asked(here)
        [request] = here.heard("cf1", "help")
        assert (request["id"], request["from"]) == (ident, "omni")
        assert request["what"] == "stuck at aisle 4"
        assert here.heard("cf2") == [], "it may not help omni, so it does not hear of it"
        assert (await told_to(here, BO, before))[0].startswith(
            "omni asks for help: stuck at aisle 4. It can be accepted until "
        )
        assert await told_to(here, VI, before) == [], "whoever only reads helps nobody"
        before = len(here.chat.told)
        accepted = await here.says("cf1", "accept", id=ident)
        assert accepted["ok"] is True
        assert tasks.adjusted == [("cf1", "omni")]
        for account in (ADA, BO):
            assert await told_to(here, account, before) == [
                "cf1 helps omni (stuck at aisle 4).\ncf1 leaves its task; that of omni waits."
            ]
        assert here.heard("omni", "helped") == [{"kind": "helped", "id": ident, "by": "cf1"}]


async def test_the_same_help_is_accepted_once_whoever_comes_together() -> None:
    async with PeerRobots().open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        here.speaks("cf1", "accept", id=ident, ref="r")
        here.chat.say(f"/assist {ident}", account=BO, chat=BO)
        here.chat.say(f"/assist {ident} kuka1", account=ADA, chat=ADA)
        await here.clock.advance(0.1)
        await here.quiet()
        assert len(tasks.adjusted) <= 1
        told = "\n".join(t.outbound.text for t in here.chat.told)
        answers = [a["ok"] for a in here.heard("cf1", "result")]
        refused = told.count("That was accepted already, by ") + answers.count(False)
        assert refused == 2
        before = len(tasks.adjusted)
        again = await here.says("cf1", "accept", id=ident)
        assert (again["ok"], again["code"]) == (False, "expired")
        assert "accepted already, by" in again["why"]
        assert len(tasks.adjusted) == before


async def test_while_the_disk_takes_its_time_nobody_else_gets_in_between() -> None:
    store = SlowStore(Decided)
    store.ready.set()
    async with PeerRobots(store).open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        store.ready.clear()
        here.speaks("cf1", "accept", id=ident)
        here.chat.say(f"/assist {ident} kuka1", account=ADA, chat=ADA)
        here.chat.say(f"/assist {ident} cf2", account=BO, chat=BO)
        await here.clock.advance(1)
        assert tasks.adjusted == []
        assert here.messaging.circle.helping.book.find(ident).open, "not before it is on disk"
        store.ready.set()
        await here.clock.advance(1)
        assert len(tasks.adjusted) == 1


async def test_a_person_helps_by_a_button_or_sends_a_robot_that_is_free() -> None:
    async with PeerRobots().open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        button, under = here.button("Send cf1")
        account = next(t.outbound.chat.id for t in reversed(here.chat.told) if t.message == under)
        told = await here.tap(button, under, account)
        name = "Ada" if account == ADA else "Bo"
        assert f"cf1 helps omni (stuck at aisle 4), sent by {name}." in told
        assert tasks.adjusted == [("cf1", "omni")]
        assert here.heard("cf1", "assigned")[0]["to"] == "omni"
        other = BO if account == ADA else ADA
        button, under = here.button("I help")
        told = await here.tap(button, under, other)
        assert f"That was accepted already, by {name}. Nothing was changed." in told
        assert "omni needs no more help" in await here.say(
            f"/assist {ident} done", account=other, chat=other
        )


async def test_who_may_not_help_does_not() -> None:
    async with PeerRobots().open() as here:
        ident = await asked(here)
        assert "I know no robot" in (await here.says("cf2", "accept", id=ident))["why"]
        told = await here.say(f"/assist {ident}", account=VI, chat=VI)
        assert told.startswith("Help needs the right")
        assert (await here.says("omni", "accept", id=ident))["why"] == (
            "A robot cannot help itself. Nothing was changed."
        )
        assert here.messaging.circle.helping.book.find(ident).open


async def test_nobody_accepts_it_too_late_and_that_is_said_once() -> None:
    async with PeerRobots().open() as here:
        ident = await asked(here, for_s=60)
        before = len(here.chat.told)
        await here.clock.advance(70)
        told = await told_to(here, BO, before)  # the request too, as its buttons go
        assert told[-1] == "Nobody has accepted to help omni (stuck at aisle 4). Please look."
        assert (await here.says("cf1", "accept", id=ident))["why"].startswith(
            "That request is over"
        )
        before = len(here.chat.told)
        await here.clock.advance(70)
        assert await told_to(here, BO, before) == []


async def test_asking_the_same_again_is_no_second_request_and_three_are_enough() -> None:
    async with PeerRobots().open() as here:
        first = await asked(here)
        assert await asked(here) == first
        await asked(here, "the door is shut")
        await asked(here, "no light")
        refused = await here.says("omni", "help", what="a fourth")
        assert (refused["ok"], refused["code"]) == (False, "too-many-requests")
        assert len(here.heard("cf1", "help")) == 3


async def test_a_robot_does_not_call_people_together_all_the_time() -> None:
    async with PeerRobots().open() as here:
        refused = []
        for number in range(20):
            answer = await here.says("omni", "help", what=f"wolf {number}")
            if answer["ok"]:
                await here.says("omni", "over", id=answer["id"])
            else:
                refused.append(answer["why"])
            await here.clock.advance(0.2)
        assert len(refused) >= 13
        assert set(refused) == {"You ask for help too often; wait a minute."}


async def test_a_robot_is_not_told_the_names_of_people() -> None:
    async with PeerRobots().open() as here:
        ident = await asked(here)
        await here.say(f"/assist {ident}", account=BO, chat=BO)
        refused = await here.says("cf1", "accept", id=ident)
        assert refused["why"] == "That was accepted already, by a person. Nothing was changed."
        assert here.heard("omni", "helped")[-1]["by"] == "a person"


async def test_what_was_accepted_stays_so_over_a_restart() -> None:
    store = MemoryStore()
    async with PeerRobots(store).open() as here:
        first, second = await asked(here), await asked(here, "no light")
        assert (await here.says("cf1", "accept", id=first))["ok"]
    async with PeerRobots(store).open() as here:
        again = await here.says("cf1", "accept", id=first)
        assert "accepted already, by cf1" in again["why"]
        assert (await here.says("cf1", "accept", id=second))["ok"] is True
        listed = await here.say("/assist", account=BO, chat=BO)
        assert "omni is helped by cf1: no light" in listed


async def test_what_cannot_be_written_is_not_accepted() -> None:
    store = BrokenStore()
    async with PeerRobots(store).open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        store.broken = True
        refused = await here.says("cf1", "accept", id=ident)
        assert refused["code"] == "record-unavailable"
        assert tasks.adjusted == []
        store.broken = False
        assert (await here.says("cf1", "accept", id=ident))["ok"] is True


async def test_tasks_that_cannot_be_adjusted_are_said_and_the_help_stands() -> None:
    async with PeerRobots().open() as here:
        here.keep_tasks(TwoTasks(breaks=True))
        ident = await asked(here)
        before = len(here.chat.told)
        await here.says("cf1", "accept", id=ident)
        [text] = await told_to(here, BO, before)
        assert text.endswith("Their tasks could not be adjusted; please look at both.")
        here.keep_tasks(None)
        second = await asked(here, "no light")
        before = len(here.chat.told)
        await here.says("cf1", "accept", id=second)
        assert (await told_to(here, BO, before))[0].endswith("No tasks were changed.")


class Warehouse(PeerRobots):
    """Its robots work until they are told how it ended."""

    kind = Worker


async def test_the_tasks_of_both_go_on_with_others_and_neither_gets_one_meanwhile() -> None:
    fleet = tuple(profile(name, groups=("crew",)) for name in ("omni", "cf1", "cf2"))
    async with Warehouse(fleet=fleet).open() as here:
        tasks = here.gateway.features.get(FleetFeature).dispatching.fleet.tasks
        for robot in ("omni", "cf1"):
            await here.say(f"/task {robot} wave", account=ADA, chat=ADA)
        await here.say("/task crew move 1 m", account=ADA, chat=ADA)
        await here.clock.advance(2)
        assert {t.robot for t in tasks.values()} == {"omni", "cf1", "cf2"}
        ident = await asked(here)
        accepted = await here.says("cf1", "accept", id=ident)
        assert accepted["text"] == (
            "cf1 helps omni (stuck at aisle 4).\n"
            "Task 1 leaves omni and waits for a robot.\nTask 2 leaves cf1 and waits for a robot."
        )
        await here.clock.advance(10)
        assert {t.id: (t.state, t.robot) for t in tasks.values()} == {
            "1": (TaskState.QUEUED, ""),
            "2": (TaskState.QUEUED, ""),
            "3": (TaskState.RUNNING, "cf2"),
        }, "only they can, and they have no time"
        before = here.acted("omni"), here.acted("cf1")
        await here.says("omni", "over", id=ident)
        await here.clock.advance(5)
        assert {t.robot for t in tasks.values()} == {"omni", "cf1", "cf2"}
        assert (here.acted("omni"), here.acted("cf1")) == (before[0] + 1, before[1] + 1)


async def test_whoever_helps_takes_over_what_the_other_did() -> None:
    fleet = tuple(profile(name, groups=("crew",)) for name in ("omni", "cf1", "cf2"))
    async with Warehouse(fleet=fleet).open() as here:
        tasks = here.gateway.features.get(FleetFeature).dispatching.fleet.tasks
        for _ in fleet:
            await here.say("/task crew wave", account=ADA, chat=ADA)
        await here.clock.advance(2)
        by = {task.robot: task.id for task in tasks.values()}
        assert set(by) == {"omni", "cf1", "cf2"}
        ident = await asked(here)
        accepted = await here.says("cf1", "accept", id=ident)
        assert f"Task {by['omni']} goes from omni to cf1." in accepted["text"]
        assert f"Task {by['cf1']} leaves cf1 and waits for a robot." in accepted["text"]
        await here.clock.advance(5)
        assert tasks[by["omni"]].robot == "cf1"
        assert tasks[by["cf1"]].state is TaskState.QUEUED, "whoever is helped has no time either"


async def test_a_task_waits_for_whoever_helps_no_longer_than_the_help_lasts() -> None:
    fleet = tuple(profile(name, groups=("crew",)) for name in ("omni", "cf1", "cf2"))
    async with Warehouse(fleet=fleet).open() as here:
        tasks = here.gateway.features.get(FleetFeature).dispatching.fleet.tasks
        await here.say("stop cf1 cf2", account=ADA, chat=ADA)
        await here.say("/task crew wave", account=ADA, chat=ADA)
        await here.clock.advance(2)
        assert tasks["1"].robot == "omni"
        ident = await asked(here)
        await here.says("cf1", "accept", id=ident)
        await here.clock.advance(5)
        assert tasks["1"].state is TaskState.QUEUED, "whoever helps is stopped"
        await here.says("omni", "over", id=ident)
        await here.clock.advance(5)
        assert tasks["1"].robot == "omni"


async def test_help_that_was_accepted_long_ago_or_unheard_takes_no_robot_off_its_task() -> None:
    async with PeerRobots().open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        old_ns = here.clock.wall_ns() - 60 * 1_000_000_000
        told = await here.say(f"/assist {ident} cf1", account=BO, chat=BO, sent_ns=old_ns)
        assert "Your command is 60 seconds old: it reached me late" in told
        assert tasks.adjusted == []
        await here.say(f"/assist {ident} cf1", account=BO, chat=BO, message="now")
        assert tasks.adjusted == [("cf1", "omni")]


async def test_a_robot_is_called_as_people_read_it() -> None:
    fleet = (profile("omni"), replace(profile("rover2"), title="Rover 2"))
    async with PeerRobots(fleet=fleet).open() as here:
        tasks = here.keep_tasks(TwoTasks())
        ident = await asked(here)
        assert "Rover 2 shares nothing now." in await here.say("/shared Rover 2")
        assert "read here what Rover 2 shares on road" in await here.say(
            "/shared rover 2 road follow"
        )
        assert "Rover 2 has no strategies." in await here.say("/strategy Rover 2")
        assert "Rover 2 is silenced" in await here.say("/quiet Rover 2 5 min")
        await here.say(f"/assist {ident} Rover 2", account=BO, chat=BO)
        assert tasks.adjusted == [("rover2", "omni")]


async def test_no_task_waits_for_one_that_helps_and_takes_no_part() -> None:
    fleet = tuple(profile(name, groups=("crew",)) for name in ("omni", "cf1", "cf2"))
    async with Warehouse(fleet=fleet).open() as here:
        tasks = here.gateway.features.get(FleetFeature).dispatching.fleet.tasks
        await here.say("/task crew wave", account=ADA, chat=ADA)
        await here.say("/robot retire cf1", account=ADA, chat=ADA)
        await here.clock.advance(2)
        assert tasks["1"].robot == "omni"
        before = len(here.chat.told)
        ident = await asked(here)
        offered = {
            button.label
            for t in list(here.chat.told)[before:]
            for row in t.outbound.buttons
            for button in row
        }
        assert offered == {"I help", "Send cf2"}
        accepted = await here.says("cf1", "accept", id=ident)
        assert "Task 1 leaves omni and waits for a robot." in accepted["text"]
        await here.clock.advance(5)
        assert tasks["1"].robot == "cf2"
