"""What changes nothing: edited, forwarded, and written through somebody else (I17)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.journeys.lab import lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher


async def test_edited_and_forwarded_messages_change_nothing_but_a_stop_is_obeyed(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        written = await place.say(place.bo, "help")
        await place.reads(place.bo, "Say what a robot should do", to=written)
        quiet = await place.control.seq()
        await place.control.edit(place.bo, written, "ant hop")
        await place.say(place.bo, "ant hop", forward_origin=place.ada)
        await place.say(place.bo, "ant hop", forward_origin="Somebody hidden")
        await place.say(place.bo, "ant hop", via_bot=True)
        await place.drained()
        said = await place.control.call("changes", after=quiet, kinds=["sent", "edited"])
        assert len(said) == 1, "one line about the change, and nothing about the rest"
        await place.reads(place.bo, "I do not follow messages that were changed")
        assert place.acted() == 0

        await place.control.edit(place.bo, written, "stop ant")
        await place.reads(place.bo, "STOP: Ant at rest")
        await place.say(place.bo, "stop bee", forward_origin=place.ada)
        await place.reads(place.bo, "STOP: Bee at rest")
        await place.ask(place.bo, "ant hop", "is stopped")

        await place.ask(place.bo, "cat hop", "done ")  # the same people, in their own words
        assert place.acted() == 1


async def test_a_stranger_moves_nothing_and_stops_nothing(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        stranger = await place.control.create_user("Ada", username="ada")

        await place.ask(stranger, "ant hop", "I do not know you yet")
        await place.say(stranger, "stop")
        await place.drained()

        assert place.counter.events == []
