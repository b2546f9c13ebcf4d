"""Who is given the keys of what ROSIC says in a room: never whoever a homeserver adds to it."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.messengers.matrix.trust import withheld_devices

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.messengers.matrix.cross_signing import CrossSigning
    from rosic.messengers.matrix.identity_book import IdentityStanding
    from rosic.messengers.matrix.room_table import JoinedRoom
    from rosic.messengers.matrix.settings import MatrixSettings
    from rosic.messengers.matrix.user_keys import DeviceIdentity, UserKeys

PEOPLE_AT_MOST: Final = 1_000
DEVICES_AT_MOST: Final = 50
"""Of one person."""
ROOMS_AT_MOST: Final = 1_000


class RoomReaders:
    """Chooses for one account.

    Where only verified devices are followed, a room is for people known to ROSIC; and as soon as it
    has had a member whose keys were compared, for such members alone. Otherwise it is for everybody
    in it.

    Args:
        knows: Whether somebody is known to ROSIC.
    """

    def __init__(
        self, cross_signing: CrossSigning, settings: MatrixSettings, knows: Callable[[str], bool]
    ) -> None:
        self._cross_signing = cross_signing
        self._strict = settings.require_verified
        self._own = settings.user
        self._knows = knows
        self._chosen: OrderedDict[str, tuple[object, list[DeviceIdentity]]] = OrderedDict()

    async def of(self, room: str, joined: JoinedRoom) -> list[DeviceIdentity]:
        """Return the devices that are given the key; of whom nothing is shown, none."""
        now = (joined.version, *self._cross_signing.version)
        kept = self._chosen.get(room)
        if kept is not None and kept[0] == now:
            return kept[1]
        others = [user for user in joined.users if user != self._own]
        confidential = self._strict and await self._cross_signing.is_confidential(room, others)
        people = self._people(others, confidential=confidential)
        found: list[DeviceIdentity] = []
        for keys, standing in await self._cross_signing.look_up_all(sorted(people)):
            found += self._devices(keys, standing, confidential=confidential)
        after = (joined.version, *self._cross_signing.version)
        self._chosen[room] = after, found
        self._chosen.move_to_end(room)
        while len(self._chosen) > ROOMS_AT_MOST:
            self._chosen.popitem(last=False)
        return found

    def _people(self, others: Iterable[str], *, confidential: bool) -> list[str]:
        if confidential:
            return [user for user in others if self._cross_signing.was_compared(user)]
        known = [user for user in others if self._knows(user)] if self._strict else []
        return (known or sorted(others))[:PEOPLE_AT_MOST]

    def _devices(
        self, keys: UserKeys, standing: IdentityStanding, *, confidential: bool
    ) -> list[DeviceIdentity]:
        withheld = withheld_devices(keys, standing)
        shown = [keys.device(name) for name in keys.devices()[:DEVICES_AT_MOST]]
        sound = [device for device in shown if device is not None]
        if not confidential:
            return [device for device in sound if device.device not in withheld]
        verified = self._cross_signing.is_verified
        return [one for one in sound if verified(one, standing, trust_on_first_use=False)]
