"""I1, I2, I7 and I8 where messages come twice, disks fail, clocks jump and gateways close."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.order import OrderEnding, Outcome, StageReport
from rosic.core.order_gate import OrderGate
from rosic.core.records import Claimed, Concluded, Told
from rosic.core.robot.profile import Profile
from rosic.core.robot.skill import Parameter
from rosic.errors import StoreFault
from rosic.robots.ros2.profile import Ros2Link, Ros2Skill, TopicBinding
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from rosic.testing.factories import OrderBook
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.robot import SimulatedRobot
from tests.gateway.place import Place, SlowStore, WritingStore

if TYPE_CHECKING:
    from rosic.core.message import Inbound
    from rosic.core.records import Record


# ---- I1: the same message, understood anew ----


async def test_a_message_that_comes_again_after_another_choice_moves_nobody_else() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        message = place.chat.say("wave")
        await place.quiet()
        await place.say("use swarm")
        place.chat.deliver(message)
        await place.quiet()
        assert (place.acted("omni"), place.acted("cf1"), place.acted("cf2")) == (1, 0, 0)


async def test_a_groups_message_that_comes_again_after_another_choice_moves_nobody_twice() -> None:
    async with Place().open() as place:
        await place.say("use swarm")
        message = place.chat.say("wave")
        await place.quiet()
        await place.say("use cf1")
        place.chat.deliver(message)
        await place.quiet()
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)


async def test_a_refused_message_that_comes_again_after_a_choice_stays_refused() -> None:
    async with Place().open() as place:
        message = place.chat.say("wave")
        await place.quiet()
        await place.say("use swarm")
        place.chat.deliver(message)
        await place.quiet()
        assert (place.acted("cf1"), place.acted("cf2")) == (0, 0)


async def test_an_older_choice_that_comes_again_is_not_made_again() -> None:
    async with Place().open() as place:
        older = place.chat.say("use omni")
        await place.quiet()
        await place.say("use kuka1")
        place.chat.deliver(older)
        await place.quiet()
        await place.say("wave")
        assert (place.acted("omni"), place.acted("kuka1")) == (0, 1)


# ---- I2: clocks ----


async def test_a_wall_clock_set_back_makes_no_old_message_fresh() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        receive = place.gateway.pipeline.receive
        first = place.chat._inbound("1", place.chat.say("status").chat, "a", None)
        lines = [
            asyncio.create_task(receive(place.chat, _with(first, text, number)))
            for number, text in enumerate(("omni wave", "kuka1 wave"))
        ]
        await place.clock.advance(60.0)
        place.clock.jump_wall(-120.0)
        store.ready.set()
        await place.quiet()
        await asyncio.gather(*lines)
        assert place.acted("kuka1") == 0, "it was a minute old when its turn came"


def _with(inbound: Inbound, text: str, number: int) -> Inbound:
    return replace(inbound, text=text, message=f"m{number}")


# ---- I7 and the order of effects ----


class FailsOnce(WritingStore):
    """One outcome cannot be written; everything else can, before and after."""

    def __init__(self) -> None:
        super().__init__()
        self.kinds: list[type] = []
        self._failing = True

    async def write(self, *records: Record) -> None:
        if self._failing and any(isinstance(record, Concluded) for record in records):
            self._failing = False
            raise StoreFault("the database is locked")
        await super().write(*records)
        self.kinds += map(type, records)

    def note(self, *records: Record) -> None:
        super().note(*records)
        self.kinds += map(type, records)


async def test_an_outcome_that_could_not_be_written_is_written_before_it_counts_as_told() -> None:
    store = FailsOnce()
    async with Place(store).open() as place:
        await place.say("omni move 1 m")
        await place.clock.advance(60.0)
        assert Concluded in store.kinds, "the record never learns how it ended"
        assert store.kinds.index(Concluded) < store.kinds.index(Told)


class HasAFault(MemoryStore):
    """Fails in a way that nobody foresaw, for one robot."""

    async def write(self, *records: Record) -> None:
        if any(isinstance(record, Claimed) and record.robot == "kuka1" for record in records):
            raise ZeroDivisionError
        await super().write(*records)


async def test_a_fault_in_a_later_line_does_not_deny_what_an_earlier_one_did() -> None:
    async with Place(HasAFault()).open() as place:
        told = await place.say("omni wave\nkuka1 wave")
        assert place.acted("omni") == 1
        assert "Nothing was done." not in told, told


async def test_what_never_began_did_not_end_when_the_gateway_closed() -> None:
    async with Place().open() as place:
        place.robot("kuka1").work_s = 1_000.0
        await place.say("kuka1 move 1 m")
        await place.say("kuka1 wave")
    assert place.acted("kuka1") == 1
    [waited] = [
        shown.text
        for message in {told.message for told in place.chat.told}
        if (shown := place.chat.shown(message)).text.startswith("kuka1: wave")
    ]
    assert "stopped before it ended" not in waited, waited


async def test_a_drive_that_the_machine_breaks_off_was_not_refused() -> None:
    clock = ManualClock()
    drive = Ros2Skill(
        id="drive",
        topic=TopicBinding(
            name="/omni/cmd_vel",
            type="geometry_msgs/msg/Twist",
            stream_hz=10.0,
            message={"linear.x": "$linear"},
        ),
        parameters={
            "linear": Parameter(unit="m/s", min=-1.0, max=1.0),
            "duration": Parameter(unit="s", min=0.1, max=30.0),
        },
    )
    profile = Profile(
        id="omni",
        link=Ros2Link(kind="simulated", model="omni"),
        watchdog_s=0.5,
        skills={"drive": drive},
    )
    robot = SimulatedRobot(profile, OrderGate.new("omni"), clock)
    await robot.open(lambda _said: None)
    machine = robot.machine
    assert isinstance(machine, Omni)
    machine._cell.fraction = 0.0501  # a moment before the battery is too low to drive
    order = OrderBook(profile, clock).order("drive", {"linear": 0.3, "duration": 20.0})
    driving = asyncio.create_task(robot.execute(order, _unheard))
    for _ in range(3_000):
        if driving.done():
            break
        await clock.advance(0.01)
    outcome: Outcome = await driving
    assert machine.base.x_m > 0.01
    assert outcome.ending is not OrderEnding.REFUSED, "it has moved"
    await robot.close()


def _unheard(_report: StageReport) -> None:
    """Nobody reads along."""


# ---- all of a group or none ----


async def test_a_group_of_which_one_is_busy_moves_nobody() -> None:
    async with Place().open() as place:
        place.robot("cf1").work_s = 1_000.0
        await place.say("cf1 wave")
        await place.say("swarm wave")
        assert place.acted("cf2") == 0


async def test_looking_at_a_stopped_robot_is_not_told_a_wrong_reason() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.clock.advance(60.0)
        told = await place.say("omni look")
        assert "before this could begin" not in told, "it was stopped a minute before"
