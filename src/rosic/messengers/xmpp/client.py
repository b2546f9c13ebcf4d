"""One connection to a server, for as long as it takes: it is lost and comes back."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, Any, Final
from xml.etree.ElementTree import SubElement

from slixmpp import JID, ClientXMPP, Iq, Message, Presence
from slixmpp.plugins import register_plugin
from slixmpp.plugins.xep_0198 import XEP_0198
from slixmpp.plugins.xep_0198.stream_management import MAX_SEQ

from rosic.core.message import Chat, ChatKind
from rosic.core.time_units import SECOND_NS
from rosic.errors import ChatGone, ConfigurationError, MessengerFault
from rosic.messengers.xmpp import stanzas
from rosic.messengers.xmpp.files import UploadedFiles

if TYPE_CHECKING:
    from collections.abc import Callable
    from ssl import SSLContext

    from slixmpp.xmlstream import StanzaBase

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Alarm
    from rosic.messengers.xmpp.settings import XmppSettings

RESOURCE: Final = "rosic"
"""The same for every run: who signs in later with it puts out who came before."""
ASKS_EVERY_S: Final = 2.0
GONE_NS: Final = 15 * SECOND_NS
CONNECTS_WITHIN_S: Final = 30.0
ANSWERS_WITHIN_S: Final = 10.0
LONGEST_PAUSE_S: Final = 60.0
UNANSWERED: Final = 1_000
PARTS: Final = 100
NOBODY: Final = frozenset({"item-not-found", "gone", "forbidden", "not-allowed", "not-acceptable"})

log = logging.getLogger("rosic.messengers.xmpp")


class SettledAcks(XEP_0198):
    """Stream management (XEP-0198) that confirms a message once it is settled, not when it is read.

    What is not confirmed when a connection ends is given out again. A server speaks in order: what
    comes after its answer to a question was on its way no longer than since that was asked.
    """

    name = "rosic_0198"
    xmpp: Any

    def plugin_init(self) -> None:
        """Begin; see `XEP_0198`."""
        super().plugin_init()
        self._open: dict[int, StanzaBase] = {}
        self._settled: set[int] = set()
        self._asked: deque[int] = deque()
        self.answered_ns = 0

    def disconnected(self, event: object) -> None:
        """Forget what was not confirmed: it comes again."""
        super().disconnected(event)
        for kept in (self._open, self._settled, self._asked):
            kept.clear()

    def ask(self, now_ns: int) -> bool:
        """Ask what has arrived of all that was sent; return whether answers come in time."""
        if len(self._asked) < UNANSWERED:
            self._asked.append(now_ns)
            self.xmpp.send("<r xmlns='urn:xmpp:sm:3'/>")
        return now_ns - self._asked[0] < GONE_NS

    def settle(self, stanza: StanzaBase) -> None:
        """Confirm a stanza, once those before it are settled."""
        if self._open.get(id(stanza)) is not stanza:
            return
        self._settled.add(id(stanza))
        before = self.handled
        while self._open and (first := next(iter(self._open))) in self._settled:
            del self._open[first]
            self._settled.discard(first)
            self.handled = (self.handled + 1) % MAX_SEQ
        if self.handled != before and isinstance(stanza, Message):
            self.send_ack()

    def _handle_incoming(self, stanza: StanzaBase) -> StanzaBase | None:
        if self.enabled_in and isinstance(stanza, (Message, Presence, Iq)):
            self._open[id(stanza)] = stanza
        if isinstance(stanza, (Message, Presence)):
            self.xmpp.hear(stanza)
            return None  # the library would remember everybody who was ever there
        self.settle(stanza)
        return stanza

    def _handle_ack(self, ack: StanzaBase) -> None:
        super()._handle_ack(ack)
        if ack.name == "a" and self._asked:
            self.answered_ns = self._asked.popleft()


register_plugin(SettledAcks)


class XmppClient(ClientXMPP):
    """Signs in, comes back, and says what is heard.

    Args:
        heard: Called with every message and presence, on the event loop; whoever it is settles it.
        up: Called when there is a stream; with whether it goes on where the last was cut.
    """

    def __init__(
        self,
        settings: XmppSettings,
        trust: SSLContext,
        clock: Clock,
        heard: Callable[[StanzaBase], None],
        up: Callable[[bool], None],
    ) -> None:
        plain = dict.fromkeys(("unencrypted_scram", "unencrypted_plain"), settings.is_local)
        super().__init__(
            JID(f"{settings.user}/{RESOURCE}"),
            settings.password.reveal(),
            ssl_context=trust,
            plugin_config={"feature_mechanisms": plain, "rosic_0198": {"window": 2**31}},
        )
        self._clock = clock
        self._where = (settings.host, settings.port) if settings.host else ()
        self._heard, self._up = heard, up
        self._news: asyncio.Queue[str] = asyncio.Queue()
        self._waiting: dict[str, asyncio.Future[None]] = {}
        self._refusal = ""
        self._pause_s = 1.0
        self._twice = self._ended = self.is_up = False
        self.enable_direct_tls = not settings.host
        for plugin in ("xep_0030", "xep_0363", "rosic_0198"):
            self.register_plugin(plugin)
        found: Any = self.plugin
        self.acks: SettledAcks = found["rosic_0198"]
        self.files = UploadedFiles(found["xep_0363"], trust, is_local=settings.is_local)
        then: Callable[[Any], None]
        for event, then in {
            "stanza_acked": self._delivered,
            "stream_negotiated": self._negotiated,
            "session_resumed": lambda _: self._news.put_nowait("resumed"),
            "disconnected": self._lost,
            "reconnect_delay": self._lost,
            "failed_auth": self._refused,
            "no_auth": self._refused,
            "stream_error": self._failed,
        }.items():
            self.add_event_handler(event, then)

    # ---- the connection ----

    async def stay(self, alarm: Alarm) -> None:
        """Be signed in, until cancelled; tell when another signs in with our name.

        Raises:
            ConfigurationError: The server does not let us in, and never did.
            MessengerFault: It did, and does no longer.
        """
        refused: type[ConfigurationError | MessengerFault] = ConfigurationError
        try:
            while True:
                if await self._signed_in():
                    self._pause_s, refused = 1.0, MessengerFault
                    await self._until_lost()
                if self._twice:
                    alarm(MessengerFault(f"Somebody else signed in as {self.boundjid.full}."))
                    self._twice, self._pause_s = False, LONGEST_PAUSE_S
                if self._refusal:
                    raise refused(self._refusal)
                await self._clock.sleep(self._pause_s)
                self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)
        finally:
            self._ended, self.is_up = True, False

    async def close(self) -> None:
        """Sign out; leave nothing running. What was not confirmed is given out again."""
        self.cancel_connection_attempt()
        if self.transport is not None:
            await self.disconnect(wait=1.0, ignore_send_queue=True)
            self.abort()
        if self._run_out_filters is not None:
            self._run_out_filters.cancel()
            await asyncio.gather(self._run_out_filters, return_exceptions=True)

    async def _signed_in(self) -> bool:
        self._news = asyncio.Queue()
        news = "lost"
        self.connect(*self._where)
        try:
            async with asyncio.timeout(CONNECTS_WITHIN_S):
                news = await self._news.get()
        except TimeoutError:
            self.cancel_connection_attempt()
            self.abort()
        self.is_up = news != "lost"
        if self.is_up:
            self._refusal = ""
            self._up(news == "resumed")
        return self.is_up

    async def _until_lost(self) -> None:
        """Ask now and then whether the server is there; give it up when it does not answer."""
        while self.is_up:
            if not self.acks.ask(self._clock.monotonic_ns()):
                self.abort()
            await self._clock.sleep(ASKS_EVERY_S)

    # ---- what the library tells ----

    def hear(self, stanza: StanzaBase) -> None:
        """Pass on a message or a presence. Never raises."""
        del stanza.xml[PARTS:]  # however many follow, looking for what counts takes no longer
        try:
            if stanza["type"] == "error":
                self._not_delivered(stanza)
            if not self._ended:
                self._heard(stanza)
        except Exception:
            log.exception("%s: something malformed was passed over", self.boundjid.bare)
            self.acks.settle(stanza)

    def _negotiated(self, _: object) -> None:
        if not self.acks.enabled_in:
            self._refusal = f"The server of {self.boundjid.bare} confirms nothing (XEP-0198)."
            self.abort()
        self._news.put_nowait("new")

    def _lost(self, why: object) -> None:
        self.is_up = False
        self.cancel_connection_attempt()
        self._news.put_nowait("lost")
        log.info("%s: no connection: %s", self.boundjid.bare, why)

    def _refused(self, failure: StanzaBase) -> None:
        if not failure:
            self._refusal = f"The server of {self.boundjid.bare} is reached without encryption."
        elif failure["condition"] != "temporary-auth-failure":
            self._refusal = (
                f"The server of {self.boundjid.bare} does not accept its user and password."
            )

    def _failed(self, error: StanzaBase) -> None:
        self._twice = error["condition"] == "conflict"

    # ---- sending ----

    def enter(self, room: str, nick: str) -> None:
        """Enter a room, asking for nothing of what was said there before."""
        presence = self.make_presence(pto=f"{room}/{nick}")
        joining = SubElement(presence.xml, "{http://jabber.org/protocol/muc}x")
        SubElement(joining, "{http://jabber.org/protocol/muc}history", maxstanzas="0")
        presence.send()

    def compose(
        self, chat: Chat, text: str = "", *, url: str = "", answers: str = "", replaces: str = ""
    ) -> Message:
        """Return a message: a text, or the address of a file."""
        made = self.make_message(chat.id, stanzas.speakable(url or text))
        made["type"] = "groupchat" if chat.kind is ChatKind.GROUP else "chat"
        if url:
            where = SubElement(SubElement(made.xml, f"{stanzas.OOB}x"), f"{stanzas.OOB}url")
            where.text = url
        if answers:
            about = stanzas.name_for(answers, chat)
            SubElement(made.xml, stanzas.REPLY, id=about, to=chat.id)
        if replaces:
            SubElement(made.xml, stanzas.REPLACE, id=replaces)
        return made

    async def deliver(self, *stanzas: Message) -> None:
        """Send, in order, and return once the server has all of it.

        Raises:
            ChatGone: There is nobody.
            MessengerFault: Not sent; or, when the connection broke meanwhile, perhaps sent.
        """
        if not self.is_up:
            raise MessengerFault(f"The messenger {self.boundjid.bare} is not connected.")
        waiting: dict[str, asyncio.Future[None]] = {one["id"]: asyncio.Future() for one in stanzas}
        self._waiting |= waiting
        try:
            for one in stanzas:
                one.send()
            self.acks.ask(self._clock.monotonic_ns())
            async with asyncio.timeout(ANSWERS_WITHIN_S):
                await asyncio.gather(*waiting.values())
        except TimeoutError:
            raise MessengerFault("The server did not answer; perhaps it was sent.") from None
        finally:
            for key in waiting:
                self._waiting.pop(key).cancel()

    def _delivered(self, stanza: StanzaBase) -> None:
        future = self._waiting.get(stanza["id"])
        if future is not None and not future.done():
            future.set_result(None)

    def _not_delivered(self, message: StanzaBase) -> None:
        future = self._waiting.get(message["id"])
        condition = str(message["error"]["condition"])
        log.warning("%s does not take it: %s", message["from"].bare, condition)
        if future is not None and not future.done():
            fault = ChatGone if condition in NOBODY else MessengerFault
            future.set_exception(fault(f"It was not delivered: {condition}."))
