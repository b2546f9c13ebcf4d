"""Events whose key has not come yet: kept until it does, for each person and room by itself."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.messengers.matrix.incoming import ReceivedMoment

OF_ONE_PERSON: Final = 20
"""Events of one person who is known here, in one room; older ones are let go."""
OF_STRANGERS: Final = 100
"""Events of all others together."""
PLACES_AT_MOST: Final = 2_000
"""Persons and rooms."""
TOLD_AT_MOST: Final = 4_096


class UnreadEvent(NamedTuple):
    """An event whose key has not come.

    Attributes:
        room: Where it came.
        source: As it came.
        received: When.
        session: Whose key is missing; empty: no key would help.
    """

    room: str
    source: Mapping[str, Any]
    received: ReceivedMoment
    session: str


class UnreadQueue:
    """Bounded: what strangers send drives out nothing of people who are known here."""

    def __init__(self) -> None:
        self._places: OrderedDict[tuple[str, str], OrderedDict[str, UnreadEvent]] = OrderedDict()
        self._told: OrderedDict[tuple[str, str], None] = OrderedDict()
        self._untold: list[tuple[tuple[str, str], str]] = []

    def clear(self) -> None:
        """Forget all of it."""
        self._places.clear()
        self._untold.clear()

    def hold(self, one: UnreadEvent, *, known: bool) -> None:
        """Keep an event, and have its author told once for each key, where they are known."""
        sender, event = str(one.source.get("sender")), str(one.source.get("event_id"))
        place = (one.room, sender) if known else ("", "")
        kept = self._places.setdefault(place, OrderedDict())
        self._places.move_to_end(place)
        kept[event] = one
        while len(kept) > (OF_ONE_PERSON if known else OF_STRANGERS):
            kept.popitem(last=False)
        while len(self._places) > PLACES_AT_MOST:
            self._places.popitem(last=False)
        about = (one.room, one.session)
        if known and about not in self._told:
            self._told[about] = None
            self._untold.append((place, event))
            while len(self._told) > TOLD_AT_MOST:
                self._told.popitem(last=False)
            del self._untold[:-OF_STRANGERS]

    def take(self, has_key: Callable[[UnreadEvent], bool]) -> list[UnreadEvent]:
        """Return what can be read now, and keep it no longer."""
        found = []
        for place, kept in list(self._places.items()):
            for event, one in list(kept.items()):
                if one.session and has_key(one):
                    found.append(one)
                    del kept[event]
            if not kept:
                del self._places[place]
        return found

    @property
    def is_somebody_untold(self) -> bool:
        """Whether anybody is to be told that what they wrote cannot be read."""
        return bool(self._untold)

    def rooms_to_tell(self) -> list[str]:
        """Return where something still cannot be read of which nobody was told yet."""
        waiting, self._untold = self._untold, []
        found = []
        for place, event in waiting:
            kept = self._places.get(place)
            if kept is not None and event in kept:
                found.append(kept[event].room)
        return found
