"""``continue`` undoes a stop of one's own, and nothing that somebody else has stopped as well."""

from __future__ import annotations

import msgspec
from msgspec.structs import replace

from rosic.core.stopboard import StopBoard, not_known_yet
from rosic.pipeline.stopped_by import StoppedBy, restore, stopped_by
from tests.rooms.pipeline.place import BO, Place


def _latched(place: Place) -> list[str]:
    return [name for name, robot in place.gateway.robots.items() if robot.gate.latched]


def _labels(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def test_ones_own_stop_covers_nobody_elses_and_continue_does_not_undo_theirs() -> None:
    async with Place().open() as place:
        await place.say("stop omni", account=BO, chat=BO)
        await place.clock.advance(120)
        await place.say("stop omni")
        told = await place.say("continue")
        assert told.startswith("omni is stopped, by Bo and Ada, since 22:13. It stays stopped")
        assert (_latched(place), _labels(place)) == (["omni"], ["resume omni"])
        assert await place.say("resume omni") == "omni is ready again.", "that is said of it"
        await place.say("stop omni")
        await place.say("stop omni")
        assert await place.say("continue") == "omni is ready again.", "Bo's was over"


async def test_it_is_known_after_a_restart_whether_somebody_else_has_stopped_it() -> None:
    found = {"omni": (2, True), "kuka1": (1, True), "cf1": (1, True)}
    board = StopBoard(found, {}, not_known_yet())
    board.stop("omni", "p2", 5)
    for robot in board:
        board.stop(robot, "p1", 7)
    facts = [stopped_by(robot, board) for robot in board]
    before = msgspec.to_builtins(StoppedBy(1, "p1", 7))
    del before["stoppers"]  # as versions wrote it that did not keep them
    facts[2] = replace(facts[2], body=msgspec.msgpack.encode(before))
    later = StopBoard(found, found, not_known_yet())
    assert not any(entry.alone("p1") for entry in later.values())
    restore(later, facts)
    assert later["omni"].stoppers == {"p2": 5, "p1": 7}
    assert [later[robot].alone("p1") for robot in found] == [False, True, False]
    later.stop("kuka1", "p2", 9)
    assert not later["kuka1"].alone("p1")
