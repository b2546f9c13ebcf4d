"""What crosses the wire for one account: rooms, keys and messages, in steps of bounded length."""

from __future__ import annotations

import json
import logging
import uuid
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote, urlencode

from rosic.errors import MessengerFault
from rosic.messengers.matrix.connection import API, CALL_S, FILE_S, GIVE_UP_S, MatrixConnection
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind
from rosic.messengers.matrix.olm_machine import ENCRYPTED, SyncedEvent, ciphertext_of
from rosic.messengers.matrix.outgoing_sessions import OutgoingSessions
from rosic.messengers.matrix.room_table import RoomTable
from rosic.messengers.matrix.step_budget import StepBudget
from rosic.messengers.matrix.sync_answer import MOST_AT_START, MOST_BYTES, event_of, split_answer
from rosic.messengers.matrix.user_keys import KeyDirectory

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Collection, Mapping

    from rosic.contracts.clock import Clock
    from rosic.messengers.matrix.settings import MatrixSettings
    from rosic.messengers.matrix.sync_answer import RoomPart, SyncAnswer
    from rosic.messengers.matrix.user_keys import DeviceIdentity

REACTION: Final = "m.reaction"
DEVICES_AT_MOST: Final = 50
"""Of one person, that are given the key of what anybody may read."""

log = logging.getLogger("rosic.messengers.matrix")


class MatrixClient(MatrixConnection):
    """Reads what comes, and says what goes, for one account.

    Args:
        name: Of the messenger, for the log and for sentences.
        knows: Whether somebody is known here, by their account.

    Attributes:
        directory: What is shown of people's keys.
        rooms: Which rooms this account is in, and who is there.
        steps: Gives way while something long is taken apart, whatever its parts are.
    """

    def __init__(
        self, name: str, settings: MatrixSettings, clock: Clock, knows: Callable[[str], bool]
    ) -> None:
        super().__init__(name, settings, clock, knows)
        self.directory = KeyDirectory(self.call)
        self.rooms = RoomTable()
        self.steps = StepBudget()
        self._sessions = OutgoingSessions(lambda: self.machine, self.call, clock)

    def remember_rooms(self) -> None:
        """Have rooms encrypted that were so in an earlier run, whatever is said of them now."""
        self.rooms.were_encrypted(self._nio.encrypted_rooms)

    def members(self, room: str) -> frozenset[str]:
        """Return who is in a room, or was invited; nobody, of a room that is not known."""
        found = self.rooms.get(room)
        return frozenset() if found is None else frozenset(found.users)

    def is_encrypted(self, room: str) -> bool:
        """Whether a room is encrypted; once it was, nothing that the homeserver says undoes it."""
        found = self.rooms.get(room)
        return found is not None and found.encrypted

    # ---- receiving ----

    async def sync(
        self, since: str, *, timeout_ms: int, full: bool, shape: Mapping[str, Any]
    ) -> SyncAnswer:
        """Ask for what is new.

        Raises:
            MatrixError: No answer, or a refusal; ``TOO_LARGE``: ask for less.
        """
        asked = {
            "timeout": str(timeout_ms),
            "full_state": "true" if full else "false",
            "set_presence": "offline",
            "filter": json.dumps(shape),
        } | ({"since": since} if since else {})
        body = await self.get(
            f"{API}/sync?{urlencode(asked)}",
            most=MOST_AT_START if full else MOST_BYTES,
            within_s=FILE_S if full else CALL_S + timeout_ms / 1_000,
        )
        try:
            answer = split_answer(body)
        except ValueError as error:
            raise MatrixError(
                "The homeserver answers with nonsense.", MatrixErrorKind.LOST, str(error)
            ) from None
        if answer.one_time_keys is not None:
            self.machine.keys_are_left(answer.one_time_keys)
        return answer

    async def take_to_device(self, answer: SyncAnswer) -> AsyncIterator[Mapping[str, Any]]:
        """Yield what came to this device in the open; keys that came encrypted are kept."""
        for piece in answer.to_device:
            source = event_of(piece)
            found = None if source is None else self.machine.open_to_device(source)
            if found is not None:
                yield found
            await self.steps.give_way()

    async def take_state(self, room: str, part: RoomPart) -> AsyncIterator[Mapping[str, Any]]:
        """Take what an answer says of a room itself, and yield the events of its timeline."""
        joined = self.rooms.entered(room)
        if joined is None:
            return
        for piece in part.state:
            source = event_of(piece)
            if source is not None:
                joined.follow(source)
            await self.steps.give_way()
        for piece in part.timeline:
            source = event_of(piece)
            if source is not None:
                if "state_key" in source:
                    joined.follow(source)
                yield source
            await self.steps.give_way()
        if self.rooms.newly_encrypted(room):
            self._nio.store.save_encrypted_rooms({room})

    def open_event(
        self, room: str, source: Mapping[str, Any], received_ns: int, *, note: bool = True
    ) -> SyncedEvent:
        """Return an event of a room as it was written; see `OlmMachine.open_room_event`.

        Raises:
            EventDecryptionError: It came encrypted, and cannot be read.
        """
        if source.get("sender") == self.user:
            return SyncedEvent(source)  # what we said ourselves is known here
        return self.machine.open_room_event(room, source, received_ns, note=note)

    def has_key(self, room: str, source: Mapping[str, Any]) -> bool:
        """Whether the key of an event that came encrypted is here."""
        sealed = ciphertext_of(source)
        return sealed is not None and self.machine.held(room, *sealed[:2]) is not None

    async def upkeep(self) -> None:
        """Keep the keys as they must be: ours at the homeserver, sessions in working order."""
        library = self._nio
        try:
            if library.should_upload_keys:
                await self.ask(library.keys_upload)
            while self.machine.broken:
                (user, sender_key), _ = self.machine.broken.popitem(last=False)
                device = (await self.directory.keys_of(user)).device_with(sender_key)
                if device is not None:
                    await self._sessions.begin_anew(device)
        except MessengerFault as fault:
            log.info("%s: keys were not looked after: %s", self._name, fault)

    async def renew_fallback_key(self) -> None:
        """Have a key at the homeserver for those who come when all one-time keys are used up.

        Raises:
            MatrixError: It is not there, or it cannot be known.
        """
        machine = self.machine
        # matrix-nio makes none; what is underneath it does.
        account = machine.account._account  # noqa: SLF001
        account.generate_fallback_key()
        keys: dict[str, Any] = {}
        for name, key in account.fallback_key.items():
            said = {"key": key.to_base64(), "fallback": True}
            signature = machine.sign_json(said)
            owner = {self.user: {f"ed25519:{self.device}": signature}}
            keys[f"signed_curve25519:{name}"] = {**said, "signatures": owner}
        machine.save_account()
        await self.persist(lambda: self.call("POST", f"{API}/keys/upload", {"fallback_keys": keys}))
        account.mark_keys_as_published()
        machine.save_account()

    # ---- sending ----

    async def send(
        self,
        room: str,
        kind: str,
        content: Mapping[str, Any],
        *,
        readers: Collection[DeviceIdentity] | None = None,
        within_s: float = GIVE_UP_S,
    ) -> str:
        """Put an event into a room, encrypted where the room is, and return its id.

        Args:
            room: Where it goes.
            kind: Of the event.
            content: Of the event.
            readers: Who is given the key; None: every device that the homeserver shows of
                anybody there. That is for what holds no secret.
            within_s: How long it may take.

        Raises:
            MatrixError: It is not there, or it cannot be known.
        """
        transaction = quote(str(uuid.uuid4()), safe="")

        async def act() -> dict[str, Any]:
            said, told = kind, dict(content)
            if self.is_encrypted(room) and kind != REACTION:  # no client encrypts one
                to = await self._everybody(room) if readers is None else readers
                told = await self._sessions.encrypt(room, kind, content, to, public=readers is None)
                said = ENCRYPTED
            where = f"{API}/rooms/{quote(room, safe='')}/send/{quote(said, safe='')}/{transaction}"
            return await self.call("PUT", where, told)

        found = await self.persist(act, within_s=within_s)
        return str(found.get("event_id", ""))

    async def _everybody(self, room: str) -> list[DeviceIdentity]:
        shown = await self.directory.keys_of_all(sorted(self.members(room) - {self.user}))
        found = []
        for keys in shown:
            for name in keys.devices()[:DEVICES_AT_MOST]:
                device = keys.device(name)
                if device is not None:
                    found.append(device)
                await self.steps.give_way()
        return found

    async def redact(self, room: str, event: str) -> None:
        """Take an event out of a room.

        Raises:
            MatrixError: It is still there, or it cannot be known.
        """
        transaction = str(uuid.uuid4())
        named = f"{quote(room, safe='')}/redact/{quote(event, safe='')}/{transaction}"
        await self.persist(lambda: self.call("PUT", f"{API}/rooms/{named}", {}))
