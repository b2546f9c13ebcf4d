"""A channel is a window: opened by an admin, for reading, and nothing in it commands anything."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

BOT = 4242424242
WINDOW = "For reading: nothing that is written here commands a robot."


async def tap(place: Lab, user: int, label: str, expected: str) -> None:
    """Tap the newest button that says this, in private, and read what comes of it."""

    async def showing() -> dict[str, Any] | None:
        for message in reversed(await place.control.messages(user, by_bot=True)):
            if any(b["text"] == label for row in message["buttons"] for b in row):
                return message
        return None

    message = await place.until(showing)
    assert message is not None, f"nobody shows {label}"
    await place.control.tap(user, user, message["message_id"], label)
    await place.reads(user, expected)


async def test_it_shows_what_an_admin_opens_and_obeys_nothing(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        news = await place.control.create_chat(
            "channel", "News", members=[place.ada], bot="administrator"
        )
        await place.reads(place.ada, "Ada put me into the channel News. It shows nothing yet.")
        assert await place.control.messages(news, by_bot=True) == []
        await place.ask(place.bo, "/channel", "Only who may give rights")
        await tap(place, place.ada, "Show Ant", "News shows Ant, to everybody who reads it.")
        shown = await place.reads(news, WINDOW)
        assert "Ant: free" in shown["text"]
        assert "Bee" not in shown["text"]
        assert shown["buttons"] == []

        await place.ask(place.bo, "ant hop", "done ")
        # Another one shows at once what the first is about to show.
        more = await place.control.create_chat(
            "channel", "More", members=[place.ada], bot="administrator"
        )
        await tap(place, place.ada, "Show all", "More shows Ant, Bee")
        shown = await place.reads(more, "now: done")
        assert "Ant: taken" in shown["text"]
        assert "Bo" not in shown["text"], "the world reads along"
        for words in ("ant hop", "/card bee", "@rosic_test_bot ant hop", "/start", "resume"):
            post = await place.control.say(news, None, words)
            await place.control.edit(news, post, f"{words} now")
        await place.drained()
        assert place.acted() == 1
        assert len(await place.control.messages(news, by_bot=True)) == 1

        await place.ask(place.ada, "/channel", "News shows Ant,")
        await tap(place, place.ada, "Close News", "News shows no robot any more.")
        await place.reads(news, "This card has ended.")
        assert await place.control.violations() == []


async def test_over_a_restart_it_goes_on_and_put_out_it_ends(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        news = await place.control.create_chat(
            "channel", "News", members=[place.ada], bot="administrator"
        )
        await tap(place, place.ada, "Show all", "News shows ")
        shown = await place.reads(news, "Bee: free")

        async def versions() -> int:
            return len((await place.control.message(news, shown["message_id"]))["versions"])

        async def changed() -> bool:
            return await versions() > 1

        # Only whoever knows which message shows the window can change it.
        await place.ask(place.ada, "ant hop", "done ")
        assert await place.until(changed)
        # Written one after another: once this is, so is where the window is.
        await place.ask(place.ada, "/grant Bo viewer ant for 1h", "Bo")
        gateway.kill()
        before = await versions()
        await place.start()

        async def renewed() -> bool:
            return await versions() > before

        assert await place.until(renewed)
        assert len(await place.control.messages(news, by_bot=True)) == 1
        await place.ask(place.ada, "/channel", "A channel shows")
        await place.control.call("set_member", chat=news, user=BOT, status="left")
        await place.drained()
        await place.ask(place.ada, "/channel", "I am in no channel")
