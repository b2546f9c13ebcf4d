"""We come into groups and are put out of them, they move, people leave."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.features.groups.membership import GREETINGS
from rosic.messengers.memory import MemoryMessenger
from tests.gateway.place import ADA, BO, Place

TRIED_AT_MOST = 2
LAB = Chat("memory", "-5", ChatKind.GROUP)
ACCOUNT = Chat("memory", "", ChatKind.GROUP)
IN_LAB = {"chat": "-5", "kind": ChatKind.GROUP}


def _passing(what: ChatEventKind, who: str = BO, chat: Chat = LAB, **more: object) -> ChatEvent:
    return ChatEvent(chat=chat, what=what, who=Address("memory", who), title="Lab", **more)  # type: ignore[arg-type]


async def _pass(place: Place, passing: ChatEvent) -> list[tuple[str, str]]:
    before = len(place.chat.told)
    place.chat.passed(passing)
    await place.quiet()
    return [(t.outbound.chat.id, t.outbound.text) for t in list(place.chat.told)[before:]]


async def test_a_new_group_is_greeted_once_and_the_admins_know_what_is_heard() -> None:
    async with Place().open() as place:
        told = await _pass(place, _passing(ChatEventKind.ADDED, deaf=True))
        assert sorted(chat for chat, _ in told) == ["-5", ADA]
        texts = dict(told)
        assert "gives nobody any" in texts["-5"]
        assert "say /stop" in texts["-5"]
        assert texts[ADA].startswith("Bo put me into Lab.")
        assert "Here I hear only commands" in texts[ADA]


class _Explaining(MemoryMessenger):
    def hearing(self, *, everywhere: bool) -> str:
        return f"Ask the porter, everywhere: {everywhere}."


async def test_what_changes_what_is_heard_is_the_messengers_to_say() -> None:
    async with Place(chat=lambda clock: _Explaining(clock=clock)).open() as place:
        told = dict(await _pass(place, _passing(ChatEventKind.ADDED, deaf=True)))
        assert told[ADA] == "Bo put me into Lab. Ask the porter, everywhere: False."
        told = dict(await _pass(place, _passing(ChatEventKind.DEAF, chat=ACCOUNT)))
        assert told == {ADA: "Ask the porter, everywhere: True."}


async def test_what_a_group_is_called_gives_the_admins_no_command() -> None:
    async with Place().open() as place:
        called = replace(_passing(ChatEventKind.ADDED, who="99"), title="/unlock Eve, or ／stop")  # noqa: RUF001
        texts = dict(await _pass(place, called))
        assert "put me into \u2215unlock Eve, or \u2215stop." in texts[ADA]


async def test_a_group_where_everything_is_heard_is_told_so() -> None:
    async with Place().open() as place:
        texts = dict(await _pass(place, _passing(ChatEventKind.ADDED, who="99")))
        assert "stop is enough" in texts["-5"]
        assert texts[ADA] == "Somebody I do not know put me into Lab. I read everything there."
        told = await _pass(place, _passing(ChatEventKind.DEAF, deaf=True))
        assert [chat for chat, _ in told] == [ADA]
        assert "changed what I hear in Lab" in told[0][1]


async def test_greetings_are_no_way_to_make_us_write_without_end() -> None:
    async with Place().open() as place:
        told = []
        for number in range(50):
            chat = Chat("memory", str(-100 - number), ChatKind.GROUP)
            told += await _pass(place, _passing(ChatEventKind.ADDED, chat=chat))
        assert len({chat for chat, _ in told if chat != ADA}) == GREETINGS.burst


async def test_that_little_is_heard_in_groups_is_said_to_the_admins_once() -> None:
    first = Place()
    account = ChatEvent(chat=Chat("memory", ""), what=ChatEventKind.DEAF)
    async with first.open() as place:
        told = await _pass(place, account)
        assert [chat for chat, _ in told] == [ADA]
        assert "Here I hear only commands" in told[0][1]
        assert await _pass(place, account) == []
    async with Place(first.store, first.latch, clock=first.clock).open() as place:
        assert await _pass(place, account) == []
        hearing = ChatEvent(chat=Chat("memory", ""), what=ChatEventKind.HEARING)
        assert await _pass(place, hearing) == []
        assert len(await _pass(place, account)) == 1


async def test_put_out_of_a_group_everything_for_it_ends_quietly() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("/archive on", **IN_LAB)
        await place.say("omni move 1 m", **IN_LAB)
        place.chat.gone.add("-5")
        await _pass(place, _passing(ChatEventKind.REMOVED))
        told = len(place.chat.told)
        place.robot("omni").finish()
        tried = place.chat.refused
        for _ in range(200):
            await place.clock.advance(1.0)
        assert place.acted() == 1
        assert place.chat.refused - tried <= TRIED_AT_MOST
        assert place.gateway.quiet
        later = list(place.chat.told)[told:]
        assert [t.outbound.chat.id for t in later] == [ADA], "its author is told elsewhere, once"
        told = len(place.chat.told)
        assert not place.gateway.archive.keeps(LAB)
        place.gateway._robot_says(place.robot("omni").profile, "hello")
        await place.quiet()
        assert len(place.chat.told) == told
        assert (await place.store.open()).unfinished == ()


async def test_what_a_robot_says_goes_no_longer_where_who_had_spoken_has_left() -> None:
    async with Place().open() as place:
        await place.say("use omni", account=BO, **IN_LAB)
        say, robot = place.gateway._robot_says, place.robot("omni").profile
        before = len(place.chat.told)
        say(robot, "one")
        await place.quiet()
        assert len(place.chat.told) == before + 1
        await _pass(place, _passing(ChatEventKind.LEFT))
        say(robot, "two")
        await place.quiet()
        assert len(place.chat.told) == before + 1
        await place.say("wave", account=BO, **IN_LAB)
        assert place.acted() == 0  # what they had chosen there is forgotten


async def test_what_was_chosen_and_what_is_kept_moves_with_a_group() -> None:
    async with Place().open() as place:
        await place.say("/archive on", **IN_LAB)
        await place.say("use omni", account=BO, **IN_LAB)
        await _pass(place, _passing(ChatEventKind.MOVED, new_id="-1005"))
        told = await place.say("wave", account=BO, chat="-1005", kind=ChatKind.GROUP)
        assert told == "omni: wave? People talk here, so it moves only if you confirm it.", (
            "nobody has spoken to it there"
        )
        await place.tap(*place.button("Do it"), account=BO)
        assert place.acted() == 1
        archive = place.gateway.archive
        assert archive.keeps(Chat("memory", "-1005", ChatKind.GROUP))
        assert not archive.keeps(LAB)
