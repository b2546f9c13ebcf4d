"""Rooms on a real server: who somebody is there, and where ROSIC does not take part."""

from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple
from xml.etree.ElementTree import Element

import pytest

from rosic.core.message import Button, Chat, ChatEvent, ChatEventKind, ChatKind, Outbound, Reaction
from rosic.errors import ChatGone
from rosic.messengers.xmpp import XmppMessenger, xmpp_messenger
from rosic.system import SystemClock
from rosic.testing.messenger_harness import HarnessInbox, listening, until
from tests.real.xmpp.person import Person
from tests.real.xmpp.prosody import ROOMS, Prosody
from tests.real.xmpp.stage import XmppStage, table

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

STOP = Button("Stop", "stop", "nonce-of-stop")
GO = Button("Go", "omni move 1 m", "nonce-of-go")


class Place(NamedTuple):
    """A room with Ada and Bob in it, and the account of the robots, which listens."""

    stage: XmppStage
    inbox: HarnessInbox
    messenger: XmppMessenger
    room: str
    passed: list[ChatEvent]
    reactions: list[Reaction]

    @property
    def chat(self) -> Chat:
        return Chat("xmpp", self.room, ChatKind.GROUP)

    def say(self, person: str, text: str) -> str:
        return self.stage.persons[person].say(self.room, text, kind="groupchat")

    async def hears(self, text: str) -> None:
        await until(
            self.stage, lambda: any(one.text == text for one in self.inbox.done), f"no {text}"
        )


@asynccontextmanager
async def place(server: Prosody, name: str) -> AsyncIterator[Place]:
    room = f"{name}@{ROOMS}"
    async with AsyncExitStack() as stack:
        persons = {who: Person(server, server.create_account(who)) for who in ("ada", "bob")}
        for nick, person in persons.items():
            await stack.enter_async_context(person)
            person.enter(room, nick)
            await person.arrived()
        robots = server.create_account("robots")
        stage = XmppStage(server, robots, persons)
        messenger = xmpp_messenger("lab", table(server, robots, rooms=[room]), SystemClock())
        passed: list[ChatEvent] = []
        reactions: list[Reaction] = []
        messenger.watch_chats(passed.append)
        messenger.watch_reactions(reactions.append)
        messenger.know_with(lambda _: True)
        stage.messenger = messenger
        async with listening(stage) as inbox:
            yield Place(stage, inbox, messenger, room, passed, reactions)


async def _until_in(lab: Place) -> None:
    """Wait until ROSIC is in the room: then what it says arrives."""
    sent = Outbound(chat=lab.chat, text="omni: here")
    for _ in range(200):
        try:
            await lab.messenger.send(sent)
        except ChatGone:
            await lab.stage.persons["ada"].arrived()
        else:
            return
    raise AssertionError("it never was in the room")


async def test_who_somebody_is_is_their_account_and_never_their_nickname(prosody: Prosody) -> None:
    async with place(prosody, "swap") as lab:
        await _until_in(lab)
        ada, bob = lab.stage.persons["ada"], lab.stage.persons["bob"]
        lab.say("ada", "robots: status")
        await lab.hears("status")
        # Bob takes the name that Ada had.
        ada.enter(lab.room, "somebody else")
        await ada.arrived()
        bob.enter(lab.room, "ada")
        await bob.arrived()
        lab.say("bob", "omni move 1 m")
        await lab.hears("omni move 1 m")
        first, second = lab.inbox.done
        assert (first.sender.account, first.shown_as, first.addressed) == (ada.user, "ada", True)
        assert (second.sender.account, second.shown_as) == (bob.user, "ada")
        assert {one.chat for one in lab.inbox.done} == {lab.chat}


async def test_in_a_room_that_hides_addresses_nothing_is_followed(tmp_path: Path) -> None:
    with Prosody(tmp_path, public=False) as server:
        async with place(server, "hidden") as lab:
            await lab.stage.persons["ada"].reads("This room hides who is who")
            lab.say("ada", "omni move 1 m")
            await lab.stage.persons["ada"].arrived()
            await lab.stage.write("ada", "status")
            await lab.hears("status")
            assert lab.inbox.texts(lab.chat) == []
            with pytest.raises(ChatGone):
                await lab.messenger.send(Outbound(chat=lab.chat, text="omni: here"))


async def test_what_a_room_says_to_us_alone_is_nobodys(prosody: Prosody) -> None:
    """A private message by way of a room has the room's address: any occupant could have it."""
    async with place(prosody, "beside") as lab:
        await _until_in(lab)
        ada = lab.stage.persons["ada"]
        ada.say(f"{lab.room}/robots", "join 123", Element("{http://jabber.org/protocol/muc#user}x"))
        ada.say(f"{lab.room}/robots", "join 456")
        await ada.arrived()
        lab.say("ada", "status")
        await lab.hears("status")
        assert [one.text for one in lab.inbox.done] == ["status"]


async def test_buttons_are_chosen_by_number_by_reply_and_by_reaction(prosody: Prosody) -> None:
    async with place(prosody, "buttons") as lab:
        await _until_in(lab)
        ada = lab.stage.persons["ada"]
        offer = Outbound(chat=lab.chat, text="omni: move 1 m?", buttons=((GO,), (STOP,)))
        message = await lab.messenger.send(offer)
        seen = await ada.reads("omni: move 1 m?")
        assert seen.text == "omni: move 1 m?\n\n1. Go\n2. Stop"
        lab.say("ada", "1")
        reply = Element("{urn:xmpp:reply:0}reply", id=message, to=f"{lab.room}/robots")
        ada.say(lab.room, "> omni: move 1 m?\n2", reply, kind="groupchat")
        ada.react(lab.room, message, "1️⃣", kind="groupchat")
        ada.react(lab.room, message, "👍", kind="groupchat")
        await until(lab.stage, lambda: len(lab.reactions) == 1, "a reaction was swallowed")
        await until(lab.stage, lambda: len(lab.inbox.done) == 3, "a tap was swallowed")
        taps = [(one.nonce, one.under, one.text) for one in lab.inbox.done]
        expected = [(one.nonce, message, "") for one in (GO, STOP, GO)]
        assert sorted(taps) == sorted(expected)
        assert lab.reactions[0].emoji == ("👍",)
        assert lab.reactions[0].who is not None
        assert lab.reactions[0].who.account == ada.user


async def test_being_put_out_is_told_and_nothing_is_said_there_any_more(prosody: Prosody) -> None:
    async with place(prosody, "out") as lab:
        await _until_in(lab)
        ada = lab.stage.persons["ada"]
        iq = ada.client.make_iq_set(ito=lab.room)
        query = Element("{http://jabber.org/protocol/muc#admin}query")
        item = Element("{http://jabber.org/protocol/muc#admin}item", nick="robots", role="none")
        query.append(item)
        iq.xml.append(query)
        await iq.send()
        removed = ChatEvent(chat=lab.chat, what=ChatEventKind.REMOVED)
        await until(lab.stage, lambda: removed in lab.passed, "nobody was told")
        with pytest.raises(ChatGone):
            await lab.messenger.send(Outbound(chat=lab.chat, text="omni: here"))
