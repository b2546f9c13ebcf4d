"""Sends, edits, pins and takes away in one account's name.

A text goes as it is given, without any markup beside it. Buttons are signs that the account puts
beneath its own message as reactions: to tap one is to react with the same sign. Beneath the text
stand the numbers and what each stands for, so that a client without reactions can reply with one.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.language import hears_stop
from rosic.core.message import Button
from rosic.errors import ChatGone, MessageGone, MessengerFault
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind
from rosic.messengers.matrix.files import MediaCalls
from rosic.messengers.matrix.incoming import MESSAGE, OfferedNonce
from rosic.messengers.matrix.room_calls import RoomCalls
from rosic.messengers.matrix.signs import KEYS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Mapping, Sequence

    from rosic.core.message import Attachment, Chat, Outbound
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.signs import Signs
    from rosic.messengers.matrix.user_keys import DeviceIdentity

GAP: Final = "   "
TELLING: Final = 10
"""So many signs are numbers."""
TEXT_BYTES: Final = 24_000
"""An event has 65,536 bytes at the most, and encryption adds a third to it; an edit says its text
twice (https://spec.matrix.org/latest/client-server-api/#size-limits)."""
REMEMBERED: Final = 4_096
KEPT: Final = 512
"""Offers that another run goes on with."""
TAP_S: Final = 3.0
PINNED: Final = "m.room.pinned_events"
VARIATION: Final = "\ufe0f"

log = logging.getLogger("rosic.messengers.matrix")


# ---- content ----


def labelled(text: str, rows: Sequence[Sequence[Button]]) -> str:
    """Return a text with each row of buttons beneath it: the number and the label of each."""
    numbers = count(1)
    lines = [GAP.join(_labelled(next(numbers), one) for one in row) for row in rows if row]
    if not lines:
        return text
    below = "\n".join(lines)
    return f"{text}\n\n{below}" if text else below


def _labelled(number: int, button: Button) -> str:
    """Return a button as it is read; from the eleventh on its sign is no number."""
    beside = f" {KEYS[number - 1]}" if TELLING < number <= len(KEYS) else ""
    return f"{number}. {button.label}{beside}"


def buttons_of(outbound: Outbound) -> tuple[Button, ...]:
    """Return the buttons of a message, in the order in which they are read."""
    return tuple(button for row in outbound.buttons for button in row)


def pieces(text: str) -> list[str]:
    """Return a text in pieces that fit into one event each, cut at white space where it can be."""
    found = []
    while len(text.encode()) > TEXT_BYTES:
        head = text.encode()[:TEXT_BYTES].decode(errors="ignore")
        cut = max(head.rfind("\n"), head.rfind(" "))
        head = head if cut <= 0 else head[:cut]
        found.append(head)
        text = text[len(head) :].lstrip() if cut > 0 else text[len(head) :]
    return [*found, text] if text or not found else found


def words(text: str) -> dict[str, Any]:
    """Return the content of a message that is a text, exactly as given."""
    return {"msgtype": "m.text", "body": text}


def replacing(message: str, new: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of an edit."""
    return {
        **new,
        "body": f"* {new['body']}",
        "m.new_content": dict(new),
        "m.relates_to": {"rel_type": "m.replace", "event_id": message},
    }


def related(chat: Chat, reply_to: str) -> dict[str, Any]:
    """Return where in its room a message belongs: in a thread, beneath another, or nowhere."""
    answered = {"m.in_reply_to": {"event_id": reply_to}} if reply_to.startswith("$") else {}
    if not chat.topic:
        return {"m.relates_to": answered} if answered else {}
    inside = answered or {"m.in_reply_to": {"event_id": chat.topic}}
    thread = {"rel_type": "m.thread", "event_id": chat.topic, "is_falling_back": not answered}
    return {"m.relates_to": thread | inside}


# ---- what is remembered ----


class Offers:
    """Which buttons stand beneath which of our messages. Bounded: the oldest are forgotten.

    Attributes:
        changed: Set when they are others than were kept.
    """

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self._offered: OrderedDict[tuple[str, str], tuple[Button, ...]] = OrderedDict()
        self._stops: OrderedDict[str, None] = OrderedDict()

    @property
    def known(self) -> bool:
        """Whether there are any."""
        return bool(self._offered)

    def offer(self, room: str, message: str, buttons: tuple[Button, ...]) -> None:
        """Remember what stands beneath a message now; nothing: it has no buttons any more."""
        if self._offered.pop((room, message), None) or buttons:
            self.changed.set()
        if buttons:
            self._offered[room, message] = buttons
        while len(self._offered) > REMEMBERED:
            self._offered.popitem(last=False)
        for button in buttons:
            if hears_stop(button.command) is not None:
                self._stops[button.nonce] = None
        while len(self._stops) > REMEMBERED:
            self._stops.popitem(last=False)

    def kept(self) -> bytes:
        """Return the newest of them, for another run to go on with."""
        newest = list(self._offered.items())[-KEPT:]
        rows = [
            (*where, [(one.nonce, one.nonce in self._stops) for one in buttons])
            for where, buttons in newest
        ]
        return msgspec.json.encode(rows)

    def restore(self, content: bytes) -> None:
        """Go on with what another run has kept; what is not like that is passed over."""
        try:
            rows = msgspec.json.decode(content, type=list[tuple[str, str, list[tuple[str, bool]]]])
        except msgspec.MsgspecError:
            return
        for room, message, nonces in rows:
            buttons = [Button("", "stop" if stops else "", nonce) for nonce, stops in nonces]
            self.offer(room, message, tuple(buttons))

    def tapped(self, room: str, message: str, sign: str) -> OfferedNonce | None:
        """Return the button that a reaction or a number taps; None for none."""
        buttons = self._offered.get((room, message), ())
        at = _place_of(sign)
        if at is None or at >= len(buttons) or not buttons[at].nonce:
            return None
        return OfferedNonce(message, buttons[at].nonce)

    def stops(self, nonce: str) -> bool:
        """Whether the button with this nonce says stop."""
        return nonce in self._stops


def _place_of(sign: str) -> int | None:
    plain = sign.replace(VARIATION, "")
    for number, key in enumerate(KEYS):
        if plain == key.replace(VARIATION, ""):
            return number
    if plain.isascii() and plain.isdecimal() and 1 <= int(plain[:3]) <= 99 and len(plain) < 3:  # noqa: PLR2004
        return int(plain) - 1
    return None


class SentMessages:
    """What we said: its content, for changing it. Bounded: the oldest are forgotten."""

    def __init__(self) -> None:
        self._said: OrderedDict[str, tuple[str, dict[str, Any]]] = OrderedDict()

    def said(self, room: str, message: str, content: dict[str, Any]) -> None:
        """Remember what a message shows."""
        self._said[message] = room, content
        while len(self._said) > REMEMBERED:
            self._said.popitem(last=False)

    def shown(self, message: str) -> tuple[str, dict[str, Any]] | None:
        """Return the room of a message and what it shows; None where that is not known."""
        return self._said.get(message)

    def forget(self, message: str) -> None:
        """Forget one that is gone."""
        self._said.pop(message, None)


# ---- sending ----


class RoomSender:
    """Speaks for one account.

    Args:
        file_bytes: Returns how large a file may be.
        readers: Returns which devices are given the key of what is said in a room.
    """

    def __init__(
        self,
        client: MatrixClient,
        offers: Offers,
        signs: Signs,
        file_bytes: Callable[[], int],
        readers: Callable[[str], Awaitable[Collection[DeviceIdentity]]],
    ) -> None:
        self._readers = readers
        self._client = client
        self._media = MediaCalls(client)
        self._calls = RoomCalls(client)
        self._offers = offers
        self._signs = signs
        self._file_bytes = file_bytes
        self._own = SentMessages()
        self._in_order: dict[str, asyncio.Lock] = {}

    def wrote(self, message: str) -> bool:
        """Whether a message is known to be ours."""
        return self._own.shown(message) is not None

    async def send(self, outbound: Outbound) -> str:
        """Send, and return the id of the last message that it took.

        Raises:
            ChatGone: We are not in that room.
            MatrixError: Not sent, or it cannot be known.
        """
        room, buttons = outbound.chat.id, buttons_of(outbound)
        if room not in self._client.rooms:
            raise ChatGone("We are not in that room, or not any more.")
        contents = await self._contents(outbound, labelled(outbound.text, outbound.buttons))
        contents[0] |= related(outbound.chat, outbound.reply_to)
        message = ""
        if outbound.urgent:
            for content in contents:
                message = await self._put(room, content)
        else:
            async with self._in_order.setdefault(room, asyncio.Lock()):
                for content in contents:
                    message = await self._put(room, content)
        self._offers.offer(room, message, buttons)
        self._signs.want(room, message, len(buttons))
        return message

    async def _put(self, room: str, content: dict[str, Any]) -> str:
        try:
            readers = await self._readers(room)
            message = await self._client.send(room, MESSAGE, content, readers=readers)
        except MatrixError as error:
            if error.kind is MatrixErrorKind.FORBIDDEN:
                raise ChatGone("Nothing may be said by us in that room.") from None
            raise
        self._own.said(room, message, content)
        return message

    async def _contents(self, outbound: Outbound, text: str) -> list[dict[str, Any]]:
        attachment = outbound.attachment
        if attachment is None:
            return [words(piece) for piece in pieces(text)]
        if attachment.size > self._file_bytes():
            raise MessengerFault(
                said("The file is larger than the homeserver takes. It was not sent.")
            )
        file = await self._file(outbound.chat.id, attachment)
        first, *rest = pieces(text)
        # What a client shows of a file beside its name is one event with it, as far as it goes.
        return [*map(words, [first, *rest][:-1]), captioned(file, (rest or [first])[-1])]

    async def _file(self, room: str, attachment: Attachment) -> dict[str, Any]:
        def source() -> AsyncIterator[bytes]:
            return attachment.read()

        encrypted = self._client.is_encrypted(room)
        address, keys = await self._media.upload(
            source, attachment.size, attachment.media_type, encrypt=encrypted
        )
        kind = attachment.media_type.partition("/")[0]
        shown = kind if kind in {"image", "video", "audio"} else "file"
        content: dict[str, Any] = {
            "msgtype": f"m.{shown}",
            "filename": attachment.name,
            "body": attachment.name,
            "info": {"mimetype": attachment.media_type, "size": attachment.size},
        }
        return content | ({"url": address} if keys is None else {"file": {**keys, "url": address}})

    # ---- changing ----

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Make a message look like this; a file that went with it stays.

        Raises:
            MessageGone: There is no such message any more, or it has not the room for that.
            MatrixError: Not changed, or it cannot be known.
        """
        room, buttons = outbound.chat.id, buttons_of(outbound)
        text = labelled(outbound.text, outbound.buttons)
        if len(pieces(text)) > 1:
            raise MessageGone("That is too long for one message.")
        before = await self._shown(room, message)
        new = captioned(before, text) if "info" in before else words(text)
        readers = await self._readers(room)
        await self._client.send(room, MESSAGE, replacing(message, new), readers=readers)
        self._own.said(room, message, new)
        self._offers.offer(room, message, buttons)
        self._signs.want(room, message, len(buttons))

    async def _shown(self, room: str, message: str) -> dict[str, Any]:
        """Return what a message of ours shows.

        Raises:
            MessageGone: There is none, or it is not ours.
            MatrixError: It cannot be known.
        """
        known = self._own.shown(message)
        if known is not None and known[0] == room:
            return known[1]
        if not message.startswith("$"):
            raise MessageGone("There is no such message any more.")
        content = await self._calls.read_own(room, message)
        if content is None:
            raise MessageGone("There is no such message any more.")
        self._own.said(room, message, content)
        return content

    async def retract(self, room: str, message: str) -> None:
        """Take a message out of a room. One that is not there any more is out of it.

        Raises:
            MessageGone: It can never be done: it is not ours to take away.
            MatrixError: Not done, or it cannot be known.
        """
        try:
            await self._client.redact(room, message)
        except MatrixError as error:
            if error.kind in {MatrixErrorKind.FORBIDDEN, MatrixErrorKind.REFUSED}:
                raise MessageGone(str(error)) from None
            if error.kind is not MatrixErrorKind.NOT_FOUND:
                raise
        self._own.forget(message)

    async def pin(self, room: str, message: str, *, pinned: bool) -> None:
        """Keep a message of ours in sight, or no longer.

        Raises:
            MessageGone: There is no such message any more.
            MatrixError: Not done.
        """
        if pinned:
            await self._shown(room, message)
        now = await self._calls.state(room, PINNED)
        held = now.get("pinned")
        there = [one for one in held if isinstance(one, str)] if isinstance(held, list) else []
        if (message in there) is pinned:
            return
        new = [*there, message] if pinned else [one for one in there if one != message]
        try:
            await self._calls.set_state(room, PINNED, {"pinned": new})
        except MatrixError as error:
            if error.kind is MatrixErrorKind.FORBIDDEN:
                raise MessengerFault(may_not_pin()) from None
            raise

    async def answer(self, room: Chat, text: str, *, public: bool = False) -> None:
        """Say something in answer to a tap. Never raises.

        Args:
            room: Where.
            text: What is said.
            public: Anybody there may read it: it holds no secret.
        """
        try:
            content = {**words(text), "msgtype": "m.notice"} | related(room, "")
            async with asyncio.timeout(TAP_S):
                readers = None if public else await self._readers(room.id)
                await self._client.send(room.id, MESSAGE, content, readers=readers, within_s=TAP_S)
        except (MessengerFault, TimeoutError) as fault:
            log.info("a tap was not answered: %s", fault)


def captioned(file: Mapping[str, Any], text: str) -> dict[str, Any]:
    """Return the content of a file with a text beside it."""
    content = {key: value for key, value in file.items() if key != "m.relates_to"}
    return content | {"body": text or str(file.get("filename", ""))}


def may_not_pin() -> str:
    """Say why nothing is pinned here, and who can change it."""
    return said(
        "I may not pin messages here. Somebody who may change this room can let me; "
        "or pin it yourself."
    )
