"""What messengers share on whose platform people read and write texts, and have no buttons.

Whoever writes an adapter for such a platform derives from `PlainMessenger` and adds what only the
platform knows: docs/howto/add-a-messenger.md.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final, TypeVar

import msgspec
from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.language import is_urgent
from rosic.core.message import Chat, ChatEvent, ChatEventKind, MessageValidity, Outbound
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError, MessageGone, MessengerFault
from rosic.messengers.chat_lanes import ChatLanes
from rosic.messengers.numbered_buttons import NumberedButtons, tapped

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Alarm, Knows, Passed, Reacted, Receive
    from rosic.core.identity import Address
    from rosic.core.message import Inbound, IncomingFile
    from rosic.messengers.numbered_buttons import OfferedButton

SettingsT = TypeVar("SettingsT", bound=msgspec.Struct)

REMEMBERED: Final = 4_096
READY_WITHIN_S: Final = 15.0

log = logging.getLogger("rosic.messengers")


class PlainMessenger:
    """Implements `contracts.messenger.Messenger`, but for `run` and `deliver`.

    Buttons are numbers beneath the text. What is remembered is bounded: the oldest is forgotten.

    Attributes:
        text_bytes: How long one message may be; longer texts are sent in several.
        nick: What it is called in groups; empty: nothing.
    """

    platform = ""
    assurance = "provider-readable"
    edits = False
    pins = False
    file_bytes = 0
    fetch_bytes = 0
    text_bytes = 4_000
    nick = ""

    def __init__(self, name: str, clock: Clock) -> None:
        self.name = name
        self._ready = asyncio.Event()
        self._clock = clock
        self._known: Knows = _anybody
        self._alarm: Alarm = _nobody_is_told
        self._passed: Passed = _nobody_is_told
        self._reacted: Reacted = _nobody_is_told
        self._buttons = NumberedButtons(clock)
        self._sent: OrderedDict[str, str] = OrderedDict()
        self._first: OrderedDict[tuple[str, str], int] = OrderedDict()
        self._lanes: ChatLanes | None = None

    # ---- what an adapter writes ----

    async def run(self, receive: Receive) -> None:
        """Listen inside of `listening`, and `take` each message; see ``contracts.messenger``."""
        raise NotImplementedError

    async def deliver(self, outbound: Outbound, texts: Sequence[str], *, replaces: str = "") -> str:
        """Say something, and return the platform's id of the last message that it took.

        Args:
            outbound: Where, beneath which message, and with which file.
            texts: What, in so many messages, as plain text. None: the file alone.
            replaces: The message of ours that is to look like this; only where ``edits`` is true.

        Raises:
            ChatGone: Not sent, and nothing more can be said there.
            MessengerFault: Not sent; trying again may succeed.
        """
        raise NotImplementedError

    # ---- listening ----

    def know_with(self, known: Knows) -> None:
        """Give people known here room before strangers; see ``contracts.messenger``."""
        self._known = known

    def alarm_with(self, alarm: Alarm) -> None:
        """Have somebody told when the account is used elsewhere; see ``contracts.messenger``."""
        self._alarm = alarm

    def watch_chats(self, passed: Passed) -> None:
        """Have somebody told what happens to groups; see ``contracts.messenger``."""
        self._passed = passed

    def watch_reactions(self, reacted: Reacted) -> None:
        """Have somebody told of reactions; see ``contracts.messenger``."""
        self._reacted = reacted

    @asynccontextmanager
    async def listening(self, receive: Receive) -> AsyncIterator[asyncio.TaskGroup]:
        """Hand over what is taken inside; when it is left, or cancelled, nothing goes on.

        Raises:
            MessengerFault: It listens already.
        """
        if self._lanes is not None:
            raise MessengerFault(f"The messenger {self.name} is listening already.")
        self._passed(ChatEvent(chat=Chat(self.platform, ""), what=ChatEventKind.HEARING))
        try:
            async with asyncio.TaskGroup() as tasks:
                self._lanes = ChatLanes(receive, tasks)
                yield tasks
        except BaseExceptionGroup as several:
            raise several.exceptions[0] from None
        finally:
            self._lanes = None
            self._ready.clear()

    def began(self) -> None:
        """Say what waits to be said, for a while, until this was called: the platform answers."""
        self._ready.set()
        log.info("%s: listening", self.name)

    def take(
        self, inbound: Inbound, settled: Callable[[], None], signs: Iterable[str] = ()
    ) -> bool:
        """Hand a message over, as a tap where it is the number of a button.

        A stop overtakes all others. A message that comes again was sent when it was the first time.

        Args:
            inbound: As the platform gave it.
            settled: Called once it may be confirmed to the platform; at once where too many wait.
            signs: What somebody put beside the message that it answers, instead of words.

        Returns:
            False for signs that are the number of no button: nothing was done with them.
        """
        key = inbound.chat.id, inbound.message
        first_ns = min(inbound.sent_ns, self._first.get(key, inbound.sent_ns))
        remember(self._first, key, first_ns)
        inbound = replace(inbound, sent_ns=first_ns)
        beneath = inbound.answers if inbound.answers_us or signs else ""
        chosen = self._buttons.chosen(inbound.chat.id, signs or (inbound.text,), beneath)
        if inbound.standing is not MessageValidity.FRESH:
            chosen = None
        if signs and chosen is None:
            return False
        self._hand_over(self._addressed(inbound), settled, chosen)
        return True

    def _addressed(self, inbound: Inbound) -> Inbound:
        """Return a message without our name, where it begins with that."""
        text, name = inbound.text, inbound.text[: len(self.nick)]
        rest = text[len(self.nick) :]
        named = (
            self.nick and name.casefold() == self.nick.casefold() and rest[:1] in {":", ",", " "}
        )
        if not named or not (said_to_us := rest.lstrip(":, ")):
            return replace(inbound, addressed=inbound.addressed or inbound.answers_us)
        return replace(inbound, text=said_to_us, written=text, addressed=True)

    def _hand_over(
        self, inbound: Inbound, settled: Callable[[], None], chosen: OfferedButton | None
    ) -> None:
        urgent = is_urgent(inbound.text) if chosen is None else chosen.urgent
        inbound = inbound if chosen is None else tapped(inbound, chosen)
        known = self._known(inbound.sender)
        if self._lanes is None or not self._lanes.hand_over(
            inbound, settled, known=known, urgent=urgent
        ):
            log.warning("%s: too many messages wait; one was passed over", self.name)
            settled()

    def is_ours(self, message: str) -> bool:
        """Whether a message is known to be ours."""
        return message in self._sent

    # ---- speaking ----

    async def send(self, outbound: Outbound) -> str:
        """Send, and return the id of the last message that it took; see `deliver`."""
        if outbound.attachment is not None and outbound.attachment.size > self.file_bytes:
            raise MessengerFault(said("The file is too large for this messenger. It was not sent."))
        await self._until_ready()
        token = object()
        text = self._buttons.label(token, outbound)
        alone = outbound.attachment is not None and not text
        message = await self.deliver(outbound, [] if alone else [*self._pieces(text)])
        self._buttons.called(outbound.chat.id, token, message)
        remember(self._sent, message, "" if alone else outbound.chat.id)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Make a message look like this; see ``contracts.messenger``.

        Raises:
            MessageGone: It is not known any more, is a file alone, or has not the room for that.
            MessengerFault: Not changed, or it cannot be known whether it was.
        """
        if not self.edits:
            raise MessengerFault(said("Messages cannot be changed once they are sent."))
        await self._until_ready()
        text, *more = self._pieces(self._buttons.label(message, outbound))
        if more or self._sent.get(message) != outbound.chat.id:
            raise MessageGone("There is no such message, or it cannot be changed to that.")
        await self.deliver(outbound, [text], replaces=message)

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:  # noqa: ARG002
        """Refuse: there is nothing of the kind.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault(said("Messages cannot be pinned on this messenger."))

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Say something in answer to a tap; nothing waits here. Never raises."""
        if text:
            try:
                await self.deliver(Outbound(chat=inbound.chat, text=text), [*self._pieces(text)])
            except MessengerFault as fault:
                log.info("%s: a tap was not answered: %s", self.name, fault)

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:  # noqa: ARG002
        """Refuse: no files come.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault(said("Files cannot be taken on this messenger."))
        yield b""

    async def _until_ready(self) -> None:
        try:
            async with asyncio.timeout(READY_WITHIN_S):
                await self._ready.wait()
        except TimeoutError:
            raise MessengerFault(
                f"The messenger {self.name} is not connected. Nothing was sent."
            ) from None

    def _pieces(self, text: str) -> Iterator[str]:
        """Yield a text in pieces of the size of a message, cut at white space where that can be."""
        while len(text.encode()) > self.text_bytes:
            head = text.encode()[: self.text_bytes].decode(errors="ignore")
            cut = max(head.rfind("\n"), head.rfind(" ")) + 1 or len(head)
            yield text[:cut].rstrip()
            text = text[cut:]
        yield text


def read_settings(name: str, settings: Mapping[str, Any], kind: type[SettingsT]) -> SettingsT:
    """Check the table of a messenger.

    Args:
        name: Of the messenger.
        settings: Its table, as its factory is given it.
        kind: What such a table holds; a secret is a `Secret`.

    Raises:
        ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
    """
    table = {key: value for key, value in settings.items() if key not in {"kind", "name"}}
    known = msgspec.structs.fields(kind)
    for field in known:
        if field.type is Secret and isinstance(table.get(field.name), str):
            table[field.name] = Secret(table[field.name])
    if unknown := sorted(set(table) - {field.name for field in known}):
        raise ConfigurationError(
            f"The messenger {name} does not know the setting {unknown[0]}.",
            hint=f"It knows: {', '.join(field.name for field in known)}.",
        )
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as wrong:
        raise ConfigurationError(f"The messenger {name} cannot be made: {wrong}.") from None


def _anybody(_who: Address) -> bool:
    return True


def _nobody_is_told(_what: object) -> None:
    pass


def remember(where: OrderedDict[Any, Any], key: object, what: object) -> None:
    """Keep something under a key; the oldest of too many is forgotten."""
    where[key] = what
    while len(where) > REMEMBERED:
        where.popitem(last=False)
