"""What decrypts for one device, on matrix-nio's sessions: nothing that is sent can end it.

matrix-nio keeps whatever anybody sends: sessions, requests for keys, names of keys it never saw.
Here all of it has a bound, and what strangers send never drives out what came from people known.
"""

from __future__ import annotations

import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import msgspec
import nio
import vodozemac
from nio.crypto import Olm
from nio.crypto.sessions import InboundGroupSession
from nio.store.models import MegolmInboundSessions, OlmSessions
from unpaddedbase64 import decode_base64

from rosic.messengers.matrix.replay_guard import PlaceStanding, ReplayGuard, SessionPlace
from rosic.messengers.matrix.sync_answer import LONGEST_ID

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

ENCRYPTED: Final = "m.room.encrypted"
MEGOLM: Final = "m.megolm.v1.aes-sha2"
OLM: Final = "m.olm.v1.curve25519-aes-sha2"
OF_ONE_PERSON: Final = 500
"""Room keys kept of one person who is known here."""
OF_STRANGERS: Final = 500
"""Room keys, and devices with a session of their own, kept of all others together."""
OLM_SESSIONS: Final = 8
"""Of one device; another one is made when both sides have lost touch."""
BROKEN_AT_MOST: Final = 100
MILLISECOND_NS: Final = 1_000_000

log = logging.getLogger("rosic.messengers.matrix")


class SyncedEvent(NamedTuple):
    """An event of a room as it was written.

    Attributes:
        source: Its JSON.
        sender_key: Of the device whose session it came under; empty: it came in the open.
        session_id: Of that session.
        late: It was held back: its session had come further when it came.
    """

    source: Mapping[str, Any]
    sender_key: str = ""
    session_id: str = ""
    late: bool = False

    @property
    def decrypted(self) -> bool:
        """Whether it came encrypted."""
        return bool(self.session_id)

    @property
    def sender(self) -> str:
        """Who has sent it, as the homeserver says."""
        return str(self.source.get("sender", ""))

    @property
    def event_id(self) -> str:
        """Its id, as the homeserver says."""
        return str(self.source.get("event_id", ""))


class EventDecryptionError(Exception):
    """An event of a room cannot be read.

    Attributes:
        replayed: Another event with the same ciphertext was read before.
        session: Whose key is missing; empty: a key would not help.
    """

    def __init__(self, reason: str, *, session: str = "", replayed: bool = False) -> None:
        super().__init__(reason)
        self.session = session
        self.replayed = replayed


class EncryptedContent(NamedTuple):
    """What is encrypted of an event of a room."""

    sender_key: str
    session_id: str
    text: str


def ciphertext_of(source: Mapping[str, Any]) -> EncryptedContent | None:
    """Return what is encrypted of an event; None for one in another way, or malformed."""
    content = source.get("content")
    if not isinstance(content, dict) or content.get("algorithm") != MEGOLM:
        return None
    found = [
        part
        for name in ("sender_key", "session_id", "ciphertext")
        if isinstance(part := content.get(name), str) and part
    ]
    if len(found) < len(EncryptedContent._fields) or any(
        len(part) > LONGEST_ID for part in found[:2]
    ):
        return None
    return EncryptedContent(*found)


def _olm_message(sealed: Mapping[str, Any]) -> Any:  # noqa: ANN401 - vodozemac's
    body = str(sealed.get("body"))
    if sealed.get("type") == 0:
        return vodozemac.PreKeyMessage.from_base64(body)
    return vodozemac.AnyOlmMessage.normal(decode_base64(body))


class OlmMachine(Olm):  # type: ignore[misc] # matrix-nio has no types
    """Decrypts for one device.

    Args:
        guard: Judges what was decrypted.
        knows: Whether somebody is known here.
    """

    def __init__(
        self,
        user: str,
        device: str,
        store: Any,  # noqa: ANN401 - matrix-nio's
        guard: ReplayGuard,
        knows: Callable[[str], bool],
    ) -> None:
        self._guard = guard
        self._knows = knows
        self._room_keys: dict[str, OrderedDict[tuple[str, str, str], None]] = {}
        self._strangers_devices: OrderedDict[str, None] = OrderedDict()
        self.broken: OrderedDict[tuple[str, str], None] = OrderedDict()
        """Devices of people known whose session does not work any more: person and identity key."""
        super().__init__(user, device, store)
        for session in list(self.inbound_group_store):
            self._opened(session.room_id, session.sender_key, session.id)

    # ---- what comes to this device ----

    def keys_are_left(self, number: int) -> None:
        """Note how many of our one-time keys are left at the homeserver, as it says."""
        self.uploaded_key_count = max(0, min(number, self.account.max_one_time_keys))

    def open_to_device(self, source: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """Read what came to this device; keys are kept. None for what is for nobody else here."""
        try:
            return self._open_to_device(source)
        except Exception:
            log.info("a message to this device was passed over", exc_info=True)
            return None

    def _open_to_device(self, source: Mapping[str, Any]) -> Mapping[str, Any] | None:
        if source.get("type") != ENCRYPTED:
            return source
        content, sender = source.get("content"), source.get("sender")
        if not isinstance(content, dict) or not isinstance(sender, str):
            return None
        ciphertext, sender_key = content.get("ciphertext"), content.get("sender_key")
        own = self.account.identity_keys["curve25519"]
        for_us = ciphertext.get(own) if isinstance(ciphertext, dict) else None
        if content.get("algorithm") != OLM or not isinstance(for_us, dict):
            return None
        if not isinstance(sender_key, str) or len(sender_key) > LONGEST_ID:
            return None
        message = _olm_message(for_us)
        self.decrypt(sender, sender_key, message)
        self._bound_sessions(sender, sender_key)
        return None

    def _bound_sessions(self, sender: str, sender_key: str) -> None:
        entries = self.session_store._entries  # noqa: SLF001 - it makes one for each name it is asked
        kept = entries[sender_key]
        if not kept:
            del entries[sender_key]
            return
        for session in kept[OLM_SESSIONS:]:
            self._drop(OlmSessions, session.id)
        del kept[OLM_SESSIONS:]
        if self._knows(sender):
            self._strangers_devices.pop(sender_key, None)
            return
        self._strangers_devices[sender_key] = None
        while len(self._strangers_devices) > OF_STRANGERS:
            oldest, _ = self._strangers_devices.popitem(last=False)
            for session in entries.pop(oldest, ()):
                self._drop(OlmSessions, session.id)

    def _drop(self, table: Any, session: str) -> None:  # noqa: ANN401 - matrix-nio has no types
        with self.store.database.bind_ctx(self.store.models):
            table.delete().where(table.session_id == session).execute()

    def _mark_device_for_unwedging(self, sender: str, sender_key: str) -> None:
        if self._knows(sender) and len(self.broken) < BROKEN_AT_MOST:
            self.broken[sender, sender_key] = None

    def handle_key_verification(self, event: object) -> None:
        """Leave verifications to us, for rooms as well: matrix-nio would answer by itself."""

    def _handle_forwarded_room_key_event(self, *_event: Any) -> None:  # noqa: ANN401
        """Leave them: whose session that was is hearsay."""

    def _handle_room_key_event(
        self, sender: str, sender_key: str, payload: Mapping[str, Any]
    ) -> None:
        content, keys = payload["content"], payload["keys"]
        if content.get("algorithm") != MEGOLM:
            return
        room, session, key = (
            content.get(name) for name in ("room_id", "session_id", "session_key")
        )
        fingerprint = keys.get("ed25519")
        named = (room, session, key, fingerprint)
        if not all(isinstance(name, str) and name for name in named) or len(room) > LONGEST_ID:
            return
        self.create_group_session(sender_key, fingerprint, room, session, key)
        if self.held(room, sender_key, session) is not None:
            self._bound_room_keys(sender, (room, sender_key, session))

    def create_group_session(
        self, sender_key: str, sender_fp_key: str, room_id: str, session_id: str, session_key: str
    ) -> None:
        """Keep the key of a session; one that reaches back further stays."""
        session = InboundGroupSession(session_key, sender_fp_key, sender_key, room_id)
        held = self.held(room_id, sender_key, session_id)
        if session.id != session_id:
            return
        if held is not None and held.first_known_index <= session.first_known_index:
            return
        self.inbound_group_store.add(session)
        self.save_inbound_group_session(session)
        self._opened(room_id, sender_key, session_id)

    def _opened(self, room: str, sender_key: str, session: str) -> None:
        for given_up in self._guard.opened(room, sender_key, session):
            self._forget(*given_up)

    def _bound_room_keys(self, sender: str, key: tuple[str, str, str]) -> None:
        whose = sender if self._knows(sender) else ""
        kept = self._room_keys.setdefault(whose, OrderedDict())
        kept[key] = None
        while len(kept) > (OF_ONE_PERSON if whose else OF_STRANGERS):
            (room, sender_key, session), _ = kept.popitem(last=False)
            self._forget(room, sender_key, session)

    def _forget(self, room: str, sender_key: str, session: str) -> None:
        self._guard.closed(room, sender_key, session)
        of_device = self.inbound_group_store[room].get(sender_key, {})
        of_device.pop(session, None)
        if not of_device:
            self.inbound_group_store[room].pop(sender_key, None)
        self._drop(MegolmInboundSessions, session)

    def olm_session(self, sender_key: str) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """Return the session with a device that was used last; None for none."""
        kept = self.session_store._entries.get(sender_key)  # noqa: SLF001 - as above
        return kept[0] if kept else None

    # ---- what comes in rooms ----

    def held(self, room: str, sender_key: str, session: str) -> Any:  # noqa: ANN401 - matrix-nio's
        """Return a session whose key is here; None for any other."""
        of_room = self.inbound_group_store._entries.get(room, {})  # noqa: SLF001 - as above
        return of_room.get(sender_key, {}).get(session)

    def open_room_event(
        self, room: str, source: Mapping[str, Any], received_ns: int, *, note: bool = True
    ) -> SyncedEvent:
        """Return an event of a room as it was written.

        Args:
            room: Where it came.
            source: As it came.
            received_ns: When, on our wall clock.
            note: It has come; False: it is merely looked at, and will be opened again.

        Raises:
            EventDecryptionError: It came encrypted, and cannot be read.
        """
        if source.get("type") != ENCRYPTED:
            return SyncedEvent(source)
        sealed = ciphertext_of(source)
        if sealed is None:
            raise EventDecryptionError("it is encrypted in no way that is known here")
        session = self.held(room, sealed.sender_key, sealed.session_id)
        if session is None or not self._guard.is_known(room, *sealed[:2]):
            raise EventDecryptionError("its key is missing", session=sealed.session_id)
        try:
            opened = session._session.decrypt(  # noqa: SLF001 - as bytes, of which strangers chose
                vodozemac.MegolmMessage.from_base64(sealed.text)
            )
            written = msgspec.json.decode(opened.plaintext)
        except Exception as error:  # noqa: BLE001 - whatever it can make the libraries raise
            raise EventDecryptionError(f"{type(error).__name__}: {error}") from None
        event, received_ms = str(source.get("event_id")), received_ns // MILLISECOND_NS
        place = SessionPlace(room, *sealed[:2], opened.message_index)
        verdict = self._guard.judge(place, event, received_ms, note=note)
        if verdict.standing is PlaceStanding.REPLAYED:
            raise EventDecryptionError("it was read before, as another event", replayed=True)
        found = _written(source, written, verdict.before_ms)
        return SyncedEvent(found, *sealed[:2], late=verdict.is_late)


def _written(source: Mapping[str, Any], written: Any, before_ms: int) -> dict[str, Any]:  # noqa: ANN401
    """Return an event as it was written: inside stand its type, its content and its room alone.

    What it relates to may stand outside. When it was sent says the homeserver: not later than when
    something after it had come.

    Raises:
        EventDecryptionError: What was written is no event.
    """
    content = written.get("content") if isinstance(written, dict) else None
    if not isinstance(content, dict) or not isinstance(written.get("type"), str):
        raise EventDecryptionError("what was encrypted is no event")
    outside = source.get("content", {}).get("m.relates_to")
    if outside is not None and "m.relates_to" not in content:
        content = {**content, "m.relates_to": outside}
    sent_ms = source.get("origin_server_ts")
    return {
        "type": written["type"],
        "content": content,
        "room_id": written.get("room_id"),
        "event_id": source.get("event_id"),
        "sender": source.get("sender"),
        "origin_server_ts": min(sent_ms, before_ms) if type(sent_ms) is int else before_ms,
    }


class AccountClient(nio.AsyncClient):  # type: ignore[misc] # matrix-nio has no types
    """The client of matrix-nio, with our machine.

    Args:
        guard: Judges what was decrypted.
        knows: Whether somebody is known here.
        options: For matrix-nio.
    """

    def __init__(
        self,
        guard: ReplayGuard,
        knows: Callable[[str], bool],
        *where: str,
        **options: Any,  # noqa: ANN401 - matrix-nio has no types
    ) -> None:
        super().__init__(*where, **options)
        self._guard = guard
        self._knows = knows

    def load_store(self) -> None:
        """Open what is kept of the device's sessions."""
        kept = self.config
        self.store = kept.store(
            self.user_id, self.device_id, self.store_path, kept.pickle_key, kept.store_name
        )
        self.olm = OlmMachine(self.user_id, self.device_id, self.store, self._guard, self._knows)
        self.encrypted_rooms = self.store.load_encrypted_rooms()
