"""``/record``: what was asked of a robot beside what moved, for whoever may see it."""

from __future__ import annotations

import io
import json
from base64 import b64decode
from typing import TYPE_CHECKING

import pytest
from mcap.reader import make_reader

from rosic.app.admin.api import AdminVerb
from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import ChatKind
from rosic.core.robot.view import CompressedFrame, OccupancyMap, Pose, ViewKind
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.features.recording.studio import Studio, read
from tests.gateway.place import ADA, BO, PEOPLE, VI, BrokenStore, ask_as_operator

if TYPE_CHECKING:
    from rosic.testing.clock import ManualClock

JPEG = b"\xff\xd8\xff\xe0" + b"\0" * 100


async def test_a_recording_holds_what_was_asked_beside_what_moved() -> None:
    async with Studio().open() as place:
        omni = place.robot("omni")
        omni.pose, omni.values = Pose(1.0, 2.0, yaw_rad=0.5, frame="odom"), {"battery": 81.5}
        omni.shows[ViewKind.MAP] = OccupancyMap(2, 1, 0.05, Pose(0, 0, frame="map"), b"\0\xff")
        said = await place.say("/record omni 10 s")
        assert said == "Recording Omni for 10 s."
        await place.past(1)
        await place.say("omni move 1 m forward")
        omni.pose = Pose(2.0, 2.0, yaw_rad=0.5, frame="odom")
        await place.past(10)
        file = await place.file()
        assert place.recordings == 0
    found = read(file.content)
    stages = [(one["stage"], one["over"]) for one in found["/omni/orders"]]
    assert ("done", True) in stages
    assert [stage for stage, _ in stages] == ["accepted", "sent", "received", "done"]
    assert {one["words"] for one in found["/omni/orders"]} == {"move, 1.00 m forward"}
    assert found["/omni/orders"][0]["arguments"] == {"direction": "forward", "distance": 1.0}
    places = [one["pose"]["position"]["x"] for one in found["/omni/pose"]]
    assert places[0] == 1.0
    assert places[-1] == 2.0
    assert {one["frame_id"] for one in found["/omni/pose"]} == {"omni/odom"}
    assert {one["child_frame_id"] for one in found["/tf"]} == {"omni/base_link"}
    value, shown = found["/omni/telemetry/battery"][0], found["/omni/map"][0]
    assert (value["value"], value["unit"]) == (81.5, "%")
    assert (shown["frame_id"], shown["schema"]) == ("map", "foxglove.Grid")
    assert "/omni/camera" not in found


async def test_the_file_says_of_what_it_is() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 3 s")
        await place.past(4)
        file = await place.file()
    about = {m.name: m.metadata for m in make_reader(io.BytesIO(file.content)).iter_metadata()}
    assert about["rosic"]["robot.omni"] == "Omni"
    assert about["rosic"]["place"] == "rosic"
    assert file.name.startswith("omni-20231114T")
    assert file.name.endswith(".mcap")


async def test_it_ends_when_it_is_asked_to_and_the_file_is_the_answer() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 30 min")
        await place.past(1)
        before = len(place.chat.told)
        button, under = place.button("End it now")
        await place.tap(button, under)
        file = await place.file()
        assert read(file.content)["/omni/state"]
        told = list(place.chat.told)[before:]
        [ended] = [one.outbound.text for one in told if one.outbound.attachment is not None]
        assert ended.startswith("You ended the recording of Omni: ")
        assert await place.say("/files") == (
            "I keep no file of yours. Send me a photo or a document and I keep it, sealed. "
            "Here I take files of up to 1.0 MB and send files of up to 1.0 MB."
        )


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("/record", "Say which robot, and how long"),
        ("/record omni 5 flurbs", "Say which robot, and how long"),
        ("/record omni 5 min 5 min", "Say which robot, and how long"),
        ("/record omni tomorrow", "Say which robot, and how long"),
        ("/record omni 0 s", "from 1 s to 30 min"),
        ("/record omni 2 h", "from 1 s to 30 min"),
        ("/record omni -1 min", "Say which robot, and how long"),
        ("/record kuka1 1 min with camera", "kuka1 has no camera"),
        ("/record nobody 1 min", "no robot"),
        ("/record 1 min", "Which robot?"),
        ("/record omni end", "You do not record Omni now."),
    ],
)
async def test_what_is_not_understood_begins_nothing(line: str, said: str) -> None:
    async with Studio().open() as place:
        assert said in await place.say(line)
        assert place.recordings == 0


async def test_each_robot_once_for_each_person_and_not_too_many_at_all() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 1 min")
        told = await place.say("/record omni 1 min")
        assert told == "You record Omni already. /record Omni end ends that."
        assert await place.say("/record omni 1 min", account=BO, chat=BO) == (
            "Recording Omni for 1 min."
        )
        assert "Recording kuka1" in await place.say("/record kuka1 1 min")
        assert place.recordings == 3


async def test_nobody_reads_along() -> None:
    async with Studio().open() as place:
        told = await place.say("/record omni 1 min", chat="-5", kind=ChatKind.GROUP)
        assert "in a private chat" in told
        assert place.recordings == 0


async def test_what_others_ask_is_in_it_without_their_words_unless_one_may_read_them() -> None:
    async with Studio().open() as place:
        for account in (ADA, BO, VI):
            await place.say("/record omni 10 s", account=account, chat=account)
        await place.past(0.5)
        await place.say("omni move 1 m forward", account=BO, chat=BO)
        await place.past(11)
        files = {account: (await place.file(account)).content for account in (ADA, BO, VI)}
        bo = place.gateway.rooms.authoriser.directory.at(Address("memory", BO))
        assert bo is not None
    for account in (ADA, BO):  # an admin, and whoever asked
        steps = read(files[account])["/omni/orders"]
        assert {one["by"] for one in steps} == {bo[0].id}
        assert {one["words"] for one in steps} == {"move, 1.00 m forward"}
    steps = read(files[VI])["/omni/orders"]
    assert {(one["by"], one["words"], one["skill"]) for one in steps} == {("", "", "move")}
    assert steps[-1]["stage"] == "done"
    assert all(one["arguments"] == {} and one["note"] == "" for one in steps)
    for content in files.values():  # names stand in no file: it could not be taken back
        whole = json.dumps(read(content))
        assert not any(name in whole for name in ("Ada", "Bo", "Vi"))


async def test_stops_and_alarms_stand_beside() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 20 s")
        await place.past(1)
        await place.say("stop omni", account=BO, chat=BO)
        await place.past(1)
        await place.say("/resume omni")
        await place.past(1)
        place.gateway.kernel.shared.alarm_news.emit("omni", "Omni: battery is low", True)
        place.gateway.kernel.shared.alarm_news.emit("kuka1", "kuka1: battery is low", True)
        await place.past(20)
        file = await place.file()
    told = [(one["name"], one["message"]) for one in read(file.content)["/rosic/events"]]
    assert [text for _, text in told][1:] == ["was resumed", "Omni: battery is low"]
    assert told[0][1].startswith("was stopped by p")
    assert {name for name, _ in told} == {"omni"}
    states = read(file.content)["/omni/state"]
    assert [one["stopped"] for one in states].count(True) >= 1


async def test_its_camera_is_in_it_only_if_it_is_asked_for() -> None:
    async with Studio().open() as place:
        place.robot("omni").shows[ViewKind.PICTURE] = CompressedFrame(JPEG)
        assert await place.say("/record omni 5 s with camera") == (
            "Recording Omni, with its camera, for 5 s."
        )
        await place.past(7)
        found = read((await place.file()).content)
        assert b64decode(found["/omni/camera"][0]["data"]) == JPEG
        assert found["/omni/camera"][0]["format"] == "jpeg"
        assert 3 <= len(found["/omni/camera"]) <= 6
        assert place.robot("omni").looked == 0  # and is looked at no more


async def test_a_right_that_ends_ends_it_and_nothing_later_is_in_it() -> None:
    class Guests(Studio):
        people = (*PEOPLE[:2], ConfiguredPerson("Vi", (Address("memory", VI),), ()))

    async with Guests().open() as place:
        await place.say("/grant Vi viewer omni for 20 s")
        place.robot("omni").values = {"battery": 50.0}
        assert "Recording Omni" in await place.say("/record omni 10 min", account=VI, chat=VI)
        await place.past(15)
        assert place.recordings == 1
        await place.past(10)
        assert place.recordings == 0
        place.robot("omni").values = {"battery": 10.0}
        file = await place.file(VI)
        [text] = [one.outbound.text for one in place.chat.told if one.outbound.attachment]
        assert text.startswith("You may not see Omni any more, so its recording ended.")
    values = read(file.content)["/omni/telemetry/battery"]
    assert {one["value"] for one in values} == {50.0}
    assert 19 <= len(values) <= 21


async def test_whose_access_is_taken_back_gets_nothing() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 10 min", account=VI, chat=VI)
        await place.past(3)
        who = place.gateway.rooms.authoriser.directory.at(Address("memory", VI))
        assert who is not None
        await place.revoke("Vi")
        await place.past(3)
        assert place.recordings == 0
        assert not any(told.outbound.attachment for told in place.chat.told)
        assert place.gateway.kernel.containers is not None
        assert place.gateway.kernel.containers.files.used(who[0].id) == (0, 0)


async def test_whoever_is_locked_gets_nothing() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 10 min", account=BO, chat=BO)
        await place.past(2)
        await ask_as_operator(place.gateway, AdminVerb.LOCK, "Bo")
        await place.past(3)
        assert place.recordings == 0
        assert not any(told.outbound.attachment for told in place.chat.told)


async def test_what_is_too_large_for_the_messenger_is_kept_and_said() -> None:
    def small(clock: ManualClock) -> MemoryMessenger:
        return MemoryMessenger(clock=clock, file_bytes=500)

    async with Studio(chat=small).open() as place:
        await place.say("/record omni 3 s")
        await place.past(6)
        told = place.last()[1].text
        assert told.startswith("The recording of Omni is complete: ")
        assert "I can send files of up to 500 bytes here. It is kept among your files" in told
        assert told.split("get ")[1].rstrip(".") in await place.say("/files")


async def test_a_messenger_that_is_away_loses_nothing() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 3 s")
        place.chat.down = True
        await place.past(6)
        place.chat.down = False
        await place.past(30)
        assert "It is kept among your files" in place.last()[1].text


async def test_a_full_disk_ends_it_with_one_sentence_and_nothing_else() -> None:
    store = BrokenStore()
    async with Studio(store).open() as place:
        await place.say("/record omni 10 min")
        await place.past(5)
        before = len(place.chat.told)
        store.broken = True
        await place.past(5)
        assert place.recordings == 0
        [told] = [one.outbound.text for one in list(place.chat.told)[before:]]
        assert told.startswith("The recording of Omni ended, as it could not be written")
        store.broken = False
        await place.say("omni move 1 m forward")
        assert place.acted() == 1
    async with Studio(store, clock=place.clock).open() as place:  # what came before is not lost
        assert "What was written before is kept" in place.last()[1].text


async def test_a_restart_keeps_what_was_written_and_says_so() -> None:
    store = MemoryStore()
    async with Studio(store).open() as place:
        await place.say("/record omni 10 min")
        place.robot("omni").values = {"battery": 42.0}
        await place.past(5)
    async with Studio(store, clock=place.clock).open() as place:
        assert place.recordings == 0
        told = place.last()[1].text
        assert told.startswith("A recording of yours was cut off when I was restarted.")
        await place.say(f"/files get {told.split('get ')[1].rstrip('.')}")
        found = read((await place.file()).content)
        assert found["/omni/telemetry/battery"][-1]["value"] == 42.0
    async with Studio(store, clock=place.clock).open() as place:  # it is said once
        assert not place.chat.told


async def test_whoever_is_erased_is_recorded_for_no_more() -> None:
    async with Studio().open() as place:
        await place.say("/record omni 10 min", account=VI, chat=VI)
        await place.past(3)
        who = place.gateway.rooms.authoriser.directory.at(Address("memory", VI))
        assert who is not None
        await place.gateway.kernel.erasure.end(who[0].id)
        await place.past(1)
        assert place.recordings == 0
        containers = place.gateway.kernel.containers
        assert containers is not None
        assert containers.files.used(who[0].id) == (0, 0)


async def test_without_the_library_people_are_told() -> None:
    class Without(Studio):
        recorder = None

    async with Without().open() as place:
        assert "mcap is missing" in await place.say("/record omni 1 min")
