"""Whose device something came from, and whose devices are spoken to: one account's keys, joined."""

from __future__ import annotations

import asyncio
import logging
import secrets
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from urllib.parse import quote

from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.message import MessageValidity
from rosic.core.policy.roles import Assurance
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.cross_signing import CrossSigning, OlmDeviceAccount
from rosic.messengers.matrix.identity_book import IdentityStanding
from rosic.messengers.matrix.room_readers import RoomReaders
from rosic.messengers.matrix.trust import (
    RequestWeight,
    SenderAssurance,
    Trust,
    permits,
)
from rosic.messengers.matrix.verification import PREFIX, EmojiVerification

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.verification import ShownCode, VerificationPrompt, VerificationResult
    from rosic.core.message import Inbound
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.identity_book import KeyChange
    from rosic.messengers.matrix.reading import ReadEvent
    from rosic.messengers.matrix.settings import MatrixSettings
    from rosic.messengers.matrix.user_keys import DeviceIdentity

TO_DEVICE: Final = "/_matrix/client/v3/sendToDevice"
STEPS_AT_MOST: Final = 200
"""Of verifications, that wait to be taken; anybody may send any number."""

log = logging.getLogger("rosic.messengers.matrix")


def remedy_for(assurance: SenderAssurance, *, tapped: bool) -> str:
    """Return what somebody can do whose message may only look.

    Args:
        assurance: What it is worth.
        tapped: It is a tap in an encrypted room.
    """
    if tapped and assurance is SenderAssurance.PLAIN:
        return said("A reaction is not encrypted: reply to the message with the number instead.")
    if assurance is SenderAssurance.PLAIN:
        return said("It came without encryption: write it in an encrypted room.")
    return said("Verify me in your client, or say: /verify")


class DirectTransport:
    """Carries verifications for one account."""

    def __init__(self, client: MatrixClient) -> None:
        self._client = client

    async def to_device(
        self, user: str, device: str, kind: str, content: Mapping[str, Any]
    ) -> None:
        """Send one to-device message.

        Raises:
            MessengerFault: It was not sent, or it cannot be known.
        """
        path = f"{TO_DEVICE}/{quote(kind, safe='')}/{secrets.token_urlsafe(16)}"
        messages = {"messages": {user: {device: dict(content)}}}
        await self._client.persist(lambda: self._client.call("PUT", path, messages))

    async def in_room(self, room: str, kind: str, content: Mapping[str, Any]) -> str:
        """Send one event into a room.

        Raises:
            MessengerFault: It was not sent, or it cannot be known.
        """
        return await self._client.send(room, kind, content)


class VerificationHandler:
    """Passes on to whoever compares emoji at our end: nobody, until somebody is named.

    Args:
        name: Of the messenger, for the log.

    Attributes:
        prompt: Who compares; None: nobody, so that nothing is begun.
    """

    def __init__(self, name: str) -> None:
        self.prompt: VerificationPrompt | None = None
        self._name = name

    def ask(self, prompt: VerificationPrompt) -> None:
        """Ask this one from now on."""
        self.prompt = prompt

    def accepts(self, user: str) -> bool:
        """Whether this person may begin one."""
        return self.prompt is not None and self.prompt.accepts(user)

    def show(self, code: ShownCode) -> None:
        """Show a code to whoever compares it."""
        if self.prompt is not None:
            self.prompt.show(code)

    def tell(self, result: VerificationResult) -> None:
        """Say how one ended."""
        log.info("%s: verifying %s: %s", self._name, result.user, result.end.value)
        if self.prompt is not None:
            self.prompt.tell(result)


class TrustNotices(NamedTuple):
    """Who is told.

    Attributes:
        changed: Told that somebody's keys are others, or that they have a new device.
        forged: Told in whose name somebody else wrote.
    """

    changed: Callable[[KeyChange], None]
    forged: Callable[[str], None]


class DeviceTrust:
    """Nothing can be asked of it before `start`.

    Args:
        name: Of the messenger, for the log.
        prompt: Compares emoji at our end.
        notices: Told what people must hear of.
    """

    def __init__(
        self,
        name: str,
        client: MatrixClient,
        settings: MatrixSettings,
        clock: Clock,
        *,
        prompt: VerificationPrompt,
        notices: TrustNotices,
    ) -> None:
        self._name = name
        self._client = client
        self._settings = settings
        self._clock = clock
        self._prompt = prompt
        self._changed, self._forged = notices
        self._cross_signing: CrossSigning | None = None
        self._trust: Trust | None = None
        self._verification: EmojiVerification | None = None
        self._steps: asyncio.Queue[tuple[str, Mapping[str, Any]]] = asyncio.Queue(STEPS_AT_MOST)
        self._stale: set[str] = set()
        self._readers: RoomReaders | None = None

    @property
    def verification(self) -> EmojiVerification:
        """Comparing emoji with people.

        Raises:
            MessengerFault: It has not begun yet.
        """
        if self._verification is None:
            raise MessengerFault(f"The messenger {self._name} is not connected yet.")
        return self._verification

    async def begin(self, user: str, room: str) -> str:
        """Ask somebody to compare emoji, in the room with them; return the id of the verification.

        Whose keys are not those that they were is asked device by device: no device of theirs is
        given keys of what is said in the room.

        Raises:
            MessengerFault: It could not be sent.
        """
        verification = self.verification
        assert self._cross_signing is not None  # noqa: S101 - it came with the verification
        _, standing = await self._cross_signing.look_up(user)
        replaced = standing is IdentityStanding.REPLACED
        return await verification.begin(user, room="" if replaced else room)

    def room_assurance(self, room: str) -> Assurance:
        """Return what a room is worth: who could read or write there besides those who are named.

        A look-up. It counts what was compared of each person who is there, and nothing shown since
        that differs.
        """
        if not self._client.is_encrypted(room):
            return Assurance.PROVIDER_READABLE
        others = self._client.members(room) - {self._client.user}
        signing = self._cross_signing
        if signing is None or not others or not all(map(signing.is_compared, others)):
            return Assurance.E2EE_UNVERIFIED
        return Assurance.E2EE_VERIFIED

    async def start(self) -> None:
        """Have this device signed by the account's own keys, which are made the first time.

        Raises:
            ConfigurationError: The account has other keys than this folder, and only verified
                devices are followed.
            MessengerFault: The homeserver did not answer.
        """
        await self._client.upkeep()
        await self._client.renew_fallback_key()
        if self._cross_signing is None:
            signing = CrossSigning(
                OlmDeviceAccount(self._client.machine),
                self._client.call,
                self._client.folder,
                self._client.directory,
                self._changed,
                knows=self._client.is_known,
            )
            self._cross_signing = signing
            self._trust = Trust(signing, trust_on_first_use=self._settings.trust_on_first_use)
            self._readers = RoomReaders(signing, self._settings, self._client.is_known)
            self._verification = EmojiVerification(
                signing, DirectTransport(self._client), self._clock, self._prompt
            )
        self._cross_signing.directory.forget_all()
        try:
            await self._cross_signing.start(self._settings.password)
        except ConfigurationError as error:
            if self._settings.require_verified:
                raise
            log.warning("%s: %s", self._name, error)

    # ---- what comes ----

    async def weigh(self, one: ReadEvent) -> Inbound:
        """Return a message as it counts: from whom nobody can be sure of, it may look (I17).

        One that is surely not from whom it names counts like that of nobody.
        """
        inbound, room = one.inbound, one.inbound.chat.id
        if self._trust is None or not await self._is_on_disk():
            return replace(inbound, standing=MessageValidity.ANONYMOUS)
        assurance = await self._trust.assess(one.evidence)
        strict = self._settings.require_verified
        # Nobody's client encrypts a reaction. Where unverified devices are followed, whoever runs
        # the homeserver could add one as well, so a reaction is worth no less there.
        tapped = one.reaction and not strict and assurance is SenderAssurance.PLAIN
        encrypted = self._client.is_encrypted(room)
        inbound = replace(inbound, assurance=assurance.channel)
        if tapped or inbound.standing is not MessageValidity.FRESH:
            return inbound
        asks = partial(permits, assurance, require_verified=strict, room_encrypted=encrypted)
        if asks(RequestWeight.ACT):
            return inbound
        if not asks(RequestWeight.OBSERVE):
            self._forged(inbound.sender.account)
            return replace(inbound, standing=MessageValidity.ANONYMOUS)
        remedy = remedy_for(assurance, tapped=inbound.nonce is not None and encrypted)
        return replace(inbound, standing=MessageValidity.UNVERIFIED, remedy=remedy)

    async def _is_on_disk(self) -> bool:
        """Whether nothing that was decrypted could be given out again as something new."""
        try:
            await self._client.guard.settle()
        except MessengerFault as fault:
            log.error("%s: %s", self._name, fault)  # noqa: TRY400 - what broke is a full disk
            return False
        return True

    def devices_changed(self, users: Iterable[str]) -> None:
        """Ask anew for the keys of these people: a sync named them."""
        for user in users:
            self._stale.add(user)
            if self._cross_signing is not None:  # nothing that comes with it is judged by old keys
                self._cross_signing.directory.forget(user)

    def heard(self, room: str, source: Mapping[str, Any]) -> None:
        """Take a step of a verification: in a room, or to this device, where the room is empty."""
        kind, content = source.get("type"), source.get("content")
        stated = content.get("msgtype") if isinstance(content, dict) else None
        ours = any(isinstance(one, str) and one.startswith(PREFIX) for one in (kind, stated))
        if ours and not self._steps.full():
            self._steps.put_nowait((room, source))

    async def follow(self) -> None:
        """Take steps of verifications, one after the other, until cancelled."""
        while True:
            room, source = await self._steps.get()
            if self._verification is None:
                continue
            if room:
                await self._verification.on_room_event(room, source)
            else:
                await self._verification.on_to_device(source)

    async def look_after(self) -> None:
        """Look whose devices are new; to be called when a sync is through. Never raises a fault."""
        stale, self._stale = self._stale, set()
        if self._cross_signing is not None:
            await self._cross_signing.keys_changed(stale)
        if self._verification is not None:
            await self._verification.expire()

    # ---- what goes ----

    async def readers(self, room: str) -> list[DeviceIdentity]:
        """Return the devices that are given the key of what is said in a room. Never raises."""
        joined = self._client.rooms.get(room)
        if self._readers is None or joined is None or not joined.encrypted:
            return []
        return await self._readers.of(room, joined)
