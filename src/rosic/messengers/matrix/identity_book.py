"""Whose keys were compared, and whose have changed since.

Matrix specification v1.11, client-server API, "Cross-signing": a client must notice that a master
key changed. Nothing here asks anybody; what is written in it is kept sealed by its owner.
"""

from __future__ import annotations

import enum
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import msgspec

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.messengers.matrix.user_keys import DeviceIdentity, UserKeys

STRANGERS_AT_MOST: Final = 2_000
"""Strangers whose key was merely seen. Whoever is known to ROSIC is never let go, nor whose key was
compared: strangers come without end."""
DEVICES_AT_MOST: Final = 50
ROOMS_AT_MOST: Final = 5_000


class IdentityStanding(enum.IntEnum):
    """What a person's master key is worth."""

    REPLACED = 0
    """It is not the one that was seen or compared before. Nothing of theirs counts."""
    NONE = 1
    """They have none."""
    FIRST_SEEN = 2
    """It is the one that was seen first. Nobody has compared it."""
    COMPARED = 3
    """Two people have compared it, by emoji."""


class KeyChangeKind(enum.Enum):
    """What is told about a person's keys."""

    NEW_DEVICE = "new device"
    MASTER_REPLACED = "master replaced"


class KeyChange(msgspec.Struct, frozen=True, kw_only=True):
    """Something about a person's keys that people must hear of.

    Attributes:
        device: Which is new; empty for none.
        vouched: The person's own keys vouch for that device.
        compared: The key that was replaced had been compared by two people.
    """

    kind: KeyChangeKind
    user: str
    device: str = ""
    vouched: bool = False
    compared: bool = False


class KnownIdentity(msgspec.Struct, kw_only=True, omit_defaults=True):
    """What is kept about one person.

    Attributes:
        master: The key that counts; empty: none was ever seen.
        compared: It was compared.
        other: The last key that was shown instead, and refused.
        devices: Those that were told of, by name: their fingerprints; None: nobody has looked yet,
            and those that are there already are nothing new.
        compared_devices: Those whose own fingerprint was compared.
    """

    master: str = ""
    compared: bool = False
    other: str = ""
    devices: dict[str, str] | None = None
    compared_devices: dict[str, str] = {}


class _Kept(msgspec.Struct, kw_only=True):
    """As it is written down; bound to whose it is."""

    owner: str
    people: dict[str, KnownIdentity]
    rooms: list[str] = []


class IdentityBook:
    """What one account knows about the keys of others.

    Args:
        owner: The account.
        knows: Whether somebody is known to ROSIC.

    Attributes:
        version: Another one after anything has changed.
    """

    def __init__(self, owner: str, knows: Callable[[str], bool]) -> None:
        self.version = 0
        self._owner = owner
        self._knows = knows
        self._people: dict[str, KnownIdentity] = {}
        self._strangers: OrderedDict[str, None] = OrderedDict()
        self._rooms: dict[str, None] = {}

    def restore(self, content: bytes) -> None:
        """Go on with what was written down.

        Raises:
            ValueError: It is not such a book, or another account's.
        """
        kept = msgspec.json.decode(content, type=_Kept)
        if kept.owner != self._owner:
            raise ValueError("another account's")
        self._people = kept.people
        self._strangers = OrderedDict.fromkeys(u for u in kept.people if not self._knows(u))
        self._rooms = dict.fromkeys(kept.rooms)
        self.version += 1

    def content(self) -> bytes:
        """Return all of it, to be written down."""
        kept = _Kept(owner=self._owner, people=self._people, rooms=list(self._rooms))
        return msgspec.json.encode(kept)

    def knows(self, user: str) -> bool:
        """Whether anything is written here of a person."""
        return user in self._people

    def was_compared(self, user: str) -> bool:
        """Whether two people have compared keys of this person, and nobody has taken it back."""
        known = self._people.get(user)
        return known is not None and (known.compared or bool(known.compared_devices))

    def is_confidential(self, room: str) -> bool:
        """Whether somebody whose keys were compared was ever spoken to in a room."""
        return room in self._rooms

    def make_confidential(self, room: str) -> bool:
        """Note that of a room; True where it is new, and to be written down."""
        if room in self._rooms:
            return False
        self._rooms[room] = None
        while len(self._rooms) > ROOMS_AT_MOST:
            del self._rooms[next(iter(self._rooms))]
        return True

    def standing(self, user: str, master: str) -> IdentityStanding:
        """Return what a master key is worth that was shown for a person just now."""
        known = self._people.get(user)
        if known is None or not known.master:
            return IdentityStanding.FIRST_SEEN if master else IdentityStanding.NONE
        if known.master != master:
            return IdentityStanding.REPLACED
        return IdentityStanding.COMPARED if known.compared else IdentityStanding.FIRST_SEEN

    def is_compared(self, user: str) -> bool:
        """Whether a person's master key was compared, and no other was shown since."""
        known = self._people.get(user)
        return known is not None and known.compared and not known.other

    def is_compared_device(self, device: DeviceIdentity) -> bool:
        """Whether this device's own fingerprint was compared."""
        known = self._people.get(device.user)
        return known is not None and (known.compared_devices.get(device.device) == device.ed25519)

    def observe(self, keys: UserKeys) -> tuple[tuple[KeyChange, ...], bool]:
        """Take note of what is shown of a person's keys.

        Returns:
            What people must hear of, each once; and whether anything is to be written down.
        """
        friend = self._knows(keys.user)
        known = self._people.setdefault(keys.user, KnownIdentity())
        self._bound(keys.user, known, friend=friend)
        changes = [*self._of_master(known, keys)]
        first = not known.master and bool(keys.master)
        if first:
            known.master = keys.master
        if friend or keys.user == self._owner:  # nobody is told of strangers' devices
            if known.devices is None:
                known.devices, first = _fingerprints(keys), True
            changes += self._of_devices(known.devices, keys)
        if changes or first:
            self.version += 1
        return tuple(changes), bool(changes) or first

    def compared(self, user: str, master: str) -> None:
        """Two people have compared this key: it counts from now on, and no other."""
        known = self._people.setdefault(user, KnownIdentity())
        if known.master != master:
            known.compared_devices = {}
        known.master, known.compared, known.other = master, True, ""
        self.version += 1

    def compared_device(self, device: DeviceIdentity) -> None:
        """Two people have compared this device's fingerprint."""
        known = self._people.setdefault(device.user, KnownIdentity())
        known.compared_devices[device.device] = device.ed25519
        self.version += 1

    def revoke(self, user: str) -> None:
        """What was compared of this person counts no longer: a phone was lost, for instance."""
        known = self._people.get(user)
        if known is not None:
            known.compared, known.compared_devices = False, {}
            self.version += 1

    @staticmethod
    def _of_master(known: KnownIdentity, keys: UserKeys) -> list[KeyChange]:
        """Tell once of each key that is shown in place of the one that counts.

        One that is shown no more is told of like one that was replaced: a homeserver that hides
        it wants something.
        """
        if not known.master or keys.master in {known.master, known.other or known.master}:
            return []
        if not keys.master and known.other == _HIDDEN:
            return []
        known.other = keys.master or _HIDDEN
        kind = KeyChangeKind.MASTER_REPLACED
        return [KeyChange(kind=kind, user=keys.user, compared=known.compared)]

    @staticmethod
    def _of_devices(told: dict[str, str], keys: UserKeys) -> list[KeyChange]:
        """Tell once of each device, and again when another key stands under its name."""
        changed = [name for name in keys.devices() if told.get(name) != keys.fingerprint(name)]
        changes = []
        for name in changed[: max(0, DEVICES_AT_MOST - len(told))]:
            device = keys.device(name)
            if device is not None:
                told[name] = device.ed25519
                kind, vouched = KeyChangeKind.NEW_DEVICE, device.cross_signed
                changes.append(KeyChange(kind=kind, user=keys.user, device=name, vouched=vouched))
        return changes

    def _bound(self, user: str, known: KnownIdentity, *, friend: bool) -> None:
        """Let go of strangers who were seen first and never compared."""
        if friend or known.compared or known.compared_devices:
            self._strangers.pop(user, None)
            return
        self._strangers.setdefault(user)
        while len(self._strangers) > STRANGERS_AT_MOST:
            oldest, _ = self._strangers.popitem(last=False)
            seen = self._people.get(oldest)
            if seen is None or self._knows(oldest) or self.was_compared(oldest):
                continue  # they have become known since
            del self._people[oldest]


_HIDDEN: Final = "-"


def _fingerprints(keys: UserKeys) -> dict[str, str]:
    found = (keys.device(name) for name in keys.devices()[:DEVICES_AT_MOST])
    return {device.device: device.ed25519 for device in found if device is not None}
