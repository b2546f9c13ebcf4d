"""What people read of a stop that was confirmed later than its answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.linker.pursuit import EVERY_S
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import ADA, BO, Place

if TYPE_CHECKING:
    from rosic.core.order import RestReport, Stop
    from rosic.core.robot.profile import Presence


class Coasting(MemoryRobot):
    """It goes on moving until it was told to stop for the second time."""

    tries = 0
    moving = False

    async def stop(self, stop: Stop) -> RestReport:
        rest = await super().stop(stop)
        self.tries += 1
        self.moving = self.tries == 1
        return replace(rest, confirmed=not self.moving)

    def presence(self) -> Presence:
        found = super().presence()
        return replace(found, at_rest=False) if self.moving else found


class Slope(Place):
    kind = Coasting


async def test_it_is_said_to_move_not_resumed_and_then_to_be_at_rest() -> None:
    async with Slope().open() as here:
        told = await here.say("stop omni")
        assert "omni has not confirmed the stop. Use its own stop button." in told
        status = await here.say("status omni")
        assert "stopped by you · STOP not confirmed: it moves" in status
        refused = await here.say("resume omni")
        assert "omni stays stopped: omni still moves: its stop is not confirmed yet" in refused
        assert here.chat.told[-1].outbound.code == "still-moves"
        await here.clock.advance(EVERY_S)
        await here.quiet()
        assert here.last()[1].text == "omni is at rest now."
        assert "not confirmed" not in await here.say("status omni")
        assert "omni is ready again." in await here.say("resume omni")


class Rolling(Coasting):
    """It comes to rest only once it was told so for the last of so many times."""

    times = 4

    async def stop(self, stop: Stop) -> RestReport:
        rest = await MemoryRobot.stop(self, stop)
        self.tries += 1
        self.moving = self.tries < self.times
        return replace(rest, confirmed=not self.moving)


class LongSlope(Place):
    kind = Rolling


async def test_everybody_who_stopped_it_reads_that_it_is_at_rest() -> None:
    async with LongSlope().open() as here:
        await here.say("stop omni")
        await here.say("stop omni", account=BO, chat=BO)
        await here.say("stop omni", account=BO, chat=BO)
        unseen = [told.outbound for told in here.chat.told]
        assert not any("at rest" in each.text for each in unseen)
        await here.clock.advance(EVERY_S)
        await here.quiet()
        now = [t.outbound for t in here.chat.told if t.outbound.text == "omni is at rest now."]
        assert sorted(each.chat.id for each in now) == [ADA, BO], "each once in their chat"


async def test_whoever_stopped_it_before_somebody_whose_stop_was_confirmed_reads_it_too() -> None:
    async with Slope().open() as here:
        await here.say("stop omni")
        told = await here.say("stop omni", account=BO, chat=BO)
        assert "STOP: omni at rest" in told
        await here.quiet()
        now = [t.outbound for t in here.chat.told if t.outbound.text == "omni is at rest now."]
        assert [each.chat.id for each in now] == [ADA]


async def test_whoever_resumes_or_stops_again_is_told_nothing_of_the_stop_before() -> None:
    async with Slope().open() as here:
        await here.say("stop omni")
        again = await here.say("stop omni")
        assert "omni at rest" in again
        await here.clock.advance(60)
        await here.quiet()
        assert "omni is at rest now." not in [told.outbound.text for told in here.chat.told]
