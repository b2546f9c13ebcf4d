"""The XMPP messenger: one account, in private chats and in rooms that hide nobody's address."""

from __future__ import annotations

from collections import OrderedDict
from functools import partial
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from msgspec.structs import replace
from slixmpp import Message

from rosic.core.i18n import said
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Reaction
from rosic.errors import ChatGone, MessengerFault
from rosic.messengers.numbered_buttons import LATE_NS
from rosic.messengers.plain_messenger import PlainMessenger, read_settings, remember
from rosic.messengers.xmpp import stanzas
from rosic.messengers.xmpp.client import XmppClient
from rosic.messengers.xmpp.files import FILE_BYTES
from rosic.messengers.xmpp.rooms import RoomOccupants
from rosic.messengers.xmpp.settings import ACCOUNT, XmppSettings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping, Sequence
    from xml.etree.ElementTree import Element

    from slixmpp.xmlstream import StanzaBase

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.core.message import Inbound, IncomingFile, Outbound
    from rosic.core.secret import Secret

HIDES_ADDRESSES: Final = said(
    "This room hides who is who, so I follow nothing here. Have it show addresses to everybody."
)
CANNOT_READ: Final = said(
    "I cannot read OMEMO, not even a stop. Turn it off in this chat, and write that once more."
)


class XmppMessenger(PlainMessenger):
    """A messenger over XMPP. Something is said only while it runs."""

    platform = stanzas.PLATFORM
    edits = True
    file_bytes = fetch_bytes = FILE_BYTES
    text_bytes = 8_000
    """Servers take stanzas of 10,000 bytes (RFC 6120, section 13.12), and need not take more."""

    def __init__(self, name: str, settings: XmppSettings, clock: Clock) -> None:
        super().__init__(name, clock)
        self._settings, self.nick = settings, settings.nick
        self._rooms = RoomOccupants(settings)
        self._called: OrderedDict[str, str] = OrderedDict()
        self._client: XmppClient | None = None
        self._since_ns = self._up_ns = 0

    @property
    def account(self) -> str:
        """The account's address; see ``contracts.messenger``."""
        return self._settings.user

    handle = account

    @staticmethod
    def is_account(account: str) -> bool:
        """Whether it is an address without a device, as servers write it."""
        return ACCOUNT.fullmatch(account) is not None

    def invite_link(self, code: Secret) -> str:
        """Return the link that opens a chat with a code in it (XEP-0147)."""
        return f"xmpp:{self.account}?message;body={quote(f'join {code.reveal()}')}"

    def is_connected(self) -> bool:
        """Return whether the server answers us; see ``contracts.messenger``."""
        return self._client is not None and self._client.is_up

    def catching_up(self) -> bool:
        """Return whether backlog may still come: until the server has answered after signing in."""
        return not self.is_connected() or self._live.acks.answered_ns < self._up_ns

    # ---- listening ----

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled; see ``contracts.messenger``.

        Raises:
            ConfigurationError: The server does not let us in; nothing was received.
            MessengerFault: It runs already, or the server lets us in no longer.
        """
        trust = self._settings.trust()
        async with self.listening(partial(self._measured, receive)) as self._tasks:
            client = XmppClient(self._settings, trust, self._clock, self._heard, self._is_up)
            self._client = client
            try:
                await client.stay(self._alarm)
            finally:
                self._client = None
                await client.close()

    def _is_up(self, resumed: bool) -> None:
        if not resumed or self._age_ns():
            self._since_ns = self._clock.wall_ns()
        self._up_ns = self._clock.monotonic_ns()
        if not resumed:
            self._rooms.left()
            self._live.send_presence()
            for room in self._settings.rooms:
                self._live.enter(room, self.nick)
        self.began()

    def _age_ns(self) -> int:
        """Return for how long at most something was on its way from the server; 0: not long."""
        age_ns = self._clock.monotonic_ns() - self._live.acks.answered_ns
        return age_ns if age_ns > LATE_NS else 0

    def _heard(self, stanza: StanzaBase) -> None:
        """Follow a message or a presence; what is not for us is confirmed at once."""
        settle, xml = partial(self._live.acks.settle, stanza), stanza.xml
        who = stanza["from"].bare
        inbound = self._read(xml) if isinstance(stanza, Message) else None
        if inbound is not None and self._is_taken(xml, inbound, settle):
            return
        if who in self._rooms and not xml.findtext(stanzas.BODY):
            self._rooms.happened(xml, self._refuse, self._passed)
        elif stanza["type"] == "subscribe" and self._known(Address(self.platform, who)):
            self._live.send_presence(pto=who, ptype="subscribed")
        settle()

    def _read(self, xml: Element) -> Inbound | None:
        """Return what somebody wrote; None where nobody can be named for it."""
        where, _, nick = xml.get("from", "").partition("/")
        if xml.get("type") == "groupchat":
            who, kind = self._rooms.who(where, nick), ChatKind.GROUP
            if who == self.account and (called := stanzas.archived(xml, where)):
                remember(self._called, called, stanzas.meant(xml))
            who = "" if stanzas.is_history(xml, where) else who
        else:
            who, kind = where if stanzas.is_private(xml) else "", ChatKind.PRIVATE
        if who == self.account or not self.is_account(who):
            return None
        now_ns = self._clock.wall_ns()
        moment = stanzas.Moment(now_ns, now_ns - self._age_ns(), self._since_ns)
        return stanzas.read(xml, who, Chat(self.platform, where, kind), moment)

    def _is_taken(self, xml: Element, inbound: Inbound, settle: Callable[[], None]) -> bool:
        """Hand over what somebody said or chose; whether there was something, to be settled."""
        about, signs = stanzas.reacted(xml)
        about = self._called.get(about or inbound.answers, about or inbound.answers)
        inbound = replace(inbound, answers=about, answers_us=self.is_ours(about))
        if stanzas.is_encrypted(xml):
            if self._known(inbound.sender):
                self._tasks.create_task(self.answer_tap(inbound, CANNOT_READ))
            return False
        if signs or inbound.enclosed or inbound.text.strip():
            if self.take(inbound, settle, signs):
                return True
            who = inbound.sender
            self._reacted(Reaction(chat=inbound.chat, message=about, who=who, emoji=signs))
        return False

    async def _measured(self, receive: Receive, inbound: Inbound) -> None:
        if inbound.enclosed is not None:
            size = await self._live.files.size(inbound.enclosed.id)
            inbound = replace(inbound, enclosed=replace(inbound.enclosed, size=size))
        await receive(inbound)

    def _refuse(self, room: str) -> None:
        self._live.compose(Chat(self.platform, room, ChatKind.GROUP), HIDES_ADDRESSES).send()
        self._live.send_presence(pto=f"{room}/{self.nick}", ptype="unavailable")

    # ---- speaking ----

    async def deliver(self, outbound: Outbound, texts: Sequence[str], *, replaces: str = "") -> str:
        """Say something; see `PlainMessenger.deliver`.

        Raises:
            ChatGone: There is nobody, or we are not in that room.
            MessengerFault: Not sent; or, when the connection broke before the answer, perhaps sent.
        """
        chat, made = outbound.chat, []
        if chat.kind is ChatKind.GROUP and not self._rooms.is_in(chat.id):
            raise ChatGone(said("I am not in that room, or not any more."))
        if outbound.attachment is not None and not replaces:
            url = await self._live.files.put(outbound.attachment)
            made.append(self._live.compose(chat, url=url))
        about = {"answers": outbound.reply_to, "replaces": replaces}
        made += [self._live.compose(chat, text, **about) for text in texts]
        await self._live.deliver(*made)
        return str(made[-1]["id"])

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file that somebody sent; see ``contracts.messenger``."""
        return self._live.files.fetch(enclosure)

    @property
    def _live(self) -> XmppClient:
        if self._client is None:
            raise MessengerFault(f"The messenger {self.name} is not connected. Nothing was sent.")
        return self._client


def xmpp_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> XmppMessenger:
    """Make it from its table in the configuration. Nothing is opened.

    Raises:
        ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
    """
    return XmppMessenger(name, read_settings(name, settings, XmppSettings), clock)
