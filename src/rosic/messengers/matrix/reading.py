"""What one sync brought, as messages: stops first, then people known here, strangers last."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.core.identity import Address
from rosic.core.language import is_urgent
from rosic.core.message import Reaction
from rosic.messengers.matrix import incoming
from rosic.messengers.matrix.content import relation
from rosic.messengers.matrix.incoming import PLATFORM, Known, RoomEvent
from rosic.messengers.matrix.olm_machine import EventDecryptionError
from rosic.messengers.matrix.trust import evidence_of
from rosic.messengers.matrix.unread_queue import UnreadEvent, UnreadQueue

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Mapping

    from rosic.contracts.messenger import Knows, Reacted
    from rosic.core.message import Inbound
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.incoming import ReceivedMoment
    from rosic.messengers.matrix.olm_machine import SyncedEvent
    from rosic.messengers.matrix.outgoing import Offers
    from rosic.messengers.matrix.rooms import Rooms
    from rosic.messengers.matrix.signs import Signs
    from rosic.messengers.matrix.trust import SessionEvidence

REMEMBERED: Final = 16_384

log = logging.getLogger("rosic.messengers.matrix")


class ReceivedEvent(NamedTuple):
    """An event of a room as it came.

    Attributes:
        room: Where.
        source: Its JSON; nothing of it is checked.
        received: When, and whether we listened then.
    """

    room: str
    source: Mapping[str, Any]
    received: ReceivedMoment


class ReadEvent(NamedTuple):
    """A message to hand over.

    Attributes:
        urgent: Somebody known says stop.
        known: Somebody known here sent it.
        event: Under which it came; an edit goes by the id of what it changes.
        reaction: It is a tap by a reaction.
        evidence: Which session it came under; None: it came in the open.
    """

    inbound: Inbound
    urgent: bool
    known: bool
    event: str = ""
    reaction: bool = False
    evidence: SessionEvidence | None = None


class ReadingNotices(NamedTuple):
    """Who is told of what is not a message.

    Attributes:
        verifying: Takes steps of verifications.
        cannot_read: Tells a room that what somebody wrote there cannot be decrypted.
        replayed: Told in whose name something was given out again.
    """

    verifying: Callable[[str, Mapping[str, Any]], None]
    cannot_read: Callable[[str], Awaitable[None]]
    replayed: Callable[[str], None]


class EventReader:
    """Reads events for one account.

    Args:
        notices: Told of what is not a message.
    """

    def __init__(
        self,
        client: MatrixClient,
        rooms: Rooms,
        offers: Offers,
        signs: Signs,
        notices: ReadingNotices,
    ) -> None:
        self._client = client
        self._rooms = rooms
        self._offers = offers
        self._signs = signs
        self._verifying, self._cannot_read, self._replayed = notices
        self._known: Knows = _nobody
        self._reacted: Reacted = _untold
        self._authors: OrderedDict[str, str] = OrderedDict()
        self._seen: OrderedDict[str, None] = OrderedDict()
        self._unreadable = UnreadQueue()

    def begin(self, known: Knows, reacted: Reacted) -> None:
        """Begin a run: ask and tell these, and take what comes for new."""
        self._known, self._reacted = known, reacted
        self._seen.clear()
        self._unreadable.clear()

    def urgent(self, one: ReceivedEvent) -> ReadEvent | None:
        """Return a stop of somebody known, to be handed over before anything else; else None.

        Nothing else is noted of an event that is none: it will be read in its turn.
        """
        try:
            sender = one.source.get("sender")
            if not isinstance(sender, str) or not self._known(Address(PLATFORM, sender)):
                return None
            opened = self._client.open_event(
                one.room, one.source, one.received.received_ns, note=False
            )
            found = self._message(one.room, opened, one.received)
            if found is None or not found.urgent:
                return None
            self._client.open_event(one.room, one.source, one.received.received_ns)
        except EventDecryptionError:
            return None
        except Exception:
            # Whatever anybody can send must not end the loop: a stop may be behind it.
            log.exception("an event was passed over")
            return None
        self._note(found)
        return found

    async def read(self, arrivals: Iterable[ReceivedEvent]) -> list[ReadEvent]:
        """Return what is to be handed over of a sync, in the order in which to do it."""
        found: list[ReadEvent] = []
        for arrival in [*self._readable_now(), *arrivals]:
            one = self._one(arrival)
            if one is not None:
                found.append(one)
            await self._client.steps.give_way()
        found.sort(key=_rank)
        return found

    def _readable_now(self) -> list[ReceivedEvent]:
        """Return what could not be read, and whose key has come; it is as old as it is."""
        return [
            ReceivedEvent(one.room, one.source, one.received)
            for one in self._unreadable.take(lambda one: self._client.has_key(one.room, one.source))
        ]

    def _one(self, arrival: ReceivedEvent) -> ReadEvent | None:
        room, source, received = arrival
        try:
            if source.get("event_id") in self._seen:
                return None
            event = self._client.open_event(room, source, received.received_ns)
            self._verifying(room, event.source)
            found = self._message(room, event, received)
            if found is None:
                self._about(room, event)
            else:
                self._note(found)
        except EventDecryptionError as reason:
            self._not_read(arrival, reason)
            return None
        except Exception:
            # Whatever anybody can send must not end the loop: a stop may be behind it.
            log.exception("an event was passed over")
            return None
        return found

    def _note(self, found: ReadEvent) -> None:
        """Remember what will be handed over: it comes once."""
        inbound = found.inbound
        event = found.event
        _remember(self._seen, event, None)
        _remember(self._authors, event, inbound.sender.account)
        if found.reaction:
            self._signs.tapped(inbound.chat.id, event)

    def _about(self, room: str, event: SyncedEvent) -> None:
        """Follow what is no message: a reaction that taps nothing; who wrote what is remembered."""
        found = self._event(room, event.source)
        if found is None or found.event in self._seen:
            return
        _remember(self._seen, found.event, None)
        _remember(self._authors, found.event, found.sender)
        if found.type == incoming.REACTION:
            self._reaction(found, *incoming.refers_to(found))

    def _message(self, room: str, event: SyncedEvent, received: ReceivedMoment) -> ReadEvent | None:
        found = self._event(room, event.source)
        if found is None or found.event in self._seen:
            return None
        if event.late:  # it was held back: it is backlog, whoever says when it was sent
            received = received._replace(listening_since_ns=received.received_ns + 1)
        target, sign = incoming.refers_to(found)
        answered = target or incoming.answers(found.content)
        offered = self._offers.tapped(room, target, sign) if target and sign else None
        if offered is None and found.type == incoming.REACTION:
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
        friend = self._known(inbound.sender)
        if friend:
            self._rooms.private.spoke(found.sender, room)
        return ReadEvent(
            inbound,
            urgent=friend and self._is_stop(inbound),
            known=friend,
            event=found.event,
            reaction=found.type == incoming.REACTION,
            evidence=evidence_of(self._client.machine, room, event),
        )

    def _event(self, room: str, source: Mapping[str, Any]) -> RoomEvent | None:
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
        return user or ""

    # ---- what cannot be read ----

    def _not_read(self, arrival: ReceivedEvent, reason: EventDecryptionError) -> None:
        room, source, received = arrival
        sender = source.get("sender")
        if not isinstance(sender, str) or sender not in self._client.members(room):
            return
        if reason.replayed:
            self._replayed(sender)
            return
        known = self._known(Address(PLATFORM, sender))
        one = UnreadEvent(room, source, received, reason.session)
        self._unreadable.hold(one, known=known)

    async def tell_unreadable(self) -> None:
        """Tell, once for each key that is missing, that something cannot be read."""
        if not self._unreadable.is_somebody_untold:
            return
        await asyncio.sleep(1.0)  # a key often comes right behind what it opens
        for room in self._unreadable.rooms_to_tell():
            await self._cannot_read(room)


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
