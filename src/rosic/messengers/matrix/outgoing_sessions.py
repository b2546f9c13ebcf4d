"""What is said in encrypted rooms; nobody has the key of it but whom the caller names.

A session of a room belongs to those who read along with it. When one of them may read no longer,
another one is begun; whoever comes later is given the key from there on. What anybody may read,
such as a step of a verification, is said in a session of its own: its key opens nothing else.

Matrix specification v1.11, client-server API: "m.megolm.v1.aes-sha2", ``POST
/_matrix/client/v3/keys/claim`` and ``PUT /_matrix/client/v3/sendToDevice``.
"""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final

from nio.crypto.device import OlmDevice
from nio.crypto.sessions import OutboundGroupSession

from rosic.messengers.matrix.olm_machine import MEGOLM
from rosic.messengers.matrix.signed_json import is_signed
from rosic.messengers.matrix.step_budget import StepBudget

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.messengers.matrix.olm_machine import OlmMachine
    from rosic.messengers.matrix.user_keys import Call, DeviceIdentity

CLAIM: Final = "/_matrix/client/v3/keys/claim"
TO_DEVICE: Final = "/_matrix/client/v3/sendToDevice/m.room.encrypted"
CLAIM_MS: Final = 10_000
AT_ONCE: Final = 20
"""Devices that are given a key in one call."""
ROOMS_AT_MOST: Final = 5_000
UNREACHABLE_NS: Final = 60 * 1_000_000_000
"""A device that has left no key to begin a session with is not asked for one again so long."""
UNREACHABLE_AT_MOST: Final = 2_000

log = logging.getLogger("rosic.messengers.matrix")


class RoomSession:
    """What is encrypted with in one room, for some readers.

    Attributes:
        shared: Identity keys of the devices that have its key.
    """

    def __init__(self) -> None:
        self.session = OutboundGroupSession()
        self.session.mark_as_shared()  # to whom stands here, and not with matrix-nio
        self.shared: set[str] = set()


class OutgoingSessions:
    """Encrypts for one device.

    Args:
        machine: Returns what has its keys.
        call: To the homeserver.
    """

    def __init__(self, machine: Callable[[], OlmMachine], call: Call, clock: Clock) -> None:
        self._machine = machine
        self._call = call
        self._clock = clock
        self._rooms: OrderedDict[tuple[str, bool], RoomSession] = OrderedDict()
        self._unreachable: OrderedDict[str, int] = OrderedDict()
        self._sharing = asyncio.Lock()

    async def encrypt(
        self,
        room: str,
        kind: str,
        content: Mapping[str, Any],
        readers: Collection[DeviceIdentity],
        *,
        public: bool,
    ) -> dict[str, Any]:
        """Return the content of an event that these devices can read, once they have its key.

        Args:
            room: Where it goes.
            kind: Of the event.
            content: Of the event; what it relates to goes in the open.
            readers: Who is given the key.
            public: Anybody may read it: the session is used for nothing else.

        Raises:
            MessengerFault: Nobody knows whether they have the key. Nothing is to be said.
        """
        machine = self._machine()
        async with self._sharing:
            one = self._session(room, readers, public=public)
            await self._share(room, one, readers)
            told = {"type": kind, "content": dict(content), "room_id": room}
            sealed: dict[str, Any] = {
                "algorithm": MEGOLM,
                "sender_key": machine.account.identity_keys["curve25519"],
                "ciphertext": one.session.encrypt(json.dumps(told)),
                "session_id": one.session.id,
                "device_id": machine.device_id,
            }
        relation = content.get("m.relates_to")
        return sealed if relation is None else {**sealed, "m.relates_to": relation}

    def _session(
        self, room: str, readers: Collection[DeviceIdentity], *, public: bool
    ) -> RoomSession:
        one = self._rooms.pop((room, public), None)
        may_read = {device.curve25519 for device in readers}
        if one is None or one.session.expired or not one.shared <= may_read:
            one = RoomSession()
            own = self._machine().account.identity_keys
            self._machine().create_group_session(
                own["curve25519"], own["ed25519"], room, one.session.id, one.session.session_key
            )
        self._rooms[room, public] = one
        while len(self._rooms) > ROOMS_AT_MOST:
            self._rooms.popitem(last=False)
        return one

    async def _share(
        self, room: str, one: RoomSession, readers: Collection[DeviceIdentity]
    ) -> None:
        missing = [device for device in readers if device.curve25519 not in one.shared]
        await self._begin_with(missing)
        content = {
            "algorithm": MEGOLM,
            "room_id": room,
            "session_id": one.session.id,
            "session_key": one.session.session_key,
        }
        await self._give(missing, "m.room_key", content, one.shared)

    async def _give(
        self,
        devices: Iterable[DeviceIdentity],
        kind: str,
        content: Mapping[str, Any],
        given: set[str],
    ) -> None:
        """Send the same to devices that a session was begun with, and note who has it."""
        limit, waiting = StepBudget(), list(devices)
        while waiting:
            some, waiting = waiting[:AT_ONCE], waiting[AT_ONCE:]
            messages: dict[str, dict[str, Any]] = {}
            reached = set()
            for device in some:
                sealed = self._sealed(device, kind, content)
                if sealed is not None:
                    messages.setdefault(device.user, {})[device.device] = sealed
                    reached.add(device.curve25519)
                await limit.give_way()
            if messages:
                path = f"{TO_DEVICE}/{secrets.token_urlsafe(16)}"
                await self._call("PUT", path, {"messages": messages})
                given |= reached

    def _sealed(
        self, device: DeviceIdentity, kind: str, content: Mapping[str, Any]
    ) -> dict[str, Any] | None:
        machine = self._machine()
        session = machine.olm_session(device.curve25519)
        if session is None:
            return None
        keys = {"ed25519": device.ed25519, "curve25519": device.curve25519}
        sealed: dict[str, Any] = machine._olm_encrypt(  # noqa: SLF001 - matrix-nio shows no other
            session, OlmDevice(device.user, device.device, keys), kind, dict(content)
        )
        return sealed

    # ---- sessions between two devices ----

    async def _begin_with(self, devices: Iterable[DeviceIdentity], *, anew: bool = False) -> None:
        """Begin a session with each device that there is none with and that can be reached."""
        machine, now_ns = self._machine(), self._clock.monotonic_ns()
        wanted = [
            device
            for device in devices
            if (anew or machine.olm_session(device.curve25519) is None)
            and self._unreachable.get(device.curve25519, 0) <= now_ns
        ]
        if not wanted:
            return
        asked: dict[str, dict[str, str]] = {}
        for device in wanted:
            asked.setdefault(device.user, {})[device.device] = "signed_curve25519"
        answer = await self._call("POST", CLAIM, {"one_time_keys": asked, "timeout": CLAIM_MS})
        limit = StepBudget()
        for device in wanted:
            key = _claimed(answer, device)
            if key is None:
                self._pass_over(device, now_ns + UNREACHABLE_NS)
            else:
                try:
                    machine.create_session(key, device.curve25519)
                except Exception as error:  # noqa: BLE001 - whatever a key can make it raise
                    log.info("no session with %s of %s: %s", device.device, device.user, error)
                    self._pass_over(device, now_ns + UNREACHABLE_NS)
            await limit.give_way()

    def _pass_over(self, device: DeviceIdentity, until_ns: int) -> None:
        self._unreachable[device.curve25519] = until_ns
        while len(self._unreachable) > UNREACHABLE_AT_MOST:
            self._unreachable.popitem(last=False)

    async def begin_anew(self, device: DeviceIdentity) -> None:
        """Begin another session with a device whose own does not work any more, and say so to it.

        Raises:
            MessengerFault: The homeserver did not answer.
        """
        async with self._sharing:
            await self._begin_with([device], anew=True)
            await self._give([device], "m.dummy", {}, set())


def _claimed(answer: Mapping[str, Any], device: DeviceIdentity) -> str | None:
    """Return a key to begin a session with that the device has signed itself; None for none."""
    found: Any = answer
    for name in ("one_time_keys", device.user, device.device):
        found = found.get(name) if isinstance(found, dict) else None
    keys = found.values() if isinstance(found, dict) else ()
    for shown in keys:
        if isinstance(shown, dict) and is_signed(shown, device.user, device.device, device.ed25519):
            key = shown.get("key")
            return key if isinstance(key, str) else None
    return None
