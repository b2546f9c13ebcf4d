"""Two whole gateways, each with its bot, in one group: who answers, who stops, and no loops.

Telegram has one group for both; here each bot has a fake server of its own, and a bridge shows in
each what was said in the other: people's words as theirs, and the other bot's as another bot's.
It also hands over the other bot's words as updates, as Telegram does in its bot-to-bot mode.
"""

from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any

from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.journeys.running import Launcher

NAMES = ("first_lab_bot", "second_lab_bot")
BOTH = (0, 1)


class Group:
    """One group, with two bots and two people.

    Attributes:
        places: What is around each gateway.
    """

    def __init__(self, places: tuple[Lab, Lab]) -> None:
        self.places = places
        self._chats = [0, 0]
        self._others = [0, 0]
        self._shown: list[dict[int, int]] = [{}, {}]

    async def open(self) -> None:
        """Bring the people and both bots together, and let both gateways listen."""
        for number in BOTH:
            place, other = self.places[number], 1 - number
            await place.start()
            self._chats[number] = await place.control.create_chat(
                "supergroup", "Lab", members=[place.ada, place.bo]
            )
            self._others[number] = await place.control.create_user(
                "Gateway", username=NAMES[other], is_bot=True
            )
            chat, bot = self._chats[number], self._others[number]
            await place.control.call("set_member", chat=chat, user=bot, status="member")
            await place.reads(chat, "gives nobody any")

    async def say(self, text: str, *, answers: tuple[int, str] | None = None) -> None:
        """Bo writes, perhaps in reply to what one of the bots has said; both are told."""
        replied: list[dict[str, int]] = [{}, {}]
        if answers is not None:
            whose, words = answers
            message = (await self.places[whose].reads(self._chats[whose], words))["message_id"]
            await self.bridge()
            replied[whose]["reply_to"] = message
            replied[1 - whose]["reply_to"] = self._shown[1 - whose][message]
        for number in BOTH:
            place = self.places[number]
            await place.say(place.bo, text, self._chats[number], **replied[number])
        await self.settled()

    async def settled(self) -> None:
        """Wait until both have settled what they were told, the other's words included."""
        for _ in range(3):  # an answer to an answer would show in the second round
            for number in BOTH:
                await self.places[number].drained()
            await self.bridge()

    async def bridge(self) -> None:
        """Show in each server what the other's bot has said."""
        for number in BOTH:
            other = 1 - number
            chat, bot = self._chats[other], self._others[other]
            control = self.places[other].control
            for message in await self.places[number].control.messages(
                self._chats[number], by_bot=True
            ):
                if message["message_id"] not in self._shown[other]:
                    shown = await control.say(chat, bot, message["text"])
                    self._shown[other][message["message_id"]] = shown
                    await self._hand_over(other, shown, message["text"])

    async def _hand_over(self, number: int, message: int, text: str) -> None:
        chat = {"id": self._chats[number], "type": "supergroup", "title": "Lab"}
        name = NAMES[1 - number]
        sender = {"id": self._others[number], "is_bot": True, "first_name": "G", "username": name}
        control = self.places[number].control
        date = int((await control.call("health"))["now_s"])
        told: dict[str, Any] = {
            "message_id": message,
            "date": date,
            "chat": chat,
            "from": sender,
            "text": text,
        }
        await control.call("put_update", kind="message", payload=told)

    async def answers(self) -> list[int]:
        """Return how many messages each bot has written in the group."""
        return [
            len(await self.places[n].control.messages(self._chats[n], by_bot=True)) for n in BOTH
        ]

    async def reads(self, number: int, text: str) -> None:
        """Wait until one of the bots says something in the group."""
        await self.places[number].reads(self._chats[number], text)


@asynccontextmanager
async def two_gateways(folder: Path, launcher: Launcher) -> AsyncIterator[Group]:
    """Run both; each hears everything that Telegram gives it."""
    async with AsyncExitStack() as stack:
        places = []
        for name in NAMES:
            (folder / name).mkdir()
            options = ("--no-limits", "--no-privacy", "--username", name)
            entered = lab(folder / name, launcher, options=options)
            places.append(await stack.enter_async_context(entered))
        group = Group((places[0], places[1]))
        await group.open()
        yield group


def acted(group: Group) -> list[int]:
    """Return how often any robot of each gateway acted."""
    return [place.acted() for place in group.places]


async def test_only_the_one_that_is_addressed_answers_and_moves(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with two_gateways(tmp_path, launcher) as group:
        before = await group.answers()
        await group.say(f"/status@{NAMES[0]}")
        await group.reads(0, "Ant")
        assert await group.answers() == [before[0] + 1, before[1]]

        await group.say(f"@{NAMES[1]} ant hop")
        await group.reads(1, "done ")
        assert acted(group) == [0, 1]
        assert (await group.answers())[0] == before[0] + 1

        await group.say("hop", answers=(1, "Ant: hop"))
        assert await group.places[1].until(lambda: acted(group)[1] > 1)
        await group.settled()
        assert acted(group) == [0, 2]
        assert (await group.answers())[0] == before[0] + 1


async def test_a_stop_reaches_both_whomever_it_names(tmp_path: Path, launcher: Launcher) -> None:
    async with two_gateways(tmp_path, launcher) as group:
        for stop in ("/stop", f"/stop@{NAMES[0]}"):
            await group.say(stop)
            for number in BOTH:
                await group.reads(number, "at rest")
                place = group.places[number]
                await place.ask(place.bo, "bee hop", "is stopped")
                await place.ask(place.ada, "resume bee", "ready again")
        assert acted(group) == [0, 0]


async def test_what_one_bot_says_sets_nothing_off_in_the_other(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with two_gateways(tmp_path, launcher) as group:
        await group.say("ant hop")  # whoever is meant: both have an ant
        for number in BOTH:
            await group.reads(number, "done ")
        await group.settled()
        still = await group.answers()
        for words in ("stop", "ant hop", f"@{NAMES[0]} ant hop", f"/status@{NAMES[0]}", "resume"):
            await group._hand_over(0, 90_000 + len(words), words)
        await group.settled()
        assert await group.answers() == still, "bots talk to each other"
        assert acted(group) == [1, 1]
        place = group.places[0]
        await place.ask(place.bo, "bee hop", "done ")
