"""Verification by emoji, begun by either side, between two devices or in a room.

Matrix specification v1.11, client-server API, "Key verification framework": a request, ``ready``,
the exchange of `sas`, ``done``; ``cancel`` at any time. It ends after ten minutes. Between two
people it takes place in a room, as their clients do it; over to-device messages it can as well.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Protocol

from rosic.contracts.verification import VerificationEnd, VerificationResult
from rosic.errors import MessengerFault
from rosic.messengers.matrix.sas import (
    ACCEPT,
    KEY,
    MACS,
    METHOD,
    START,
    Content,
    Message,
    SasCancel,
    SasEnd,
    SasExchange,
    SasPhase,
)
from rosic.messengers.matrix.signed_json import ED25519

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.verification import VerificationPrompt
    from rosic.messengers.matrix.cross_signing import CrossSigning
    from rosic.messengers.matrix.user_keys import DeviceIdentity

_LOGGER = logging.getLogger(__name__)

PREFIX: Final = "m.key.verification."
REQUEST: Final = f"{PREFIX}request"
READY: Final = f"{PREFIX}ready"
DONE: Final = f"{PREFIX}done"
CANCEL: Final = f"{PREFIX}cancel"
ROOM_MESSAGE: Final = "m.room.message"
EVERY_DEVICE: Final = "*"

LASTS_NS: Final = 600 * 10**9
AHEAD_NS: Final = 300 * 10**9
LIVE_AT_MOST: Final = 20
DEVICES_AT_MOST: Final = 50
LONGEST_ID: Final = 255


class VerificationTransport(Protocol):
    """Carries what two devices say to each other. Raises ``MessengerFault`` where it does not."""

    async def to_device(self, user: str, device: str, kind: str, content: Content) -> None:
        """Send one to-device message, as it is; ``*`` is every device of that person."""
        ...

    async def in_room(self, room: str, kind: str, content: Content) -> str:
        """Send one event into a room, encrypted where the room is, and return its id."""
        ...


class _Verification:
    """One of them."""

    def __init__(self, name: str, user: str, room: str, ends_ns: int, *, ours: bool) -> None:
        self.name = name
        self.user = user
        self.room = room
        self.ends_ns = ends_ns
        self.ours = ours
        self.device = ""
        self.theirs: DeviceIdentity | None = None
        self.master = ""
        self.exchange: SasExchange | None = None
        self.heard: dict[str, Content] = {}
        self.lock = asyncio.Lock()
        self.over = False


def _framed(one: _Verification, content: Content) -> Content:
    """Add what ties a content to a verification."""
    if one.room:
        return {**content, "m.relates_to": {"rel_type": "m.reference", "event_id": one.name}}
    return {**content, "transaction_id": one.name}


class EmojiVerification:
    """All verifications of one account.

    Args:
        cross_signing: Keeps what was compared, and has the keys that others compare with us.
        transport: Sends.
        clock: Says when one has lasted too long.
        prompt: Asks and tells the people at our end.
    """

    def __init__(
        self,
        cross_signing: CrossSigning,
        transport: VerificationTransport,
        clock: Clock,
        prompt: VerificationPrompt,
    ) -> None:
        self._cross_signing = cross_signing
        self._directory = cross_signing.directory
        self._user = cross_signing.account.user
        self._device = cross_signing.account.device
        self._transport = transport
        self._clock = clock
        self._prompt = prompt
        self._live: dict[str, _Verification] = {}
        self._beginning = 0
        self._early: list[tuple[str, str, str, str, Content]] = []

    # ---- what people do ----

    async def begin(self, user: str, *, room: str = "") -> str:
        """Ask a person to compare emoji; return the id of the verification.

        Args:
            user: The person.
            room: A private room with them; empty: all their devices are asked directly.

        Raises:
            MessengerFault: It could not be sent.
        """
        await self.expire()
        await self._end_others(user)
        if room:
            return await self._begin_in(room, user)
        now_ns, name = self._clock.wall_ns(), secrets.token_urlsafe(16)
        one = _Verification(name, user, "", now_ns + LASTS_NS, ours=True)
        content = {**self._offer(), "timestamp": now_ns // 10**6}
        self._live[name] = one
        try:
            await self._transport.to_device(user, EVERY_DEVICE, REQUEST, _framed(one, content))
        except MessengerFault:
            self._live.pop(name, None)
            raise
        return name

    async def _begin_in(self, room: str, user: str) -> str:
        """Ask in a room: the id is that of the event, so an answer may be here before it."""
        content = {
            **self._offer(),
            "msgtype": REQUEST,
            "to": user,
            "body": f"{self._user} asks to compare emoji. Your client cannot do that here.",
        }
        self._beginning += 1
        try:
            name = await self._transport.in_room(room, ROOM_MESSAGE, content)
        finally:
            self._beginning -= 1
            early, self._early = self._early, []
        ends_ns = self._clock.wall_ns() + LASTS_NS
        self._live[name] = _Verification(name, user, room, ends_ns, ours=True)
        for one in early:
            await self._take(*one)
        return name

    def _offer(self) -> Content:
        return {"from_device": self._device, "methods": [METHOD]}

    async def confirm(self, verification: str) -> None:
        """Somebody here has compared the code: it is the same at both ends.

        Raises:
            MessengerFault: There is no such verification (any more), or nothing to confirm in it.
        """
        one = await self._one(verification)
        async with one.lock:
            if one.over or one.exchange is None or one.exchange.phase is not SasPhase.SHOWN:
                raise MessengerFault("There is nothing to confirm: begin once more.")
            await self._step(one, one.exchange.confirm)

    async def reject(self, verification: str) -> None:
        """Somebody here has compared the code: it is not the same. Nothing of it counts.

        Raises:
            MessengerFault: There is no such verification (any more).
        """
        one = await self._one(verification)
        async with one.lock:
            await self._cancel(one, "m.mismatched_sas", "The codes are not the same.")

    async def expire(self) -> None:
        """End those that have lasted too long; to be called now and then."""
        now_ns = self._clock.wall_ns()
        for one in [one for one in self._live.values() if one.ends_ns <= now_ns]:
            async with one.lock:
                await self._cancel(one, "m.timeout", "It took too long.")

    # ---- what comes in ----

    async def on_to_device(self, event: Mapping[str, Any]) -> None:
        """Take a to-device message, as it came; what is not of a verification is passed over.

        Never raises: what is malformed or cannot be answered ends that verification at most.
        """
        kind, sender, content = _parts(event)
        if not kind.startswith(PREFIX) or sender == self._user:
            return
        name = content.get("transaction_id")
        if not isinstance(name, str) or not 0 < len(name) <= LONGEST_ID:
            return
        await self.expire()
        if kind == REQUEST:
            await self._requested(name, sender, "", content, content.get("timestamp"))
        else:
            await self._take(name, "", sender, kind, content)

    async def on_room_event(self, room: str, event: Mapping[str, Any]) -> None:
        """Take an event of a room, decrypted where it was encrypted, like `on_to_device`."""
        kind, sender, content = _parts(event)
        if sender == self._user:
            return
        if kind == ROOM_MESSAGE and content.get("msgtype") == REQUEST:
            name = event.get("event_id")
            if isinstance(name, str) and content.get("to") == self._user:
                await self.expire()
                sent_ms = event.get("origin_server_ts")
                await self._requested(name, sender, room, content, sent_ms)
        elif kind.startswith(PREFIX):
            link = content.get("m.relates_to")
            name = link.get("event_id") if isinstance(link, dict) else None
            if isinstance(name, str) and _is_reference(link):
                await self.expire()
                await self._take(name, room, sender, kind, content)

    async def _requested(
        self, name: str, user: str, room: str, content: Content, sent_ms: object
    ) -> None:
        now_ns, device = self._clock.wall_ns(), content.get("from_device")
        methods = content.get("methods")
        if type(sent_ms) is not int or not isinstance(device, str):
            return
        sent_ns = sent_ms * 10**6
        if not now_ns - LASTS_NS < sent_ns < now_ns + AHEAD_NS or name in self._live:
            return
        if not isinstance(methods, list) or METHOD not in methods or not self._prompt.accepts(user):
            return
        await self._end_others(user)
        if len(self._live) >= LIVE_AT_MOST:
            return
        one = _Verification(name, user, room, min(sent_ns, now_ns) + LASTS_NS, ours=False)
        one.device = device
        self._live[name] = one
        async with one.lock:
            if await self._meet(one):
                await self._send(one, [(READY, _framed(one, self._offer()))])

    async def _take(self, name: str, room: str, sender: str, kind: str, content: Content) -> None:
        """Take the next message of a verification, if it comes from whom it is with.

        From anybody else it is passed over: nobody ends what two others have begun.
        """
        one = self._live.get(name)
        if one is None and room and self._beginning and len(self._early) < LIVE_AT_MOST:
            self._early.append((name, room, sender, kind, content))
        if one is None or one.user != sender or one.room != room:
            return
        async with one.lock:
            if one.over or one.heard.get(kind) == content:
                return
            if kind == CANCEL:
                self._over(one, VerificationEnd.CANCELLED, code=_code(content), by_them=True)
            elif kind != READY:
                one.heard[kind] = content
                await self._step(one, lambda: self._answer(one, kind, content), kind)
            elif one.ours and one.exchange is None:  # their first device to answer is the one
                await self._ready(one, content)

    # ---- one verification ----

    async def _step(
        self, one: _Verification, answer: Callable[[], list[Message]], kind: str = ""
    ) -> None:
        """Let one thing happen; send what follows from it, and end it where it is at its end."""
        try:
            messages = answer()
        except SasCancel as cancel:
            await self._cancel(one, cancel.code, str(cancel))
            return
        if not await self._send(one, messages):
            return
        exchange = one.exchange
        if kind == KEY and exchange is not None:
            self._prompt.show(exchange.shown())
        if exchange is not None and exchange.phase is SasPhase.DONE:
            await self._finish(one, exchange.compared)

    def _answer(self, one: _Verification, kind: str, content: Content) -> list[Message]:
        if kind == DONE:
            return []
        if one.exchange is None:
            raise SasCancel("m.unexpected_message", "That was not expected now.")
        if kind == START:
            return self._started(one, one.exchange, content)
        if kind == ACCEPT:
            return one.exchange.accepted(content)
        if kind == KEY:
            return one.exchange.key(content)
        if kind == MACS:
            one.exchange.macs(content)
            return []
        raise SasCancel("m.unexpected_message", "No such step is known.")

    async def _ready(self, one: _Verification, content: Content) -> None:
        """Start it with the device that answers; the others need not ask their person any more."""
        device, methods = content.get("from_device"), content.get("methods")
        if not isinstance(device, str) or not isinstance(methods, list) or METHOD not in methods:
            await self._cancel(one, "m.unknown_method", "There is no way that both of us know.")
            return
        one.device = device
        if not await self._meet(one) or one.exchange is None:
            return
        if not one.room:
            await self._end_at_others(one)
        await self._step(one, one.exchange.start)

    async def _end_at_others(self, one: _Verification) -> None:
        said = _framed(one, {"code": "m.accepted", "reason": "Another device answers."})
        try:
            shown = await self._directory.keys_of(one.user)
            for other in shown.devices()[:DEVICES_AT_MOST]:
                if other != one.device:
                    await self._transport.to_device(one.user, other, CANCEL, said)
        except MessengerFault as fault:
            _LOGGER.info("Other devices of %s still ask: %s", one.user, fault)

    def _started(
        self, one: _Verification, exchange: SasExchange, content: Content
    ) -> list[Message]:
        """Take their start. Both may have started at once: the one of the smaller name counts."""
        if exchange.has_started:
            if exchange.phase is not SasPhase.BEGUN or content.get("method") != METHOD:
                raise SasCancel("m.unexpected_message", "That was not expected now.")
            if self._user < one.user:
                return []
            exchange.yield_start()
        return exchange.started(content)

    async def _meet(self, one: _Verification) -> bool:
        """Look their keys up, anew. What they are compared with is what is shown now.

        Returns:
            Whether there is such a device; otherwise it has ended.
        """
        try:
            shown = await self._directory.keys_of(one.user, fresh=True)
        except MessengerFault as fault:
            _LOGGER.warning("No keys of %s: %s", one.user, fault)
            await self._cancel(one, "m.user", "Your keys cannot be looked up now.")
            return False
        theirs = shown.device(one.device)
        if theirs is None:
            one.device = ""
            await self._cancel(one, "m.key_mismatch", "That device has no keys.")
            return False
        keys = {f"{ED25519}:{theirs.device}": theirs.ed25519}
        if shown.master:
            keys[f"{ED25519}:{shown.master}"] = shown.master
        one.theirs, one.master = theirs, shown.master
        one.exchange = SasExchange(
            one.name,
            SasEnd(user=self._user, device=self._device, keys=self._cross_signing.own_keys()),
            SasEnd(user=one.user, device=one.device, keys=keys),
            partial(_framed, one),
        )
        return True

    async def _finish(self, one: _Verification, compared: frozenset[str]) -> None:
        master = one.master if f"{ED25519}:{one.master}" in compared else ""
        try:
            if one.theirs is not None:
                await self._cross_signing.compared(one.theirs, master)
        except MessengerFault as fault:
            _LOGGER.warning("A verification was not kept: %s", fault)
            await self._cancel(one, "m.user", "It could not be kept.", VerificationEnd.NOT_KEPT)
            return
        await self._send(one, [(DONE, _framed(one, {}))])
        self._over(one, VerificationEnd.COMPARED, master=bool(master))

    async def _send(self, one: _Verification, messages: list[Message]) -> bool:
        try:
            for kind, content in messages:
                await self._carry(one, kind, content)
        except MessengerFault as fault:
            _LOGGER.warning("A verification with %s broke off: %s", one.user, fault)
            self._over(one, VerificationEnd.CANCELLED, code="m.timeout")
            return False
        return True

    async def _carry(self, one: _Verification, kind: str, content: Content) -> None:
        if one.room:
            await self._transport.in_room(one.room, kind, content)
        else:
            await self._transport.to_device(one.user, one.device or EVERY_DEVICE, kind, content)

    async def _cancel(
        self,
        one: _Verification,
        code: str,
        reason: str,
        end: VerificationEnd = VerificationEnd.CANCELLED,
    ) -> None:
        if one.over:
            return
        self._over(one, end, code=code)
        try:
            await self._carry(one, CANCEL, _framed(one, {"code": code, "reason": reason}))
        except MessengerFault as fault:
            _LOGGER.info("%s was not told that a verification ended: %s", one.user, fault)

    def _over(
        self,
        one: _Verification,
        end: VerificationEnd,
        *,
        code: str = "",
        master: bool = False,
        by_them: bool = False,
    ) -> None:
        if one.over:
            return
        one.over = True
        self._live.pop(one.name, None)
        self._prompt.tell(
            VerificationResult(
                verification=one.name,
                user=one.user,
                end=end,
                master=master,
                code=code,
                by_them=by_them,
            )
        )

    async def _end_others(self, user: str) -> None:
        """One person has one verification at a time: whoever looks at emoji knows which."""
        for one in [one for one in self._live.values() if one.user == user]:
            async with one.lock:
                await self._cancel(one, "m.user", "Another one was begun.")

    async def _one(self, verification: str) -> _Verification:
        await self.expire()
        one = self._live.get(verification)
        if one is None:
            raise MessengerFault("There is no such verification any more: begin once more.")
        return one


def _parts(event: Mapping[str, Any]) -> tuple[str, str, Content]:
    kind, sender, content = event.get("type"), event.get("sender"), event.get("content")
    if isinstance(kind, str) and isinstance(sender, str) and isinstance(content, dict):
        return kind, sender, content
    return "", "", {}


def _is_reference(link: object) -> bool:
    return isinstance(link, dict) and link.get("rel_type") == "m.reference"


def _code(content: Content) -> str:
    code = content.get("code")
    return code[:LONGEST_ID] if isinstance(code, str) else ""
