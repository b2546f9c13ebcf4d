"""A person at a client of their own: a second one of matrix-nio, with keys of its own.

Nothing goes on in the background: what a person sees is asked for, and is then as of this moment.
"""

from __future__ import annotations

import asyncio
import io
import json
import time
from dataclasses import dataclass, field
from mimetypes import guess_type
from typing import TYPE_CHECKING, Any, Final, Self

from nio import (
    AsyncClient,
    AsyncClientConfig,
    ErrorResponse,
    Event,
    MatrixRoom,
    MegolmEvent,
    RoomPreset,
)
from nio.crypto.attachments import decrypt_attachment

from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path
    from types import TracebackType

    from tests.real.matrix.synapse import Account

WITHIN_S: Final = 30.0
_LONG_POLL_MS: Final = 250
_ENCRYPTION: Final = {
    "type": "m.room.encryption",
    "state_key": "",
    "content": {"algorithm": "m.megolm.v1.aes-sha2"},
}
# Everything that happened, or the timeline of a busy room would have gaps.
_FILTER: Final[dict[str, Any]] = {
    "room": {"timeline": {"limit": 1_000}},
    "presence": {"not_types": ["*"]},
}


class NotDone(Exception):
    """The homeserver refused what a person asked for."""


@dataclass
class Seen:
    """A message as a person sees it now.

    Attributes:
        id: Of its event, whatever was edited since.
        sender: A user.
        kind: ``m.text``, ``m.image`` and so on.
        text: Of the last edit.
        encrypted: It came encrypted, and this person's device could read it.
        edits: So often its sender changed it.
        reply_to: The event that it answers; empty for none.
        thread: The event that its thread began with; empty for none.
        reactions: From the key of each to who put it there.
        content: Whatever else it says; of the last edit.
    """

    id: str
    sender: str
    kind: str
    text: str
    encrypted: bool = False
    edits: int = 0
    reply_to: str = ""
    thread: str = ""
    reactions: dict[str, set[str]] = field(default_factory=dict)
    content: dict[str, Any] = field(default_factory=dict)


class Timeline:
    """What stands in one room.

    Attributes:
        messages: By their events, oldest first; without those that were redacted.
        unreadable: Events that this device has no key for.
    """

    def __init__(self) -> None:
        self.messages: dict[str, Seen] = {}
        self.unreadable: list[str] = []
        self._reactions: dict[str, tuple[str, str, str]] = {}

    def take(self, event: Mapping[str, Any], *, encrypted: bool) -> None:
        """Take in one event, as the homeserver gave it or as it was decrypted."""
        content, kind = event.get("content", {}), event.get("type")
        if kind == "m.room.redaction":
            self._redact(str(event.get("redacts") or content.get("redacts")))
        elif kind == "m.reaction" and "m.relates_to" in content:
            self._react(event["event_id"], event["sender"], content["m.relates_to"])
        elif kind == "m.room.message" and "msgtype" in content:
            self._say(event, content, encrypted=encrypted)

    def _say(self, event: Mapping[str, Any], content: dict[str, Any], *, encrypted: bool) -> None:
        relation = content.get("m.relates_to", {})
        if relation.get("rel_type") == "m.replace":
            self._edit(event["sender"], relation["event_id"], content["m.new_content"])
            return
        self.messages[event["event_id"]] = Seen(
            id=event["event_id"],
            sender=event["sender"],
            kind=content["msgtype"],
            text=content.get("body", ""),
            encrypted=encrypted,
            reply_to=relation.get("m.in_reply_to", {}).get("event_id", ""),
            thread=relation["event_id"] if relation.get("rel_type") == "m.thread" else "",
            content=content,
        )

    def _edit(self, sender: str, target: str, content: dict[str, Any]) -> None:
        seen = self.messages.get(target)
        if seen is not None and seen.sender == sender:
            seen.text, seen.content = content.get("body", ""), content
            seen.edits += 1

    def _react(self, event: str, sender: str, relation: Mapping[str, Any]) -> None:
        target, key = relation["event_id"], relation["key"]
        self._reactions[event] = (target, key, sender)
        if target in self.messages:
            self.messages[target].reactions.setdefault(key, set()).add(sender)

    def _redact(self, target: str) -> None:
        self.messages.pop(target, None)
        message, key, sender = self._reactions.pop(target, ("", "", ""))
        if message in self.messages:
            whose = self.messages[message].reactions[key]
            whose.discard(sender)
            if not whose:
                del self.messages[message].reactions[key]


class Person:
    """One device of a user. In a folder that it used before it is the same device again.

    Attributes:
        user: As in ``@ada1:rosic.test``.
        client: Of matrix-nio, for what this class has no word for.
    """

    def __init__(self, account: Account, folder: Path, device: str = "phone") -> None:
        """Prepare a device; nothing is asked of the homeserver.

        Args:
            account: Whose it is.
            folder: Its own; keys and the log-in are kept there.
            device: What its owner calls it.
        """
        self.user = account.user
        self._account = account
        self._folder = folder
        self._name = device
        self._timelines: dict[str, Timeline] = {}
        self._looking = asyncio.Lock()
        config = AsyncClientConfig(encryption_enabled=True, max_timeouts=1, max_limit_exceeded=0)
        folder.mkdir(parents=True, exist_ok=True)
        self.client = AsyncClient(account.url, account.user, store_path=str(folder), config=config)
        self.client.add_event_callback(self._on_event, Event)

    @property
    def device(self) -> str:
        """The identifier of this device, once it is logged in."""
        return str(self.client.device_id)

    async def __aenter__(self) -> Self:
        kept = self._folder / "login.json"
        if kept.exists():
            self.client.restore_login(**json.loads(kept.read_text()))
        else:
            answer = await self.client.login(self._account.password, device_name=self._name)
            _refuse_errors(answer)
            names = ("user_id", "device_id", "access_token")
            kept.write_text(json.dumps({name: getattr(answer, name) for name in names}))
        await self._sync(full_state=True)
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.client.close()

    # ---- rooms ----

    async def create_room(
        self, *invited: str, encrypted: bool = True, direct: bool = False, name: str = ""
    ) -> str:
        """Create a room whose members alone may read it; return its identifier."""
        answer = await self.client.room_create(
            name=name or None,
            invite=invited,
            is_direct=direct,
            preset=RoomPreset.trusted_private_chat if direct else RoomPreset.private_chat,
            initial_state=[_ENCRYPTION] if encrypted else [],
        )
        _refuse_errors(answer)
        await self.until(lambda: answer.room_id in self.client.rooms)
        return str(answer.room_id)

    async def invite(self, room: str, user: str) -> None:
        """Invite somebody."""
        _refuse_errors(await self.client.room_invite(room, user))

    async def join(self, room: str) -> None:
        """Accept an invitation, and read what stands there."""
        _refuse_errors(await self.client.join(room))
        await self.until(lambda: room in self.client.rooms)

    async def leave(self, room: str) -> None:
        """Leave a room."""
        _refuse_errors(await self.client.room_leave(room))

    async def kick(self, room: str, user: str) -> None:
        """Remove somebody from a room."""
        _refuse_errors(await self.client.room_kick(room, user))

    async def members(self, room: str) -> set[str]:
        """Return who is in a room now."""
        answer = await self.client.joined_members(room)
        _refuse_errors(answer)
        return {member.user_id for member in answer.members}

    # ---- what a person does ----

    async def say(self, room: str, text: str, *, reply_to: str = "", thread: str = "") -> str:
        """Write a message, and return its event: it is encrypted where the room is."""
        content: dict[str, Any] = {"msgtype": "m.text", "body": text}
        relation: dict[str, Any] = {}
        if thread:
            relation |= {"rel_type": "m.thread", "event_id": thread}
        if reply_to:
            relation["m.in_reply_to"] = {"event_id": reply_to}
        if relation:
            content["m.relates_to"] = relation
        return await self.send(room, "m.room.message", content)

    async def edit(self, room: str, event: str, text: str) -> str:
        """Change a message of one's own."""
        new = {"msgtype": "m.text", "body": text}
        relation = {"rel_type": "m.replace", "event_id": event}
        content = {"msgtype": "m.text", "body": f"* {text}", "m.new_content": new}
        return await self.send(room, "m.room.message", content | {"m.relates_to": relation})

    async def react(self, room: str, event: str, key: str) -> str:
        """Put a reaction beneath a message. Nobody's client encrypts one."""
        relation = {"rel_type": "m.annotation", "event_id": event, "key": key}
        return await self.send(room, "m.reaction", {"m.relates_to": relation})

    async def redact(self, room: str, event: str) -> None:
        """Take back a message or a reaction."""
        _refuse_errors(await self.client.room_redact(room, event))

    async def send_file(self, room: str, name: str, content: bytes) -> str:
        """Send a file, encrypted where the room is; return its event."""
        mime = guess_type(name)[0] or "application/octet-stream"
        encrypt = self.client.rooms[room].encrypted
        answer, keys = await self.client.upload(
            io.BytesIO(content),
            # The homeserver is not told what is in what it cannot read.
            content_type="application/octet-stream" if encrypt else mime,
            filename=None if encrypt else name,
            encrypt=encrypt,
            filesize=len(content),
        )
        _refuse_errors(answer)
        where = (
            {"file": {**keys, "url": answer.content_uri}} if keys else {"url": answer.content_uri}
        )
        told = {"msgtype": _kind_of_file(mime), "body": name, "filename": name}
        info = {"info": {"mimetype": mime, "size": len(content)}}
        return await self.send(room, "m.room.message", {**told, **info, **where})

    async def show_location(self, room: str, latitude: float, longitude: float) -> str:
        """Say where one is."""
        content = {
            "msgtype": "m.location",
            "body": "Here",
            "geo_uri": f"geo:{latitude},{longitude}",
        }
        return await self.send(room, "m.room.message", content)

    async def send(self, room: str, kind: str, content: dict[str, Any]) -> str:
        """Send whatever event, encrypted where the room is; return it."""
        await self.look()  # who is there, and with which devices
        answer = await self.client.room_send(room, kind, content, ignore_unverified_devices=True)
        _refuse_errors(answer)
        return str(answer.event_id)

    # ---- what a person sees ----

    async def look(self) -> None:
        """Take in everything that the homeserver has for this device now."""
        await self._sync()

    async def sees(self, room: str, sender: str = "") -> list[Seen]:
        """Return the messages in a room now, oldest first.

        Args:
            room: Which one.
            sender: Only theirs; everybody's by default.
        """
        await self.look()
        messages = self.timeline(room).messages.values()
        return [seen for seen in messages if not sender or seen.sender == sender]

    async def hears(self, room: str, text: str) -> Seen:
        """Wait until there is a message with this text, and return it."""

        def found() -> list[Seen]:
            return [seen for seen in self.timeline(room).messages.values() if seen.text == text]

        await self.until(lambda: bool(found()))
        return found()[-1]

    async def files(self, room: str, sender: str = "") -> list[tuple[str, bytes]]:
        """Return the files in a room, decrypted: name and content, oldest first."""
        found = []
        for seen in await self.sees(room, sender):
            content = seen.content
            if "url" in content or "file" in content:
                name = content.get("filename") or content["body"]
                found.append((name, await self._fetch(content)))
        return found

    def timeline(self, room: str) -> Timeline:
        """Return what was seen of a room until now."""
        return self._timelines.setdefault(room, Timeline())

    async def until(self, condition: Callable[[], bool], within_s: float = WITHIN_S) -> None:
        """Look again and again until a condition holds; an AssertionError says it never did."""
        give_up_s = time.monotonic() + within_s * pace()
        await self.look()
        while not condition():
            assert time.monotonic() < give_up_s, "it did not happen in time"
            await self._sync(_LONG_POLL_MS)

    async def wait(self) -> None:
        """Wait until there is something new, for a moment at most, and take it in."""
        await self._sync(_LONG_POLL_MS)

    async def _fetch(self, content: Mapping[str, Any]) -> bytes:
        file = content.get("file")
        answer = await self.client.download(file["url"] if file else content["url"])
        _refuse_errors(answer)
        body: bytes = answer.body
        if file:
            body = decrypt_attachment(body, file["key"]["k"], file["hashes"]["sha256"], file["iv"])
        return body

    async def _on_event(self, room: MatrixRoom, event: Event) -> None:
        if isinstance(event, MegolmEvent):
            self.timeline(room.room_id).unreadable.append(event.event_id)
        else:
            self.timeline(room.room_id).take(event.source, encrypted=bool(event.decrypted))

    async def _sync(self, wait_ms: int = 0, *, full_state: bool = False) -> None:
        """Ask once, and do what keys ask for: two at once would hand out one key twice."""
        async with self._looking:
            _refuse_errors(
                await self.client.sync(wait_ms, sync_filter=_FILTER, full_state=full_state or None)
            )
            if self.client.should_upload_keys:
                _refuse_errors(await self.client.keys_upload())
            if self.client.should_query_keys:
                _refuse_errors(await self.client.keys_query())
            if self.client.should_claim_keys:
                wanted = self.client.get_users_for_key_claiming()
                _refuse_errors(await self.client.keys_claim(wanted))
            for answer in await self.client.send_to_device_messages():
                _refuse_errors(answer)

    # ---- verification by emoji, device to device ----

    async def begin_verification(self, user: str, device: str) -> str:
        """Ask a device of somebody to compare emoji; return the transaction."""
        known = self.client.device_store.active_user_devices
        await self.until(lambda: any(one.id == device for one in known(user)))
        other = self.client.device_store[user][device]
        _refuse_errors(await self.client.start_key_verification(other))
        return str(self.client.get_active_sas(user, device).transaction_id)

    async def accept_verification(self, user: str) -> str:
        """Wait until somebody begins, and accept it; return the transaction."""

        def begun() -> list[str]:
            running = self.client.key_verifications.items()
            return [
                key
                for key, sas in running
                if sas.other_olm_device.user_id == user and not sas.we_started_it
            ]

        await self.until(lambda: bool(begun()))
        _refuse_errors(await self.client.accept_key_verification(begun()[-1]))
        return begun()[-1]

    async def emoji(self, transaction: str) -> list[str]:
        """Wait until there are emoji to compare, and return them."""
        sas = self.client.key_verifications[transaction]
        await self.until(lambda: sas.established_sas is not None)
        # nio 0.26 takes the seven indices for bits of a number (`Sas.get_emoji`), and shows others
        # than every other client.
        shown = sas.established_sas.bytes(sas._extra_info).emoji_indices
        return [sas.emoji[index][0] for index in shown]

    async def confirm(self, transaction: str) -> None:
        """Say that the emoji are the same, and wait until the other side has said so, too."""
        sas = self.client.key_verifications[transaction]
        _refuse_errors(await self.client.confirm_short_auth_string(transaction))
        await self.until(lambda: bool(sas.verified))

    async def reject(self, transaction: str) -> None:
        """Say that the emoji differ."""
        _refuse_errors(await self.client.cancel_key_verification(transaction, reject=True))


def _kind_of_file(mime: str) -> str:
    kind = mime.partition("/")[0]
    return f"m.{kind}" if kind in {"image", "video", "audio"} else "m.file"


def _refuse_errors(answer: object) -> None:
    if isinstance(answer, ErrorResponse):
        raise NotDone(str(answer))
