"""What passes a link is counted where it passes, and told as what it comes to in a second."""

from __future__ import annotations

from rosic.contracts.traffic import traffic_of
from rosic.core.message import Chat, Outbound
from rosic.core.time_units import SECOND_NS
from rosic.core.traffic import TrafficCount, TrafficCounter, TrafficMeter
from rosic.messengers.memory import MemoryMessenger
from rosic.testing.clock import ManualClock
from rosic.testing.messenger_harness import listening, until
from tests.conformance.messenger_harnesses import telegram_stage
from tests.gateway.place import BO, Place


def test_a_rate_is_what_passed_since_the_last_look_over_the_time_since() -> None:
    meter = TrafficMeter()
    assert meter.take({"a": TrafficCount(10, 4, 100, 40)}, SECOND_NS) == {}
    found = meter.take({"a": TrafficCount(16, 5, 400, 50), "b": TrafficCount(1, 1)}, 3 * SECOND_NS)
    assert found == {"a": (3.0, 0.5, 150.0, 5.0)}
    later = meter.take({"a": TrafficCount(16, 5, 400, 50), "b": TrafficCount(1, 2)}, 4 * SECOND_NS)
    assert later == {"a": (0.0, 0.0, 0.0, 0.0), "b": (0.0, 1.0, 0.0, 0.0)}


def test_of_a_long_pause_and_of_no_time_nothing_is_told() -> None:
    meter, count = TrafficMeter(), {"a": TrafficCount(1, 1)}
    meter.take(count, SECOND_NS)
    assert meter.take(count, SECOND_NS) == {}
    assert meter.take({"a": TrafficCount(9, 9)}, 60 * SECOND_NS) == {}


def test_a_counter_counts_messages_and_what_they_hold() -> None:
    counter = TrafficCounter()
    counter.came(5)
    counter.came(7, messages=2)
    counter.went()
    assert counter.count == TrafficCount(received=3, sent=1, received_bytes=12, sent_bytes=0)


async def test_a_messenger_counts_what_it_hears_and_shows() -> None:
    chat = MemoryMessenger(clock=ManualClock())
    chat.say("stöp")
    await chat.send(Outbound(chat=Chat("memory", "1"), text="at rest"))
    assert traffic_of(chat) == TrafficCount(1, 1, 5, 7)
    assert traffic_of(object()) is None


async def test_the_gateway_knows_what_passes_its_messengers_and_its_robots() -> None:
    async with Place().open() as place:
        [messenger] = place.gateway.kernel.messengers
        before, robot = traffic_of(messenger), traffic_of(place.robot("omni"))
        assert before is not None
        assert robot == TrafficCount()
        await place.say("omni wave", account=BO, chat=BO)
        after = traffic_of(messenger)
        assert after is not None
        assert after.received == before.received + 1
        assert after.sent > before.sent
        assert traffic_of(place.robot("omni")) == TrafficCount(received=1, sent=1)
        assert traffic_of(place.robot("kuka1")) == TrafficCount()


async def test_what_passes_the_bot_api_is_counted_as_calls_updates_and_their_bytes() -> None:
    async with telegram_stage() as stage, listening(stage) as inbox:
        person = stage.people[0]
        await stage.write(person, "omni wave")
        await until(stage, lambda: bool(inbox.heard), "nothing was heard")
        before = traffic_of(stage.messenger)
        await stage.messenger.send(Outbound(chat=stage.chat(person), text="at rest"))
        after = traffic_of(stage.messenger)
    assert before is not None
    assert after is not None
    assert before.received == after.received == 1
    assert before.received_bytes > len("omni wave")
    assert after.sent == before.sent + 1
    assert after.sent_bytes > before.sent_bytes + len("at rest")
