"""What becomes of the connection to a server: who is let in, and what a cut costs."""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Chat, Outbound
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.xmpp import xmpp_messenger
from rosic.system import SystemClock
from rosic.testing.messenger_harness import HarnessInbox, listening, until
from tests.pace import pace
from tests.real.matrix.relay import Relay
from tests.real.xmpp.person import Person
from tests.real.xmpp.prosody import LOOPBACK, Prosody
from tests.real.xmpp.stage import XmppStage, table, xmpp_stage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

NOT_LOOPBACK_BY_NAME = "127.1"
"""Leads to this machine, and does not look like it: encryption is asked for."""


@pytest.fixture
async def stage(prosody: Prosody) -> AsyncIterator[XmppStage]:
    async with xmpp_stage(prosody) as stage:
        yield stage


@asynccontextmanager
async def by_wire(stage: XmppStage) -> AsyncIterator[tuple[Relay, HarnessInbox]]:
    """Let the messenger listen through a wire that can be cut."""
    async with Relay(f"http://{LOOPBACK}:{stage.server.port}").running() as relay:
        port = int(relay.url.rpartition(":")[2])
        settings = table(stage.server, stage.robots) | {"port": port}
        stage.messenger = xmpp_messenger("lab", settings, SystemClock())
        async with listening(stage) as inbox:
            await stage.messenger.send(Outbound(chat=stage.chat("ada"), text="omni: here"))
            yield relay, inbox


async def test_a_wrong_password_ends_the_start_with_a_sentence(
    prosody: Prosody, caplog: pytest.LogCaptureFixture
) -> None:
    """And no log shows it."""
    caplog.set_level(logging.INFO)
    robots = prosody.create_account("robots")
    settings = table(prosody, robots) | {"password": "not-the-password"}
    messenger = xmpp_messenger("lab", settings, SystemClock())
    with pytest.raises(ConfigurationError, match="does not accept its user and password"):
        await asyncio.wait_for(messenger.run(HarnessInbox().receive), 20 * pace())
    assert "not-the-password" not in caplog.text


async def test_without_encryption_nobody_signs_in_but_on_this_machine(prosody: Prosody) -> None:
    robots = prosody.create_account("robots")
    settings = table(prosody, robots) | {"host": NOT_LOOPBACK_BY_NAME}
    messenger = xmpp_messenger("lab", settings, SystemClock())
    with pytest.raises(ConfigurationError, match="without encryption"):
        await asyncio.wait_for(messenger.run(HarnessInbox().receive), 20 * pace())


async def test_a_certificate_has_to_hold(tmp_path: Path) -> None:
    with Prosody(tmp_path, tls=True) as server:
        robots = server.create_account("robots")
        trusting = table(server, robots, ca=str(server.certificate))
        for settings, connects in ((trusting, True), (table(server, robots), False)):
            messenger = xmpp_messenger(
                "lab", settings | {"host": NOT_LOOPBACK_BY_NAME}, SystemClock()
            )
            running = asyncio.create_task(messenger.run(HarnessInbox().receive))
            await asyncio.wait([running], timeout=3.0 * pace())
            assert messenger.is_connected() is connects
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def test_a_stream_that_was_cut_goes_on_where_it_was(stage: XmppStage) -> None:
    """What was said meanwhile comes once, in order, and is not fresh if it took long."""
    async with by_wire(stage) as (relay, inbox):
        await stage.write("ada", "omni move 1 m")
        await until(stage, lambda: len(inbox.done) == 1, "a message was swallowed")
        async with relay.outage():
            await stage.write("ada", "omni move 2 m")
            await stage.write("ada", "omni move 3 m")
            await stage.persons["ada"].arrived()
        await until(stage, lambda: len(inbox.done) >= 3, "a message was lost with the stream")
        await stage.write("ada", "status")
        await until(stage, lambda: inbox.done[-1].text == "status", "a message was swallowed")
        moved = [f"omni move {number} m" for number in (1, 2, 3)]
        assert inbox.texts(stage.chat("ada")) == [*moved, "status"]


async def test_after_a_restart_of_the_server_all_goes_on(stage: XmppStage) -> None:
    """What was said while we were away comes as backlog, with the server's time."""
    person = stage.persons["ada"]
    async with listening(stage) as inbox:
        await stage.write("ada", "status")
        await until(stage, lambda: len(inbox.done) == 1, "a message was swallowed")
        await person.sign_out()
        stage.server.kill()
        stage.server.start()
        async with Person(stage.server, person.account) as again:
            again.say(stage.robots.user, "stop")
            await until(stage, lambda: len(inbox.done) == 2, "it did not come back")
            assert inbox.done[-1].text == "stop"
            chat = stage.chat("ada")
            await stage.messenger.send(Outbound(chat=chat, text="omni: at rest"))
            await again.reads("omni: at rest")


async def test_what_waited_for_us_is_backlog(stage: XmppStage) -> None:
    await stage.write("ada", "omni move 1 m")
    await stage.persons["ada"].arrived()
    await asyncio.sleep(1.1)  # the stamps of the server are of whole seconds
    async with listening(stage) as inbox:
        await until(stage, lambda: bool(inbox.done), "a message was swallowed")
        [one] = inbox.done
        assert one.sent_ns < one.listening_since_ns <= one.received_ns


async def test_whoever_signs_in_with_our_name_is_told_of(stage: XmppStage) -> None:
    faults: list[MessengerFault] = []
    first = xmpp_messenger("lab", table(stage.server, stage.robots), SystemClock())
    first.alarm_with(faults.append)
    stage.messenger = first
    async with listening(stage):
        await first.send(Outbound(chat=stage.chat("ada"), text="omni: here"))
        thief = Person(stage.server, stage.robots, device="rosic")
        async with thief:
            await until(stage, lambda: bool(faults), "nobody was told")
            assert not first.is_connected()
    assert "Somebody else signed in" in str(faults[0])


async def test_a_chat_with_nobody_is_said_to_be_gone(stage: XmppStage) -> None:
    async with listening(stage):
        nobody = Chat("xmpp", "nobody@rosic.test")
        with pytest.raises(MessengerFault):
            await stage.messenger.send(Outbound(chat=nobody, text="omni: here"))
