"""A person at a client of XMPP: what they write, and what they see."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self
from urllib.parse import unquote, urlsplit
from xml.etree.ElementTree import Element, SubElement

import httpx
from slixmpp import ClientXMPP

from rosic.testing.messengers import SeenMessage
from tests.pace import pace
from tests.real.xmpp.prosody import LOOPBACK

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from slixmpp import Message

    from tests.real.xmpp.prosody import Account, Prosody

WITHIN_S: Final = 20.0
REPLACE: Final = "{urn:xmpp:message-correct:0}replace"
REPLY: Final = "{urn:xmpp:reply:0}reply"
OOB: Final = "{jabber:x:oob}"
REACTIONS: Final = "{urn:xmpp:reactions:0}"


class Seen(NamedTuple):
    """A message as its reader sees it now.

    Attributes:
        message: Its id, as its author gave it.
        where: The address that it came from: of an account, or of somebody in a room.
        url: Of the file that it is; empty for words.
        answers: Id of the message that it is shown beneath; empty for none.
    """

    message: str
    where: str
    text: str
    url: str
    answers: str = ""


class Person:
    """One account at one client, which speaks plainly to a server on this machine."""

    def __init__(self, server: Prosody, account: Account, *, device: str = "phone") -> None:
        self.user, self.account = account.user, account
        self.seen: dict[str, Seen] = {}
        self.reactions: list[tuple[str, str]] = []
        self._server = server
        plain = {"feature_mechanisms": {"unencrypted_scram": True}}
        client = self.client = ClientXMPP(
            f"{account.user}/{device}", account.password, plugin_config=plain
        )
        client.enable_direct_tls = False
        client.enable_starttls = False
        client.enable_plaintext = True
        for plugin in ("xep_0030", "xep_0363"):
            client.register_plugin(plugin)
        client.add_event_handler("message", self._took)
        self._changed = asyncio.Condition()

    async def __aenter__(self) -> Self:
        await self.sign_in()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.sign_out()

    async def sign_in(self) -> None:
        """Be there."""
        there = self.client.wait_until("session_start", WITHIN_S * pace())
        waiting = asyncio.ensure_future(there)
        await asyncio.sleep(0)
        self.client.connect(LOOPBACK, self._server.port)
        await waiting
        self.client.send_presence()

    async def sign_out(self) -> None:
        """Be away."""
        self.client.cancel_connection_attempt()
        if self.client.transport is not None:
            await self.client.disconnect(wait=1.0)
        if self.client._run_out_filters is not None:
            self.client._run_out_filters.cancel()
            await asyncio.gather(self.client._run_out_filters, return_exceptions=True)

    # ---- what a person does ----

    def say(self, to: str, text: str, *more: Element, kind: str = "chat", id_: str = "") -> str:
        """Write something, and return its id."""
        message = self.client.make_message(to, text or None)
        message["type"] = kind
        if id_:
            message["id"] = id_
        for one in more:
            message.xml.append(one)
        message.send()
        return str(message["id"])

    def correct(self, to: str, message: str, text: str, *, kind: str = "chat") -> str:
        """Change a message of one's own."""
        return self.say(to, text, Element(REPLACE, id=message), kind=kind)

    def react(self, to: str, message: str, *emoji: str, kind: str = "chat") -> str:
        """Put emoji beside a message, and take away those that are not among them."""
        put = Element(f"{REACTIONS}reactions", id=message)
        for one in emoji:
            SubElement(put, f"{REACTIONS}reaction").text = one
        return self.say(to, "", put, kind=kind)

    async def send_file(self, to: str, name: str, content: bytes) -> str:
        """Upload a file, and say where it is; return its address."""
        upload: Any = self.client.plugin["xep_0363"]
        service = await upload.find_upload_service()
        answer = await upload.request_slot(service["from"], name, len(content))
        slot = answer["http_upload_slot"]
        headers = {one["name"]: one["value"] for one in slot["put"]["headers"]}
        async with httpx.AsyncClient(trust_env=False) as http:
            put = await http.put(slot["put"]["url"], content=content, headers=headers)
        assert put.status_code == 201, put
        url = str(slot["get"]["url"])
        self.say(to, url, linked(url))
        return url

    def enter(self, room: str, nick: str) -> None:
        """Enter a room."""
        presence = self.client.make_presence(pto=f"{room}/{nick}")
        SubElement(presence.xml, "{http://jabber.org/protocol/muc}x")
        presence.send()

    async def arrived(self) -> None:
        """Wait until the server has taken everything that was said until now."""
        iq = self.client.make_iq_get(ito=self.client.boundjid.domain)
        SubElement(iq.xml, "{urn:xmpp:ping}ping")
        await iq.send(timeout=WITHIN_S * pace())

    # ---- what a person sees ----

    async def screen(self, where: str) -> list[SeenMessage]:
        """Return the words that came from there, each message as it is now."""
        await self.arrived()
        mine = (one for one in self.seen.values() if one.where.startswith(where) and not one.url)
        return [SeenMessage(one.message, one.text) for one in mine]

    async def files(self, where: str) -> list[tuple[str, bytes]]:
        """Return the files that came from there."""
        await self.arrived()
        urls = [one.url for one in self.seen.values() if one.where.startswith(where) and one.url]
        found = []
        async with httpx.AsyncClient(trust_env=False) as http:
            for url in urls:
                name = unquote(urlsplit(url).path.rpartition("/")[2])
                found.append((name, (await http.get(url)).content))
        return found

    async def until(self, condition: Callable[[], object], within_s: float = WITHIN_S) -> None:
        """Wait until a condition holds; an AssertionError says it never did."""
        give_up_s = time.monotonic() + within_s * pace()
        async with self._changed:
            while not condition():
                left_s = give_up_s - time.monotonic()
                assert left_s > 0, f"it did not happen in time; seen: {list(self.seen.values())}"
                try:
                    async with asyncio.timeout(min(left_s, 0.2)):
                        await self._changed.wait()
                except TimeoutError:
                    continue

    async def wait(self) -> None:
        """Wait until something comes, for a moment at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(0.2), self._changed:
                await self._changed.wait()

    async def reads(self, text: str) -> Seen:
        """Wait for a message with these words, and return it."""
        await self.until(lambda: any(text in one.text for one in self.seen.values()))
        return [one for one in self.seen.values() if text in one.text][-1]

    async def _took(self, message: Message) -> None:
        xml = message.xml
        changed = xml.find(REPLACE)
        key = message["id"] if changed is None else changed.get("id", "")
        url = xml.findtext(f"{OOB}x/{OOB}url", "")
        reply = xml.find(REPLY)
        answers = "" if reply is None else reply.get("id", "")
        if changed is not None and key in self.seen:
            answers = self.seen[key].answers
        self.seen[key] = Seen(key, str(message["from"]), str(message["body"]), url, answers)
        async with self._changed:
            self._changed.notify_all()


def linked(url: str) -> Element:
    """Return what says that a message is nothing but a file (XEP-0066)."""
    found = Element(f"{OOB}x")
    SubElement(found, f"{OOB}url").text = url
    return found
