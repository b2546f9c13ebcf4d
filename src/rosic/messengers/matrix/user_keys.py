"""What a homeserver shows of a person's keys, and what of it that person has signed.

Matrix specification v1.11, client-server API: "Device keys", "Cross-signing" and ``POST
/_matrix/client/v3/keys/query``. A homeserver can show anything; here is what it cannot make up:

    master key ---signs---> self-signing key ---signs---> the person's devices

Whether the master key is really that person's stands elsewhere (`identity_book`).
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from typing import Any, Final, TypeAlias

import msgspec

from rosic.errors import MessengerFault
from rosic.messengers.matrix.signed_json import (
    ED25519,
    KEY_BYTES,
    LONGEST,
    from_base64,
    is_signed,
)
from rosic.messengers.matrix.step_budget import StepBudget

MASTER: Final = "master"
SELF_SIGNING: Final = "self_signing"
USER_SIGNING: Final = "user_signing"
CURVE25519: Final = "curve25519"
QUERY: Final = "/_matrix/client/v3/keys/query"
QUERY_TIMEOUT_MS: Final = 10_000
KEPT_AT_MOST: Final = 2_000
KEPT_BYTES: Final = 16 * 2**20
"""Of what is kept of all people together, as it was shown."""
DEVICES_AT_MOST: Final = 200
"""Of one person. What is shown beyond that is not there: a homeserver may show any number."""
CHECKED_AHEAD: Final = 50
"""Devices of one person that are checked when they are shown, in short steps."""
AT_ONCE: Final = 20
"""People who are asked for in one call."""
SIGNED_WITH_CURVE_AT_MOST: Final = 4
"""Devices of one person that claim one identity key; honestly there is one."""

Call: TypeAlias = Callable[[str, str, dict[str, Any]], Awaitable[dict[str, Any]]]
"""One authenticated call to the homeserver: method, path, body. It returns the JSON of the answer,
and raises ``MatrixError`` for one that is no success."""


class DeviceIdentity(msgspec.Struct, frozen=True, kw_only=True):
    """One device, with keys that the device itself has signed.

    Attributes:
        ed25519: Its fingerprint.
        curve25519: What its sessions are set up with: the ``sender_key`` of what it encrypts.
        cross_signed: The person's self-signing key vouches for it, and their master key for that.
    """

    user: str
    device: str
    ed25519: str
    curve25519: str
    cross_signed: bool


class UserKeys:
    """What was shown of one person's keys. Nothing of it counts before it was checked.

    Devices are checked when they are asked for, not all of them at once.

    Attributes:
        master: Base64 of the person's master key; empty: none that is sound was shown.
        self_signing: The key that vouches for devices; empty: none that the master key has signed.
        user_signing: The key that vouches for others; shown to its owner alone.
        size: How many bytes of it are kept.
        master_object: The master key as it was shown, for signatures of others on it.
    """

    def __init__(self, user: str, shown: Mapping[str, Any]) -> None:
        self.user = user
        self.master_object = _object(shown, "master_keys", user)
        self.master = _cross_signing_key(self.master_object, user, MASTER)
        self.self_signing = self._vouched(_object(shown, "self_signing_keys", user), SELF_SIGNING)
        self.user_signing = self._vouched(_object(shown, "user_signing_keys", user), USER_SIGNING)
        devices = islice(_object(shown, "device_keys", user).items(), DEVICES_AT_MOST)
        sizes = [(name, of, len(msgspec.json.encode(of))) for name, of in devices]
        self._devices = {name: of for name, of, size in sizes if size <= LONGEST}
        self.size = sum(size for _, _, size in sizes if size <= LONGEST)
        self._checked: dict[str, DeviceIdentity | None] = {}

    def device(self, device: str) -> DeviceIdentity | None:
        """Return a device whose keys are sound; None: there is none of that name."""
        if device not in self._devices:
            return None
        if device not in self._checked:
            shown = self._devices[device]
            self._checked[device] = self._check(device, shown) if isinstance(shown, dict) else None
        return self._checked[device]

    def devices(self) -> tuple[str, ...]:
        """Return the names of all that were shown, checked or not."""
        return tuple(name for name, shown in self._devices.items() if isinstance(shown, dict))

    def device_with(self, sender_key: str) -> DeviceIdentity | None:
        """Return the device that has this identity key and signed that it has; None for none."""
        named = [
            name
            for name, shown in self._devices.items()
            if isinstance(shown, dict) and _key(shown, CURVE25519, name) == sender_key
        ]
        found = (self.device(name) for name in named[:SIGNED_WITH_CURVE_AT_MOST])
        sound = [device for device in found if device is not None]
        return max(sound, key=lambda device: device.cross_signed, default=None)

    def fingerprint(self, device: str) -> str:
        """Return the fingerprint that a device was shown with, unchecked; empty for none."""
        return _key(self.shown_device(device), ED25519, device)

    def sender_keys(self) -> set[str]:
        """Return the identity keys that devices were shown with. None of them is checked."""
        found = {_key(self.shown_device(name), CURVE25519, name) for name in self._devices}
        return found - {""}

    def shown_device(self, device: str) -> dict[str, Any]:
        """Return a device as it was shown; empty for none. Nothing of it is checked."""
        shown = self._devices.get(device)
        return shown if isinstance(shown, dict) else {}

    def master_signed_by(self, user: str, name: str, public: str) -> bool:
        """Whether a key signed this person's master key."""
        return bool(self.master) and is_signed(self.master_object, user, name, public)

    def _vouched(self, shown: dict[str, Any], usage: str) -> str:
        key = _cross_signing_key(shown, self.user, usage)
        signed = self.master and is_signed(shown, self.user, self.master, self.master)
        return key if key and key != self.master and signed else ""

    def _check(self, device: str, shown: dict[str, Any]) -> DeviceIdentity | None:
        ed25519 = _key(shown, ED25519, device)
        curve25519 = _key(shown, CURVE25519, device)
        whose = (shown.get("user_id"), shown.get("device_id"))
        if not ed25519 or not curve25519 or whose != (self.user, device):
            return None
        if self._is_key_name(device) or not is_signed(shown, self.user, device, ed25519):
            return None
        vouched = self.self_signing and is_signed(
            shown, self.user, self.self_signing, self.self_signing
        )
        return DeviceIdentity(
            user=self.user,
            device=device,
            ed25519=ed25519,
            curve25519=curve25519,
            cross_signed=bool(vouched),
        )

    def _is_key_name(self, device: str) -> bool:
        """Whether a device is called like a key of the person: the two share one space of names.

        A homeserver names devices, and could have a device's key taken for a master key so.
        """
        return bool(device) and device in {self.master, self.self_signing, self.user_signing}


def _object(shown: Mapping[str, Any], table: str, user: str) -> dict[str, Any]:
    of_all = shown.get(table)
    found = of_all.get(user) if isinstance(of_all, Mapping) else None
    return found if isinstance(found, dict) else {}


def _key(shown: Mapping[str, Any], algorithm: str, name: str) -> str:
    """Return a key by its algorithm and name, if it is one; else empty."""
    keys = shown.get("keys")
    key = keys.get(f"{algorithm}:{name}") if isinstance(keys, Mapping) else None
    return key if isinstance(key, str) and from_base64(key, KEY_BYTES) is not None else ""


def _cross_signing_key(shown: Mapping[str, Any], user: str, usage: str) -> str:
    """Return a cross-signing key that is named by itself, is that user's, and is for this use.

    "Key objects": ``keys`` has exactly one entry, whose name is ``ed25519:`` and the key itself.
    """
    keys, usages = shown.get("keys"), shown.get("usage")
    if shown.get("user_id") != user or not isinstance(usages, list) or usage not in usages:
        return ""
    if not isinstance(keys, Mapping) or len(keys) != 1:
        return ""
    key = next(iter(keys.values()))
    return _key(shown, ED25519, key) if isinstance(key, str) else ""


class KeyDirectory:
    """Asks the homeserver for keys, and keeps what it showed until it says that they changed.

    Args:
        call: To the homeserver.

    Attributes:
        version: Another one after anything was shown anew, or is to be asked for.
    """

    def __init__(self, call: Call) -> None:
        self.version = 0
        self._call = call
        self._kept: dict[str, UserKeys] = {}
        self._bytes = 0
        self._stale: set[str] = set()
        self._changes = 0
        self._owners: dict[str, set[str]] = {}

    async def keys_of(self, user: str, *, fresh: bool = False) -> UserKeys:
        """Return what is shown of a person's keys: what is kept, if nobody said it changed.

        Raises:
            MessengerFault: The homeserver did not answer. Nothing is known anew.
        """
        kept = self._kept.get(user)
        if kept is not None and not fresh and user not in self._stale:
            return kept
        (keys,) = await self._ask((user,))
        return keys

    async def keys_of_all(self, users: Iterable[str]) -> list[UserKeys]:
        """Return the same of many people; of whom the homeserver does not answer, nothing."""
        found: list[UserKeys] = []
        missing: list[str] = []
        for user in users:
            kept = self._kept.get(user)
            if kept is None or user in self._stale:
                missing.append(user)
            else:
                found.append(kept)
        for at in range(0, len(missing), AT_ONCE):
            some = missing[at : at + AT_ONCE]
            try:
                found += await self._ask(some)
            except MessengerFault:
                for user in some:  # one of them may be shown with more than can be read
                    with suppress(MessengerFault):
                        found += await self._ask((user,))
        return found

    async def _ask(self, users: Sequence[str]) -> list[UserKeys]:
        changes = self._changes
        body: dict[str, Any] = {
            "device_keys": {user: [] for user in users},
            "timeout": QUERY_TIMEOUT_MS,
        }
        answer = await self._call("POST", QUERY, body)
        limit, found = StepBudget(), []
        for user in users:
            keys = UserKeys(user, answer)
            for name in keys.devices()[:CHECKED_AHEAD]:
                keys.device(name)
                await limit.give_way()
            self._keep(keys)
            if changes != self._changes:
                self._stale.add(user)
            found.append(keys)
        return found

    def forget(self, user: str) -> None:
        """Ask anew next time: ``device_lists`` of a ``/sync`` named this person."""
        self._changes += 1
        self.version += 1
        if user in self._kept:
            self._stale.add(user)

    def forget_all(self) -> None:
        """Ask anew for everybody: what ``device_lists`` said was missed."""
        self._changes += 1
        self.version += 1
        self._stale.update(self._kept)

    def claimants(self, sender_key: str) -> frozenset[str]:
        """Return whose devices were shown with this identity key, as far as anybody was asked for.

        Whoever merely claims it is among them: it takes no signature to be here.
        """
        return frozenset(self._owners.get(sender_key, ()))

    def _keep(self, keys: UserKeys) -> None:
        self._drop(keys.user)
        self.version += 1
        self._kept[keys.user] = keys
        self._bytes += keys.size
        while len(self._kept) > KEPT_AT_MOST or self._bytes > KEPT_BYTES:
            self._drop(next(iter(self._kept)))
        if keys.user not in self._kept:
            return
        for curve25519 in keys.sender_keys():
            self._owners.setdefault(curve25519, set()).add(keys.user)

    def _drop(self, user: str) -> None:
        keys = self._kept.pop(user, None)
        self._bytes -= 0 if keys is None else keys.size
        self._stale.discard(user)
        for curve25519 in keys.sender_keys() if keys is not None else ():
            owners = self._owners.get(curve25519, set())
            owners.discard(user)
            if not owners:
                self._owners.pop(curve25519, None)
