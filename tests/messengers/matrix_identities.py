"""People, their devices and their keys, and a homeserver as honest as it is told to be."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

from nacl.public import PrivateKey
from nacl.signing import SigningKey

from rosic.errors import MessengerFault
from rosic.messengers.matrix.cross_signing import (
    UPLOAD_KEYS,
    UPLOAD_SIGNATURES,
    CrossSigning,
)
from rosic.messengers.matrix.errors import refusal
from rosic.messengers.matrix.signed_json import (
    ED25519,
    is_signed,
    public_part,
    sign,
    signed_part,
    to_base64,
    with_signature,
)
from rosic.messengers.matrix.signing_keys import key_object
from rosic.messengers.matrix.user_keys import (
    MASTER,
    QUERY,
    SELF_SIGNING,
    USER_SIGNING,
    KeyDirectory,
    UserKeys,
)

if TYPE_CHECKING:
    from rosic.messengers.matrix.identity_book import KeyChange
    from rosic.messengers.matrix.user_keys import DeviceIdentity

ROBOT = "@robot:example.org"
ADA = "@ada:example.org"
EVE = "@eve:example.org"


class Device:
    """A device with its keys; it signs as matrix-nio's account does."""

    def __init__(self, user: str, device: str) -> None:
        self.user = user
        self.device = device
        self.key = SigningKey.generate()
        self.ed25519 = public_part(self.key)
        self.curve25519 = to_base64(bytes(PrivateKey.generate().public_key))

    def sign(self, message: bytes) -> str:
        return to_base64(self.key.sign(message).signature)

    def shown(self, **changed: object) -> dict[str, Any]:
        """Return its keys as it publishes them, signed by itself; or others, signed like them."""
        said = {
            "user_id": self.user,
            "device_id": self.device,
            "algorithms": ["m.olm.v1.curve25519-aes-sha2", "m.megolm.v1.aes-sha2"],
            "keys": {
                f"{ED25519}:{self.device}": self.ed25519,
                f"curve25519:{self.device}": self.curve25519,
            },
            **changed,
        }
        signature = self.sign(signed_part(said))
        return with_signature(said, self.user, f"{ED25519}:{self.device}", signature)


class Person:
    """Somebody with a master key, a self-signing key and one device that it vouches for."""

    def __init__(self, user: str, device: str = "PHONE") -> None:
        self.user = user
        self.master = SigningKey.generate()
        self.self_signing = SigningKey.generate()
        self.phone = Device(user, device)

    @property
    def master_public(self) -> str:
        return public_part(self.master)

    def shown_master(self) -> dict[str, Any]:
        return key_object(self.user, MASTER, self.master_public)

    def shown_self_signing(self) -> dict[str, Any]:
        said = key_object(self.user, SELF_SIGNING, public_part(self.self_signing))
        return sign(said, self.user, self.master)

    def vouched(self, device: Device) -> dict[str, Any]:
        return sign(device.shown(), self.user, self.self_signing)

    def shown(self) -> dict[str, Any]:
        """Return the answer to a query for this person's keys."""
        return {
            "master_keys": {self.user: self.shown_master()},
            "self_signing_keys": {self.user: self.shown_self_signing()},
            "device_keys": {self.user: {self.phone.device: self.vouched(self.phone)}},
        }

    def keys(self, **tables: dict[str, Any]) -> UserKeys:
        """Return what comes of it, with some of it changed for this person."""
        shown = self.shown()
        for table, of_user in tables.items():
            shown[table] = {self.user: of_user}
        return UserKeys(self.user, shown)


class Homeserver:
    """Keeps keys as a homeserver does, and takes no signature that is not one.

    Attributes:
        shown: What it shows, by table and user; a test makes it lie here.
        calls: The paths that were asked for.
        away: It does not answer.
        asks_for: The password that it wants once more before it takes cross-signing keys.
        stages: In which way.
    """

    def __init__(self) -> None:
        self.shown: dict[str, dict[str, Any]] = {
            "master_keys": {},
            "self_signing_keys": {},
            "user_signing_keys": {},
            "device_keys": {},
        }
        self.calls: list[str] = []
        self.away = False
        self.asks_for = ""
        self.stages = ["m.login.password"]

    def knows(self, person: Person) -> None:
        for table, of_user in person.shown().items():
            self.shown[table] |= of_user

    def add(self, device: Device) -> None:
        self.shown["device_keys"].setdefault(device.user, {})[device.device] = device.shown()

    def as_user(self, user: str) -> Client:
        return Client(self, user)


class Client:
    """Somebody's way to it."""

    def __init__(self, homeserver: Homeserver, user: str) -> None:
        self.homeserver = homeserver
        self.user = user

    async def __call__(self, method: str, path: str, body: dict[str, Any]) -> dict[str, Any]:
        assert method == "POST"
        self.homeserver.calls.append(path)
        if self.homeserver.away:
            raise MessengerFault("The homeserver cannot be reached.")
        return copy.deepcopy(self._answer(path, copy.deepcopy(body)))

    def _answer(self, path: str, body: dict[str, Any]) -> dict[str, Any]:
        if path == QUERY:
            return self._query(body)
        if path == UPLOAD_KEYS:
            return self._upload_keys(body)
        assert path == UPLOAD_SIGNATURES
        return self._upload_signatures(body)

    def _query(self, body: dict[str, Any]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for table, of_all in self.homeserver.shown.items():
            asked = [user for user in body["device_keys"] if user in of_all]
            private = table == "user_signing_keys"
            found[table] = {
                user: of_all[user] for user in asked if not private or user == self.user
            }
        return found

    def _upload_keys(self, body: dict[str, Any]) -> dict[str, Any]:
        server = self.homeserver
        if server.asks_for and body.get("auth", {}).get("password") != server.asks_for:
            flows = [{"stages": server.stages}]
            raise refusal(401, {"session": "s", "flows": flows, "params": {}})
        if server.asks_for:
            assert body["auth"]["session"] == "s"
            assert body["auth"]["identifier"] == {"type": "m.id.user", "user": self.user}
        master = next(iter(body["master_key"]["keys"].values()))
        for name, usage in (("self_signing_key", SELF_SIGNING), ("user_signing_key", USER_SIGNING)):
            assert body[name]["usage"] == [usage]
            assert is_signed(body[name], self.user, master, master)
            server.shown[f"{name}s"][self.user] = body[name]
        server.shown["master_keys"][self.user] = body["master_key"]
        return {}

    def _upload_signatures(self, body: dict[str, Any]) -> dict[str, Any]:
        failures: dict[str, Any] = {}
        for user, objects in body.items():
            for name, signed in objects.items():
                if not self._signed(user, name, signed):
                    failures.setdefault(user, {})[name] = {"errcode": "M_INVALID_SIGNATURE"}
        return {"failures": failures}

    def _signed(self, user: str, name: str, signed: dict[str, Any]) -> bool:
        shown = self.homeserver.shown
        kept = shown["device_keys"].get(user, {}).get(name) or shown["master_keys"].get(user)
        if kept is None or signed_part(kept) != signed_part(signed):
            return False
        for key_id, signature in signed["signatures"][self.user].items():
            key = self._key(key_id.partition(":")[2])
            if not is_signed(signed, self.user, key_id.partition(":")[2], key):
                return False
            kept.setdefault("signatures", {}).setdefault(self.user, {})[key_id] = signature
        return True

    def _key(self, name: str) -> str:
        device = self.homeserver.shown["device_keys"].get(self.user, {}).get(name)
        return device["keys"][f"{ED25519}:{name}"] if device else name


class Folder:
    """Keeps files in memory.

    Attributes:
        full: Nothing can be written.
    """

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.full = False

    def read(self, name: str) -> bytes | None:
        return self.files.get(name)

    def write(self, name: str, content: bytes) -> None:
        if self.full:
            raise OSError("no space left on device")
        self.files[name] = content


class Account:
    """A device of the robot, at a homeserver, with a folder.

    Attributes:
        told: What people heard of keys.
    """

    def __init__(
        self, homeserver: Homeserver, device: Device, folder: Folder | None = None
    ) -> None:
        self.homeserver = homeserver
        self.device = device
        self.folder = folder or Folder()
        self.told: list[KeyChange] = []
        client = homeserver.as_user(device.user)
        self.directory = KeyDirectory(client)
        self.cross_signing = CrossSigning(
            device, client, self.folder, self.directory, self.told.append, knows=everybody
        )


def everybody(_user: str) -> bool:
    """Whoever it is: they are known."""
    return True


def robot_account(homeserver: Homeserver | None = None) -> Account:
    """Return the robot's account, with a device that the homeserver knows."""
    homeserver = homeserver or Homeserver()
    device = Device(ROBOT, "ROBOTDEV")
    homeserver.add(device)
    return Account(homeserver, device)


def restarted(account: Account) -> Account:
    """Return the same device with the same folder, in another run."""
    return Account(account.homeserver, account.device, account.folder)


async def met(account: Account, person: Person) -> DeviceIdentity:
    """Have the robot know a person's keys, and return their phone."""
    account.homeserver.knows(person)
    account.directory.forget(person.user)
    keys, _ = await account.cross_signing.look_up(person.user)
    phone = keys.device(person.phone.device)
    assert phone is not None
    return phone
