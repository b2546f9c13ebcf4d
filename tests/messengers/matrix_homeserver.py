"""A homeserver at the wire: what it answers is made by a test, what devices encrypt is real."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

import vodozemac
from aiohttp import web

from rosic.messengers.matrix.cross_signing import UPLOAD_KEYS, UPLOAD_SIGNATURES
from rosic.messengers.matrix.errors import MatrixError
from rosic.messengers.matrix.signed_json import signed_part, to_base64, with_signature
from rosic.messengers.matrix.user_keys import QUERY
from tests.messengers.matrix_identities import Client, Device, Homeserver, Person

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

Event = dict[str, Any]

ROBOTS: Final = "@robots:example.org"
DEVICE: Final = "ROBOTDEV"
API: Final = "/_matrix/client/v3"
OLM: Final = "m.olm.v1.curve25519-aes-sha2"
MEGOLM: Final = "m.megolm.v1.aes-sha2"
ENCRYPTION: Final[Event] = {"algorithm": MEGOLM}


class EncryptingDevice(Device):
    """A device that really encrypts, for rooms with the account of the robots."""

    def __init__(self, user: str, device: str) -> None:
        self.user = user
        self.device = device
        self.account = vodozemac.Account()
        self.ed25519 = self.account.ed25519_key.to_base64()
        self.curve25519 = self.account.curve25519_key.to_base64()
        self._olm: vodozemac.Session | None = None
        self._rooms: dict[str, vodozemac.GroupSession] = {}

    def sign(self, message: bytes) -> str:
        return str(self.account.sign(message).to_base64())

    def one_time_key(self) -> Event:
        self.account.generate_one_time_keys(1)
        ((name, key),) = self.account.one_time_keys.items()
        self.account.mark_keys_as_published()
        said = {"key": key.to_base64()}
        signature = self.sign(signed_part(said))
        return {
            f"signed_curve25519:{name}": with_signature(
                said, self.user, f"ed25519:{self.device}", signature
            )
        }

    def to_robots(
        self, server: WireHomeserver, kind: str, content: Event, **changed: object
    ) -> Event:
        """Return what is sent to the account's device, encrypted."""
        ed25519, curve25519 = server.robots_keys()
        if self._olm is None:
            key = vodozemac.Curve25519PublicKey.from_base64(server.robots_one_time_key())
            own = vodozemac.Curve25519PublicKey.from_base64(curve25519)
            self._olm = self.account.create_outbound_session(own, key)
        payload = {
            "sender": self.user,
            "sender_device": self.device,
            "keys": {"ed25519": self.ed25519},
            "recipient": ROBOTS,
            "recipient_keys": {"ed25519": ed25519},
            "type": kind,
            "content": content,
        } | changed
        number, sealed = self._olm.encrypt(json.dumps(payload).encode()).to_parts()
        return {
            "type": "m.room.encrypted",
            "sender": self.user,
            "content": {
                "algorithm": OLM,
                "sender_key": self.curve25519,
                "ciphertext": {curve25519: {"type": number, "body": to_base64(sealed)}},
            },
        }

    def begins(self, room: str) -> None:
        """Begin a session for a room, with nobody told of it."""
        self._rooms[room] = vodozemac.GroupSession()

    def room_key(self, server: WireHomeserver, room: str, **changed: object) -> Event:
        """Return the key of the room's session, for the account's device."""
        if room not in self._rooms:
            self.begins(room)
        session = self._rooms[room]
        content = {
            "algorithm": MEGOLM,
            "room_id": room,
            "session_id": session.session_id,
            "session_key": session.session_key.to_base64(),
        }
        return self.to_robots(server, "m.room_key", content | changed)

    def sealed(self, room: str, content: Event, **changed: object) -> Event:
        """Return the content of a message in a room, encrypted."""
        session = self._rooms[room]
        told = {"type": "m.room.message", "content": content, "room_id": room} | changed
        return {
            "algorithm": MEGOLM,
            "sender_key": self.curve25519,
            "ciphertext": session.encrypt(json.dumps(told).encode()).to_base64(),
            "session_id": session.session_id,
            "device_id": self.device,
        }


class Owner(Person):
    """Somebody with cross-signing keys and a device that really encrypts."""

    def __init__(self, user: str, device: str = "PHONE") -> None:
        super().__init__(user, device)
        self.phone: EncryptingDevice = EncryptingDevice(user, device)


def text(body: str) -> Event:
    return {"msgtype": "m.text", "body": body}


class WireHomeserver:
    """Answers one account.

    Attributes:
        url: Where it listens.
        keys: What it shows of keys; a test makes it lie there.
        devices: Those that can be written to.
        sent: What was said in rooms: room, type, content.
        given: Which devices were given something: user, device.
        asked: Every request: method and path.
        messages: What it has left out of rooms: returns an answer, or None for none.
        now_ms: Its clock.
    """

    def __init__(self) -> None:
        self.url = ""
        self.keys = Homeserver()
        self.devices: dict[tuple[str, str], EncryptingDevice] = {}
        self.sent: list[tuple[str, str, Event]] = []
        self.given: list[tuple[str, str]] = []
        self.asked: list[tuple[str, str]] = []
        self.messages: Callable[[str], Event | None] = _nothing
        self.now_ms = 0
        self._client = Client(self.keys, ROBOTS)
        self._one_time: list[Event] = []
        self._answers: asyncio.Queue[bytes] = asyncio.Queue()
        self._number = 0
        self._taken = 0
        self._moved = asyncio.Condition()

    @asynccontextmanager
    async def running(self) -> AsyncIterator[WireHomeserver]:
        app = web.Application(client_max_size=2**25)
        app.router.add_route("*", "/{path:.*}", self._serve)
        runner = web.AppRunner(app, shutdown_timeout=0.1)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        self.url = f"http://127.0.0.1:{runner.addresses[0][1]}"
        try:
            yield self
        finally:
            await runner.cleanup()

    def knows(self, owner: Owner) -> None:
        """Show a person's keys, and take what is sent to their device."""
        self.keys.knows(owner)
        self.devices[owner.user, owner.phone.device] = owner.phone

    def adds(self, device: EncryptingDevice) -> None:
        """Show one more device of somebody, which nobody vouches for."""
        self.keys.add(device)
        self.devices[device.user, device.device] = device

    def robots_keys(self) -> tuple[str, str]:
        """Return fingerprint and identity key of the account's device."""
        shown = self.keys.shown["device_keys"][ROBOTS][DEVICE]["keys"]
        return shown[f"ed25519:{DEVICE}"], shown[f"curve25519:{DEVICE}"]

    def robots_one_time_key(self) -> str:
        return str(self._one_time.pop()["key"])

    # ---- syncs ----

    def gives(self, answer: Event) -> int:
        """Answer a sync so; return the number that `taken` waits for."""
        self._number += 1
        self._answers.put_nowait(_written(answer | {"next_batch": f"s{self._number}"}))
        return self._number

    async def taken(self, number: int) -> None:
        """Wait until what came after an answer is asked for: until it was taken apart."""
        async with self._moved:
            await self._moved.wait_for(lambda: self._taken >= number)

    async def _sync(self, request: web.Request) -> bytes:
        since = request.query.get("since", "")
        async with self._moved:
            self._taken = max(self._taken, int(since[1:] or 0))
            self._moved.notify_all()
        if not since and self._answers.empty():
            return _written({"next_batch": "s0"})
        wait_s = int(request.query["timeout"]) / 1_000
        try:
            async with asyncio.timeout(wait_s or 0.001):
                return await self._answers.get()
        except TimeoutError:
            return _written({"next_batch": since})

    # ---- everything else ----

    async def _serve(self, request: web.Request) -> web.Response:
        path = request.path.removeprefix(API)
        self.asked.append((request.method, path))
        try:
            said = await self._answer(request, path)
        except MatrixError as refused:
            return web.json_response(dict(refused.body), status=401)
        if said is None:
            return web.json_response({"errcode": "M_NOT_FOUND"}, status=404)
        body = said if isinstance(said, bytes) else _written(said)
        return web.Response(body=body, content_type="application/json")

    async def _answer(self, request: web.Request, path: str) -> Event | bytes | None:
        if path == "/sync":
            return await self._sync(request)
        if path.endswith("/messages"):
            return self.messages(request.path.split("/")[5])
        body = await request.json() if request.can_read_body else {}
        if path.startswith("/sendToDevice/"):
            self.given += [(u, d) for u, of in body["messages"].items() for d in of]
            return {}
        if path.startswith("/rooms/") and request.method == "PUT":
            parts = request.path.split("/")
            self.sent.append((parts[5], parts[7], body))
            return {"event_id": f"$sent{len(self.sent)}"}
        if path.startswith(("/rooms/", "/join/")):
            return {} if request.method == "POST" else None
        return await self._of_keys(path, body)

    async def _of_keys(self, path: str, body: Event) -> Event | None:
        if path == "/login":
            return {"user_id": ROBOTS, "device_id": DEVICE, "access_token": "token"}
        if path == "/keys/upload":
            if "device_keys" in body:
                self.keys.shown["device_keys"].setdefault(ROBOTS, {})[DEVICE] = body["device_keys"]
            self._one_time += body.get("one_time_keys", {}).values()
            return {"one_time_key_counts": {"signed_curve25519": 50}}
        if path == "/keys/claim":
            return {"one_time_keys": self._claimed(body["one_time_keys"])}
        if f"{API}{path}" in {QUERY, UPLOAD_KEYS, UPLOAD_SIGNATURES}:
            return await self._client("POST", f"{API}{path}", body)
        return {"m.upload.size": 1_000_000} if path.endswith("config") else None

    def _claimed(self, asked: dict[str, dict[str, str]]) -> Event:
        found: Event = {}
        for user, devices in asked.items():
            for device in devices:
                if (user, device) in self.devices:
                    one = self.devices[user, device].one_time_key()
                    found.setdefault(user, {})[device] = one
        return found


def _nothing(_room: str) -> Event | None:
    return None


def _written(said: Event) -> bytes:
    return json.dumps(said).encode()
