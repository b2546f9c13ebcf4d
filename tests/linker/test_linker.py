"""What the linker does with stops, resumes, and orders that wait; and what is kept of them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, ClassVar, cast

import pytest
from msgspec.structs import replace

from rosic.contracts.live_control import LiveControls
from rosic.core.order import OrderEnding
from rosic.core.order_gate import OrderGate
from rosic.core.robot.file_transfer import FileForRobot
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Skill
from rosic.core.robot.view import ViewKind
from rosic.core.sample_gate import SampleGate
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import NothingToSee, OrderVoid, RobotOffline, RobotUnreachable, StoreFault
from rosic.linker.linker import KEPT_WITHIN_S, Linker, PolicyMoved
from rosic.linker.robot_queue import execute_live
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import FileLatch, MemoryLatch
from rosic.testing.clock import ManualClock, settle
from rosic.testing.factories import OrderBook
from tests.linker.policy import Policy
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.robot import Robot
    from rosic.contracts.store import StopLatch
    from rosic.core.order import Order, StageReport

PROFILE = Profile(id="omni", link=Link(kind="memory"), skills={"move": Skill(id="move")})


def ignore(_report: StageReport) -> None:
    """The reports do not matter here."""


class Entry:
    """An order that waits, and why it does no more."""

    def __init__(self, order: Order, happened: list[str]) -> None:
        self.order = order
        self.voided = ""
        self._happened = happened

    def tell(self, report: StageReport) -> None:
        """It only waits."""

    def void(self, refusal: OrderVoid) -> None:
        self.voided = str(refusal)
        self._happened.append(self.order.robot)
        asyncio.get_running_loop().call_soon(self._happened.append, "others")


class Two:
    """Two robots that queue, each at work, with one order that waits for it."""

    def __init__(self, latch: StopLatch | None = None, busy: Busy = Busy.QUEUE) -> None:
        self.clock = ManualClock()
        names = ("omni", "kuka1")
        profiles = {name: replace(PROFILE, id=name, busy=busy) for name in names}
        self.robots = {n: MemoryRobot(p, OrderGate.new(n), self.clock) for n, p in profiles.items()}
        self.linker = Linker(
            self.robots,
            StopRegistry(names, {}, not_known_yet()),
            latch or MemoryLatch(),
            self.clock,
            self.clock.wall_ns,
            Policy(0),
        )
        self.books = {name: OrderBook(profile, self.clock) for name, profile in profiles.items()}
        self.happened: list[str] = []
        self.doing = {name: self.entry(name) for name in names}
        self.waiting = {name: self.entry(name) for name in names}
        for name in names:
            assert self.linker.put(self.doing[name])
            assert not self.linker.put(self.waiting[name])

    def entry(self, name: str) -> Entry:
        return Entry(self.books[name].order("move"), self.happened)

    def why(self) -> dict[str, str]:
        return {name: entry.voided for name, entry in self.waiting.items()}


class SlowLatch(MemoryLatch):
    """Its disk stands still until it is let go."""

    def __init__(self) -> None:
        super().__init__()
        self.ready = asyncio.Event()

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        await self.ready.wait()
        await super().write(robot, generation, latched=latched)


class Deaf(MemoryRobot):
    """Its side does not answer when it is to be resumed."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002 - nothing hears it
        raise RobotUnreachable("omni does not answer.")


class Broken(MemoryRobot):
    """Its adapter has a fault that nobody thought of."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002
        raise ZeroDivisionError


class Silent(MemoryRobot):
    """Its side never answers when it is to be resumed."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002
        await asyncio.Event().wait()


async def stopped(
    kind: type[MemoryRobot], latch: StopLatch
) -> tuple[Linker, StopRegistry, MemoryRobot]:
    """A robot that was stopped, durably, for the first time."""
    clock = ManualClock()
    robot = kind(PROFILE, OrderGate.new("omni"), clock)
    stops = StopRegistry(["omni"], {}, not_known_yet())
    linker = Linker({"omni": robot}, stops, latch, clock, clock.wall_ns, Policy(0))
    halting = linker.stop(["omni"], "p1")
    assert await halting.latched
    return linker, stops, robot


async def test_a_resume_lets_go_on_disk_too() -> None:
    latch = MemoryLatch()
    linker, stops, robot = await stopped(MemoryRobot, latch)
    assert await linker.resume("omni", 1)
    assert latch.read() == {"omni": (1, False)}
    assert not stops["omni"].latched
    assert not robot.gate.latched


@pytest.mark.parametrize(("kind", "error"), [(Deaf, RobotUnreachable), (Broken, ZeroDivisionError)])
async def test_a_resume_that_failed_leaves_the_robot_stopped_on_disk_too(
    tmp_path: Path, kind: type[MemoryRobot], error: type[Exception]
) -> None:
    latch = FileLatch(tmp_path / "latch")
    linker, stops, _ = await stopped(kind, latch)
    with pytest.raises(error):
        await linker.resume("omni", 1)
    assert stops["omni"].latched
    assert FileLatch(tmp_path / "latch").read() == {"omni": (1, True)}
    await latch.close()


async def test_a_resume_that_was_cut_off_leaves_the_robot_stopped_on_disk_too() -> None:
    latch = MemoryLatch()
    linker, stops, _ = await stopped(Silent, latch)
    resuming = asyncio.create_task(linker.resume("omni", 1))
    await settle()
    resuming.cancel()
    with pytest.raises(asyncio.CancelledError):
        await resuming
    assert stops["omni"].latched
    assert latch.read() == {"omni": (1, True)}


async def test_a_resume_whose_stop_file_hangs_ends_in_time_and_leaves_the_robot_stopped() -> None:
    latch = SlowLatch()
    latch.ready.set()
    clock = ManualClock()
    robot = MemoryRobot(PROFILE, OrderGate.new("omni"), clock)
    stops = StopRegistry(["omni"], {}, not_known_yet())
    linker = Linker({"omni": robot}, stops, latch, clock, clock.wall_ns, Policy(0))
    assert await linker.stop(["omni"], "p1").latched
    latch.ready.clear()
    for _ in range(3):
        resuming = asyncio.create_task(linker.resume("omni", 1))
        await clock.advance(KEPT_WITHIN_S)
        await clock.advance(KEPT_WITHIN_S)
        with pytest.raises(StoreFault, match="The stop file does not answer"):
            await asyncio.wait_for(resuming, 60 * patience())
        assert stops["omni"].latched
        assert robot.gate.latched
    assert len(linker._latching) == 2, "only the first has begun to write"
    latch.ready.set()
    await settle()
    assert latch.read() == {"omni": (1, True)}, "the newest entry says how it is"
    assert await linker.resume("omni", 1)
    assert latch.read() == {"omni": (1, False)}


async def test_a_resume_waits_for_the_entry_of_its_stop_no_longer_than_that() -> None:
    latch, clock = SlowLatch(), ManualClock()
    robot = MemoryRobot(PROFILE, OrderGate.new("omni"), clock)
    stops = StopRegistry(["omni"], {}, not_known_yet())
    linker = Linker({"omni": robot}, stops, latch, clock, clock.wall_ns, Policy(0))
    linker.stop(["omni"], "p1")
    resuming = asyncio.create_task(linker.resume("omni", 1))
    await clock.advance(KEPT_WITHIN_S)
    with pytest.raises(StoreFault, match="The stop file does not answer"):
        await asyncio.wait_for(resuming, 60 * patience())
    latch.ready.set()
    await settle()
    assert latch.read() == {"omni": (1, True)}


class Disk:
    """Confirms what was written, or says that it cannot."""

    def __init__(self) -> None:
        self.full = False

    def wait(self, _descriptor: int) -> None:
        if self.full:
            raise OSError(28, "No space left on device")


async def test_a_resume_that_could_not_be_kept_is_not_written_by_the_next_stop(
    tmp_path: Path,
) -> None:
    """What failed is written again with what comes next: that must not be the resume."""
    disk = Disk()
    latch = FileLatch(tmp_path / "latch", wait_for_disk=disk.wait)
    linker, stops, _ = await stopped(MemoryRobot, latch)
    disk.full = True
    with pytest.raises(StoreFault, match="could not be kept on disk"):
        await linker.resume("omni", 1)
    disk.full = False
    await latch.write("kuka1", 1, latched=True)
    assert stops["omni"].latched
    assert FileLatch(tmp_path / "latch").read()["omni"] == (1, True)
    await latch.close()


class Asked(MemoryRobot):
    """Writes down what its side is asked to undo."""

    undone: ClassVar[list[int]]

    async def resume(self, generation: int) -> None:
        self.undone.append(generation)
        await super().resume(generation)


async def test_a_resume_that_a_later_stop_overtook_says_so_and_keeps_the_later_stop() -> None:
    latch = MemoryLatch()
    Asked.undone = []
    linker, stops, robot = await stopped(Asked, latch)
    await linker.stop(["omni"], "p2").latched
    assert await linker.resume("omni", 1) is False
    assert Asked.undone == [], "its side may count otherwise: it is not asked at all"
    assert stops["omni"].latched
    assert robot.gate.latched
    assert latch.read() == {"omni": (2, True)}


# ---- what waits ----


async def test_what_waits_is_told_of_a_stop_once_the_stop_is_on_disk() -> None:
    latch = SlowLatch()
    two = Two(latch)
    two.linker.stop(["omni", "kuka1"], "p1")
    await settle()
    assert two.happened == [], "ten thousand answers take longer than a stop may"
    assert all(robot.gate.latched for robot in two.robots.values())
    latch.ready.set()
    await settle()
    assert two.happened == ["omni", "others", "kuka1", "others"], "others had their turn between"
    assert "was stopped before this could begin" in two.why()["kuka1"]


async def test_what_waits_is_told_of_a_stop_though_the_disk_never_answers() -> None:
    two = Two(SlowLatch())
    two.linker.stop(["omni"], "p1")
    async with asyncio.timeout(60 * patience()):
        while not two.happened:  # noqa: ASYNC110 - the linker's own patience is what is waited for
            await asyncio.sleep(0.01)
    assert two.why()["kuka1"] == ""


async def test_a_stop_leaves_nothing_behind() -> None:
    two = Two()
    for _ in range(20):
        halting = two.linker.stop(["omni", "kuka1"], "p1")
        assert await halting.latched
        await asyncio.gather(*halting.rests.values())
        await settle()
    assert not two.linker._clearing | two.linker._resting | two.linker._latching


async def test_what_waits_is_voided_for_one_robot_or_for_all_with_the_reason() -> None:
    two = Two()
    two.linker.void("omni", "omni has gone.")
    assert two.why() == {"omni": "omni has gone.", "kuka1": ""}
    two.linker.clear("The gateway closes.")
    assert two.why() == {"omni": "omni has gone.", "kuka1": "The gateway closes."}
    assert two.linker.waiting("kuka1") == 0


async def test_one_order_that_waits_is_withdrawn_and_no_other() -> None:
    two = Two()
    second = two.entry("omni")
    two.linker.put(second)
    two.linker.withdraw("omni", second.order.cid, "It is not wanted any more.")
    assert second.voided == "It is not wanted any more."
    assert two.why() == {"omni": "", "kuka1": ""}
    two.linker.withdraw("omni", second.order.cid, "Again.")
    assert list(two.linker.entries("omni")) == [two.doing["omni"], two.waiting["omni"]]


async def test_whose_turn_it_is_can_be_asked() -> None:
    two = Two()
    assert two.linker.current("omni") is two.doing["omni"].order
    assert two.linker.next("omni") is two.waiting["omni"]
    assert two.linker.next("omni") is None
    assert two.linker.current("omni") is None
    assert list(two.linker.entries("omni")) == []
    two.linker.check_free("omni")
    two.linker.check_free("kuka1")


async def test_what_one_person_has_waiting_for_one_robot_can_be_taken_out() -> None:
    two = Two()
    principal = two.waiting["omni"].order.permit.principal
    assert two.linker.take_out("omni", "somebody else") == []
    assert two.linker.take_out("omni", principal) == [two.waiting["omni"]]
    assert two.linker.next("omni") is None
    assert two.linker.next("kuka1") is two.waiting["kuka1"]


# ---- what is relayed ----


async def test_an_order_is_outdated_once_whoever_gave_it_has_ended_what_they_had_under_way() -> (
    None
):
    two = Two()
    order, other = (two.doing[name].order for name in ("omni", "kuka1"))
    principal, stops = order.permit.principal, two.linker._stops
    stops.cancel("somebody else", [])
    assert not two.linker.outdated(order)
    stops.cancel(principal, ["omni"])
    assert two.linker.outdated(order)
    assert not two.linker.outdated(other)
    since = replace(order, permit=replace(order.permit, cancels=1))
    assert not two.linker.outdated(since), "it was admitted afterwards"


async def test_a_right_that_ends_at_this_moment_relays_nothing() -> None:
    two = Two()
    order = two.doing["omni"].order
    now_ns = two.clock.wall_ns()
    for until_ns, relayed in ((now_ns, False), (now_ns + 1, True)):
        permit = replace(order.permit, epoch=two.linker.epoch, until_ns=until_ns)
        doing = replace(order, permit=permit)
        if relayed:
            assert (await two.linker.dispatch(doing, ignore)).ending is OrderEnding.DONE
        else:
            with pytest.raises(PolicyMoved):
                await two.linker.dispatch(doing, ignore)
    assert list(two.robots["omni"].acted) == [order.n]


@pytest.mark.parametrize(
    ("left_ns", "left_wall_ns", "relayed"), [(0, 0, True), (-1, 0, False), (0, -1, False)]
)
async def test_what_has_expired_by_either_clock_is_not_relayed(
    left_ns: int, left_wall_ns: int, *, relayed: bool
) -> None:
    two = Two()
    doing = replace(
        two.doing["omni"].order,
        deadline_ns=two.clock.monotonic_ns() + left_ns,
        expires_ns=two.clock.wall_ns() + left_wall_ns,
        permit=replace(two.doing["omni"].order.permit, epoch=two.linker.epoch),
    )
    robot = two.robots["omni"]
    robot.gate = Lenient.new("omni")
    try:
        await two.linker.dispatch(doing, ignore)
    except OrderVoid as void:
        assert "too late" in str(void)  # noqa: PT017 - one of the cases is not void
    assert bool(robot.acted) is relayed


class Lenient(OrderGate):
    """Asks for no time: what comes here was relayed."""

    def pass_order(self, order: Order, *_when: int, together: bool = False) -> None:
        """Let everything through."""


class HalfBroken(MemoryLatch):
    """Keeps the stops of one robot only."""

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        if robot == "omni":
            raise StoreFault("no disk at all")
        await super().write(robot, generation, latched=latched)


async def test_a_stop_is_said_to_be_kept_only_if_it_is_for_every_robot() -> None:
    two = Two(HalfBroken())
    assert not await two.linker.stop(["omni", "kuka1"], "p1").latched
    assert await two.linker.stop(["kuka1"], "p1").latched


async def test_a_file_goes_to_the_robot_and_one_whose_link_takes_none_says_so() -> None:
    two = Two()
    robot_file = FileForRobot(name="a", path="a", sort="yaml", size=1, digest=b"d")
    receipt = await two.linker.deliver("omni", robot_file)
    assert two.robots["omni"].delivered == [robot_file]
    assert receipt.digest == robot_file.digest.hex()
    two.robots["omni"].deliver = None  # type: ignore[assignment,method-assign]
    with pytest.raises(RobotOffline, match="omni cannot be handed files over its link"):
        await two.linker.deliver("omni", robot_file)


async def test_what_a_robot_shows_is_what_is_seen() -> None:
    two = Two()
    with pytest.raises(NothingToSee):
        await anext(two.linker.look("omni", ViewKind.PICTURE))
    assert two.linker.presence("omni").online
    two.robots["omni"].online = False
    assert not two.linker.presence("omni").online
    assert two.linker.profile("kuka1").id == "kuka1"


async def test_a_robot_that_comes_later_is_routed_to_as_well() -> None:
    two = Two()
    late = MemoryRobot(replace(PROFILE, id="late"), OrderGate.new("late"), two.clock)
    two.linker.add_robot(late)
    assert two.linker.profile("late") is late.profile
    assert two.linker.current("late") is None
    assert two.linker.put(Entry(OrderBook(late.profile, two.clock).order("move"), []))


async def test_a_live_order_that_nobody_steers_is_void() -> None:
    two = Two()
    order = two.books["omni"].order("move")
    order = replace(order, live=True, permit=replace(order.permit, epoch=0))
    with pytest.raises(OrderVoid, match="omni cannot be driven live over its link"):
        await two.linker.dispatch(order, ignore)
    assert not two.robots["omni"].acted


class Fixed:
    """A robot that cannot be driven live, whatever is inside."""

    def __init__(self, inside: MemoryRobot) -> None:
        self.profile, self.gate = inside.profile, inside.gate


async def test_a_robot_that_cannot_be_driven_live_is_not() -> None:
    clock = ManualClock()
    inside = MemoryRobot(PROFILE, OrderGate.new("omni"), clock)
    order = replace(OrderBook(PROFILE, clock).order("move"), live=True)
    controls = LiveControls(SampleGate(order.cid, (), {}), clock)
    fixed = cast("Robot", Fixed(inside))
    with pytest.raises(OrderVoid, match="omni cannot be driven live over its link"):
        await execute_live(fixed, order, ignore, controls)
