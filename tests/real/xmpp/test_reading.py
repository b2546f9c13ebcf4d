"""What is heard on a real server, beyond the rules of all messengers."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element

import pytest

from rosic.errors import MessengerFault
from rosic.messengers.xmpp import XmppMessenger
from rosic.testing.messenger_harness import listening, until
from tests.real.xmpp.person import linked
from tests.real.xmpp.prosody import LOOPBACK
from tests.real.xmpp.stage import XmppStage, xmpp_stage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.real.xmpp.prosody import Prosody


@pytest.fixture
async def stage(prosody: Prosody) -> AsyncIterator[XmppStage]:
    async with xmpp_stage(prosody) as stage:
        assert isinstance(stage.messenger, XmppMessenger)
        stage.messenger.know_with(lambda _: True)
        yield stage


@asynccontextmanager
async def somebody_elses_server() -> AsyncIterator[tuple[int, list[bytes]]]:
    """Yield a port of this machine, and whatever is asked there."""
    asked: list[bytes] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        asked.append(await reader.readline())
        writer.close()

    server = await asyncio.start_server(serve, LOOPBACK, 0)
    async with server:
        yield server.sockets[0].getsockname()[1], asked


async def test_an_address_elsewhere_is_never_asked(stage: XmppStage) -> None:
    """An address in a message is anybody's; it could lead into our own network."""
    ada = stage.persons["ada"]
    async with somebody_elses_server() as (port, asked), listening(stage) as inbox:
        urls = (
            f"http://{LOOPBACK}:{port}/secret.yaml",
            f"http://{LOOPBACK}:{stage.server.http}@{LOOPBACK}:{port}/secret.yaml",
        )
        for url in urls:
            ada.say(stage.robots.user, url, linked(url))
        await until(stage, lambda: len(inbox.done) == len(urls), "a message was swallowed")
        for one in inbox.done:
            assert one.enclosed is not None
            assert (one.enclosed.name, one.enclosed.size) == ("secret.yaml", 0)
            with pytest.raises(MessengerFault, match="own server"):
                await anext(aiter(stage.messenger.fetch(one.enclosed)))
        assert asked == []


async def test_what_cannot_be_decrypted_is_said_to_its_author(stage: XmppStage) -> None:
    ada = stage.persons["ada"]
    async with listening(stage) as inbox:
        encrypted = Element("{eu.siacs.conversations.axolotl}encrypted")
        ada.say(stage.robots.user, "This is encrypted with OMEMO.", encrypted)
        await ada.reads("I cannot read OMEMO, not even a stop.")
        assert inbox.heard == []


async def test_malformed_stanzas_are_passed_over_and_confirmed(stage: XmppStage) -> None:
    """And what comes after them is heard: nobody makes ROSIC deaf, or is given again for ever."""
    ada = stage.persons["ada"]
    reply = Element("{urn:xmpp:reply:0}reply", id="x" * 10_000)
    stamp = Element("{urn:xmpp:delay}delay", stamp="∞")
    url = "http://[::1/x"
    async with listening(stage) as inbox:
        ada.say(stage.robots.user, "", Element("{urn:xmpp:reactions:0}reactions"))
        ada.say(stage.robots.user, "", Element("{urn:xmpp:receipts}received", id="1"))
        ada.say(stage.robots.user, "", *(Element("{urn:x}x") for _ in range(5_000)))
        ada.say(stage.robots.user, url, linked(url))
        ada.say(stage.robots.user, "a", reply, stamp)
        ada.say(stage.robots.user, "b" * 200_000)
        ada.say(stage.robots.user, "c", id_="y" * 10_000)
        ada.say(stage.robots.user, "stop")
        await until(stage, lambda: any(o.text == "stop" for o in inbox.done), "a stop was lost")
        await until(stage, lambda: any(o.text == "c" for o in inbox.done), "a message was lost")
        assert max(len(one.message) for one in inbox.done) <= 210
        give_up_s = asyncio.get_running_loop().time() + stage.patience_s
        while await stage.unconfirmed():
            assert asyncio.get_running_loop().time() < give_up_s, "it would be given again"


async def test_too_many_messages_take_no_more_memory_and_a_stop_overtakes(
    stage: XmppStage,
) -> None:
    ada = stage.persons["ada"]
    async with listening(stage) as inbox:
        inbox.gate.clear()
        for number in range(400):
            ada.say(stage.robots.user, f"omni move {number} cm")
        ada.say(stage.robots.user, "stop")
        await until(stage, lambda: any(one.text == "stop" for one in inbox.heard), "a stop waited")
        inbox.gate.set()
        await until(stage, lambda: len(inbox.done) >= 257, "a message was swallowed")
        ada.say(stage.robots.user, "status")
        await until(stage, lambda: inbox.done[-1].text == "status", "it is deaf now")
        assert len(inbox.done) <= 260
