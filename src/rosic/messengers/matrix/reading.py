"""What one sync brought, as messages: stops first, then people known here, strangers last."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import nio

from rosic.core.identity import Address
from rosic.core.language import is_urgent
from rosic.core.message import Reaction
from rosic.messengers.matrix import incoming
from rosic.messengers.matrix.content import relation
from rosic.messengers.matrix.incoming import PLATFORM, Known, RoomEvent
from rosic.messengers.matrix.trust import evidence_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from rosic.contracts.messenger import Knows, Reacted
    from rosic.core.message import Inbound
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.incoming import ReceivedMoment
    from rosic.messengers.matrix.outgoing import Offers
    from rosic.messengers.matrix.rooms import Rooms
    from rosic.messengers.matrix.signs import Signs
    from rosic.messengers.matrix.trust import SessionEvidence

REMEMBERED: Final = 16_384
UNREADABLE_AT_MOST: Final = 500
TRIES: Final = 2
"""Syncs in which keys came, before somebody is told that what they wrote cannot be read."""

log = logging.getLogger("rosic.messengers.matrix")


class ReadEvent(NamedTuple):
    """A message to hand over.

    Attributes:
        urgent: Somebody known says stop.
        known: Somebody known here sent it.
        reaction: It is a tap by a reaction.
        evidence: Which session it came under; None: it came in the open.
    """

    inbound: Inbound
    urgent: bool
    known: bool
    reaction: bool = False
    evidence: SessionEvidence | None = None


class UnreadEvent(NamedTuple):
    """An event whose key has not come."""

    room: str
    event: Any
    received: ReceivedMoment


class EventReader:
    """Reads events for one account.

    Args:
        verifying: Takes steps of verifications.
        cannot_read: Tells a room that what somebody wrote there cannot be decrypted.
    """

    def __init__(
        self,
        client: MatrixClient,
        rooms: Rooms,
        offers: Offers,
        signs: Signs,
        *,
        verifying: Callable[[str, Mapping[str, Any]], None],
        cannot_read: Callable[[str], Awaitable[None]],
    ) -> None:
        self._client = client
        self._rooms = rooms
        self._offers = offers
        self._signs = signs
        self._verifying = verifying
        self._cannot_read = cannot_read
        self._known: Knows = _nobody
        self._reacted: Reacted = _untold
        self._authors: OrderedDict[str, str] = OrderedDict()
        self._seen: OrderedDict[str, None] = OrderedDict()
        self._unreadable: OrderedDict[str, UnreadEvent] = OrderedDict()
        self._told: OrderedDict[tuple[str, str], None] = OrderedDict()
        self._untold: list[str] = []
        self._keys_came = False

    def begin(self, known: Knows, reacted: Reacted) -> None:
        """Begin a run: ask and tell these, and take what comes for new."""
        self._known, self._reacted = known, reacted
        self._seen.clear()
        self._unreadable.clear()
        self._untold.clear()

    def keys_came(self, came: bool) -> None:
        """Note whether keys may have come with a sync."""
        self._keys_came = came

    def read(self, events: list[tuple[str, Any]], received: ReceivedMoment) -> list[ReadEvent]:
        """Return what is to be handed over of a sync, in the order in which to do it."""
        found: list[ReadEvent] = []
        for room, event, at in [*self._decrypted_late(), *((*one, received) for one in events)]:
            one = self._one(room, event, at)
            if one is not None:
                found.append(one)
        found.sort(key=_rank)
        return found

    def _one(self, room: str, event: Any, received: ReceivedMoment) -> ReadEvent | None:  # noqa: ANN401
        try:
            if isinstance(event, nio.MegolmEvent):
                self._hold(room, event, received)
                return None
            return self._message(room, event, received)
        except Exception:
            # Whatever anybody can send must not end the loop: a stop may be behind it.
            log.exception("an event was passed over")
            return None

    def _message(self, room: str, event: Any, received: ReceivedMoment) -> ReadEvent | None:  # noqa: ANN401
        found = self._event(room, event)
        if found is None or found.event in self._seen:
            return None
        _remember(self._seen, found.event, None)
        _remember(self._authors, found.event, found.sender)
        self._verifying(room, event.source)
        target, sign = incoming.refers_to(found)
        answered = target or incoming.answers(found.content)
        offered = self._offers.tapped(room, target, sign) if target and sign else None
        if offered is None and found.type == incoming.REACTION:
            self._reaction(found, target, sign)
            return None
        known = Known(
            own=self._client.user,
            author=self._authors.get(answered or relation(found.content)[1], ""),
            offered=offered,
            shown_as=self._shown_as(room, found.sender),
        )
        inbound = incoming.read(found, known, received)
        if inbound is None:
            return None
        if found.type == incoming.REACTION:
            self._signs.tapped(room, found.event)
        friend = self._known(inbound.sender)
        if friend:
            self._rooms.private.spoke(found.sender, room)
        return ReadEvent(
            inbound,
            urgent=friend and self._is_stop(inbound),
            known=friend,
            reaction=found.type == incoming.REACTION,
            evidence=evidence_of(self._client.library.olm, room, event),
        )

    def _event(self, room: str, event: Any) -> RoomEvent | None:  # noqa: ANN401
        source = event.source if isinstance(event.source, dict) else {}
        content, sent_ms = source.get("content"), source.get("origin_server_ts")
        names = [source.get(key) for key in ("event_id", "sender", "type")]
        if not isinstance(content, dict) or type(sent_ms) is not int or "state_key" in source:
            return None
        if not all(isinstance(name, str) and name for name in names):
            return None
        return RoomEvent(
            room,
            self._rooms.kind(room),
            str(names[0]),
            str(names[1]),
            str(names[2]),
            sent_ms,
            content,
        )

    def _reaction(self, event: RoomEvent, target: str, sign: str) -> None:
        if not target or event.sender == self._client.user:
            return
        reaction = Reaction(
            chat=incoming.chat_of(event),
            message=target,
            who=Address(PLATFORM, event.sender),
            emoji=(sign,),
        )
        try:
            self._reacted(reaction)
        except Exception:
            log.exception("a reaction was not followed")

    def _is_stop(self, inbound: Inbound) -> bool:
        said = inbound.text if inbound.nonce is None else inbound.nonce
        return is_urgent(said) or self._offers.stops(said)

    def _shown_as(self, room: str, sender: str) -> str:
        found = self._client.rooms.get(room)
        user = None if found is None else found.users.get(sender)
        return "" if user is None else str(user.display_name or "")

    # ---- what cannot be read ----

    def _hold(self, room: str, event: Any, received: ReceivedMoment) -> None:  # noqa: ANN401
        if event.event_id in self._seen:
            return
        _remember(self._unreadable, event.event_id, UnreadEvent(room, event, received))
        while len(self._unreadable) > UNREADABLE_AT_MOST:
            self._unreadable.popitem(last=False)
        session = (room, str(event.session_id))
        if session not in self._told and event.sender in self._client.members(room):
            _remember(self._told, session, None)
            if self._known(Address(PLATFORM, event.sender)):
                self._untold.append(event.event_id)

    def _decrypted_late(self) -> list[tuple[str, Any, ReceivedMoment]]:
        """Return what can be read now that its key has come; it is as old as it is."""
        if not self._keys_came:
            return []
        found = []
        for number, held in list(self._unreadable.items()):
            event = self._client.decrypt(held.event)
            if event is not None:
                del self._unreadable[number]
                found.append((held.room, event, held.received))
        return found

    async def tell_unreadable(self) -> None:
        """Tell, once for each key that is missing, that something cannot be read."""
        if not self._untold:
            return
        await asyncio.sleep(1.0)  # a key often comes right behind what it opens
        waiting, self._untold = self._untold, []
        for event in waiting:
            if (held := self._unreadable.get(event)) is not None:
                await self._cannot_read(held.room)


def _rank(one: ReadEvent) -> int:
    return 0 if one.urgent else 1 if one.known else 2


def _remember(table: OrderedDict[Any, Any], key: Any, value: Any) -> None:  # noqa: ANN401
    table[key] = value
    while len(table) > REMEMBERED:
        table.popitem(last=False)


def _nobody(_who: Address) -> bool:
    return False


def _untold(_what: object) -> None:
    pass
