"""The Matrix messenger: one account, on one device, encrypted end to end where its rooms are."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any, Final

from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.identity import Address
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault
from rosic.messengers.matrix.client import MatrixClient
from rosic.messengers.matrix.device_trust import DeviceTrust, TrustNotices, VerificationHandler
from rosic.messengers.matrix.files import MediaFetcher
from rosic.messengers.matrix.identity_book import KeyChangeKind
from rosic.messengers.matrix.incoming import PLATFORM
from rosic.messengers.matrix.outgoing import Offers, RoomSender
from rosic.messengers.matrix.reading import EventReader, ReadingNotices
from rosic.messengers.matrix.room_signals import RoomSignals
from rosic.messengers.matrix.rooms import Rooms
from rosic.messengers.matrix.settings import USER, MatrixSettings, read_settings
from rosic.messengers.matrix.signs import Signs
from rosic.messengers.matrix.sync import SyncLoop, SyncParts

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Alarm, Knows, Passed, Reacted, Receive, Settle
    from rosic.contracts.verification import VerificationPrompt
    from rosic.core.message import Chat, Inbound, IncomingFile, Outbound
    from rosic.core.policy.roles import Assurance
    from rosic.messengers.matrix.identity_book import KeyChange

FILE_BYTES: Final = 50_000_000
"""What Synapse takes unless it is told otherwise; a homeserver that takes less says so."""
OFFERS_FILE: Final = "offers.sealed"
FORGERY_NS: Final = 3_600 * SECOND_NS
"""So long the admins are not told again of forgeries in the same name."""
FORGERIES_AT_MOST: Final = 1_000
READY_WITHIN_S: Final = 15.0
"""What is said before the rooms are known waits for that."""

log = logging.getLogger("rosic.messengers.matrix")


class MatrixMessenger:
    """Implements `contracts.messenger.Messenger` over Matrix's client-server API.

    Something is sent only while it runs: what a room's members are, for whom it is encrypted, is
    known only then. What is sent while it begins waits for that.
    """

    platform = "matrix"
    edits = True
    pins = True
    fetch_bytes = FILE_BYTES

    def __init__(self, name: str, settings: MatrixSettings, clock: Clock) -> None:
        self.name = name
        # What anybody's device may have sent, whoever runs the homeserver could have written.
        strict = settings.require_verified and not settings.trust_on_first_use
        self.assurance = "e2ee-verified" if strict else "provider-readable"
        self.file_bytes = FILE_BYTES
        self._settings = settings
        self._alarm: Alarm = _nobody_is_told
        self._settle: Settle | None = None
        self._known: Knows = _anybody
        self._passed: Passed = _nobody_is_told
        self._reacted: Reacted = _nobody_is_told
        self._client = MatrixClient(name, settings, clock, self._is_known)
        self._rooms = Rooms(name, self._client, encrypted_only=settings.require_verified)
        self._offers = Offers()
        self._signs = Signs(self._client)
        self._prompt = VerificationHandler(name)
        self._trust = DeviceTrust(
            name,
            self._client,
            settings,
            clock,
            prompt=self._prompt,
            notices=TrustNotices(self._keys_changed, self._forged),
        )
        self._speaker = RoomSender(
            self._client,
            self._offers,
            self._signs,
            lambda: self.file_bytes,
            self._trust.readers,
        )
        self._fetcher = MediaFetcher(self._client, FILE_BYTES)
        self._reader = EventReader(
            self._client,
            self._rooms,
            self._offers,
            self._signs,
            ReadingNotices(self._trust.heard, self._cannot_read, self._forged),
        )
        self._room_signals = RoomSignals(name, self._client, clock)
        self._listener = SyncLoop(
            name,
            SyncParts(self._client, self._rooms, self._reader, self._trust),
            clock,
            beside=(
                self._trust.follow,
                self._signs.follow,
                self._keep_offers,
                self._room_signals.follow_typing,
                self._room_signals.follow_receipts,
            ),
            prepared=self._prepare,
            alarm=self._raise_alarm,
        )
        self._running = False
        self._clock = clock
        self._forgery_told: dict[str, int] = {}

    def __repr__(self) -> str:
        return f"MatrixMessenger({self.name!r})"

    # ---- who it is ----

    @property
    def account(self) -> str:
        """The account's id; see ``contracts.messenger``."""
        return self._client.user

    @property
    def handle(self) -> str:
        """What others find it by, which is its id."""
        return self._client.user

    @staticmethod
    def is_account(account: str) -> bool:
        """Whether it looks like ``@ada:example.org``; a display name is nobody."""
        return USER.fullmatch(account) is not None

    # ---- listening ----

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled. Whom it asks and tells is who was named before it began.

        Raises:
            ConfigurationError: The homeserver does not let us in, or the folder cannot be used.
                Nothing was received.
            MessengerFault: It runs already, or the homeserver lets us in no longer; or nobody said
                what may be confirmed, and nothing was received.
        """
        if self._running:
            raise MessengerFault(f"The messenger {self.name} is listening already.")
        if self._settle is None:
            raise MessengerFault(
                f"The messenger {self.name} was not told what is on disk, so it receives nothing."
            )
        self._rooms.begin(self._known, self._passed)
        self._reader.begin(self._known, self._reacted)
        self._running = True
        try:
            around = self._room_signals.around(receive, self._known, self._settle)
            await self._listener.run(around, self._settle)
        finally:
            self._running = False

    async def _keep_offers(self) -> None:
        """Have buttons known to another run: a stop may be among them."""
        while True:
            await self._offers.changed.wait()
            self._offers.changed.clear()
            try:
                content = self._offers.kept()
                await asyncio.to_thread(self._client.folder.write, OFFERS_FILE, content)
            except OSError as error:
                log.warning("%s: buttons were not kept: %s", self.name, error)

    async def _prepare(self) -> None:
        if not self._offers.known:
            kept = await asyncio.to_thread(self._client.folder.read, OFFERS_FILE)
            self._offers.restore(kept or b"[]")
        limits = await self._client.call("GET", "/_matrix/client/v1/media/config")
        most = limits.get("m.upload.size")
        if type(most) is int and most > 0:
            self.file_bytes = min(most, FILE_BYTES)

    def verify_with(self, prompt: VerificationPrompt) -> None:
        """Have emoji shown to somebody here; see ``contracts.verification``."""
        self._prompt.ask(prompt)

    async def begin_verification(self, account: str) -> str:
        """Ask somebody's client; see ``contracts.verification``.

        Raises:
            MessengerFault: It could not be sent.
        """
        await self._until_ready()
        return await self._trust.begin(account, await self._rooms.private.open(account))

    async def confirm_verification(self, verification: str) -> None:
        """Both ends show the same; see ``contracts.verification``.

        Raises:
            MessengerFault: There is no such verification any more, or nothing to confirm in it.
        """
        await self._trust.verification.confirm(verification)

    async def reject_verification(self, verification: str) -> None:
        """The ends do not show the same; see ``contracts.verification``.

        Raises:
            MessengerFault: There is no such verification any more.
        """
        await self._trust.verification.reject(verification)

    def chat_assurance(self, chat: Chat) -> Assurance:
        """Return what a room is worth; see ``contracts.chats``."""
        return self._trust.room_assurance(chat.id)

    def _keys_changed(self, change: KeyChange) -> None:
        """Tell the admins that somebody's keys are others, or that they have a new device."""
        if not self._known(Address(PLATFORM, change.user)) and change.user != self.account:
            return
        if change.kind is KeyChangeKind.MASTER_REPLACED:
            told = said(
                "The keys of {who} on Matrix are not those that they were."
                " Nothing that they write moves a robot until emoji were compared anew.",
                who=change.user,
            )
        elif change.vouched:
            told = said("{who} has a new device on Matrix.", who=change.user)
        else:
            told = said(
                "{who} has a new device on Matrix that they have not verified themselves.",
                who=change.user,
            )
        self._alarm(MessengerFault(told))

    def _is_known(self, account: str) -> bool:
        return self._known(Address(PLATFORM, account))

    def _forged(self, account: str) -> None:
        """Tell the admins, now and then, that somebody writes in the name of another."""
        now_ns = self._clock.monotonic_ns()
        if not self._is_known(account) or now_ns < self._forgery_told.get(account, 0):
            return
        if len(self._forgery_told) >= FORGERIES_AT_MOST:
            self._forgery_told.clear()
        self._forgery_told[account] = now_ns + FORGERY_NS
        self._alarm(
            MessengerFault(
                said(
                    "Something came in the name of {who} on Matrix that they have not sent, or not"
                    " now. It moved nothing. Whoever runs the homeserver may be lying.",
                    who=account,
                )
            )
        )

    async def _cannot_read(self, room: str) -> None:
        await self._speaker.answer(
            self._rooms.chat(room),
            said(
                "I cannot decrypt what you wrote, so I have not read it, not even a stop."
                " Please write it once more."
            ),
            public=True,
        )

    def _raise_alarm(self, fault: MessengerFault) -> None:
        self._alarm(fault)

    def alarm_with(self, alarm: Alarm) -> None:
        """Have somebody told when the account is lost; see ``contracts.messenger``."""
        self._alarm = alarm

    def settle_with(self, settle: Settle) -> None:
        """Ask before anything is confirmed; see ``contracts.messenger``."""
        self._settle = settle

    def know_with(self, known: Knows) -> None:
        """Read first what people known here sent; see ``contracts.messenger``."""
        self._known = known

    def catching_up(self) -> bool:
        """Return whether backlog may still come; see ``contracts.messenger``."""
        return self._listener.catching_up

    def is_connected(self) -> bool:
        """Return whether the homeserver answers us; see ``contracts.messenger``."""
        return self._running and self._listener.is_connected

    def watch_chats(self, passed: Passed) -> None:
        """Have somebody told what happens to rooms; see ``contracts.messenger``."""
        self._passed = passed

    def watch_reactions(self, reacted: Reacted) -> None:
        """Have somebody told what people put beside messages; see ``contracts.messenger``."""
        self._reacted = reacted

    # ---- speaking ----

    async def send(self, outbound: Outbound) -> str:
        """Send, encrypted where the room is, and return the id of the (last) message.

        Raises:
            ChatGone: We are not in that room.
            MessengerFault: Not sent; or, when the connection broke before the answer, perhaps sent.
        """
        await self._until_ready()
        return await self._speaker.send(await self._placed(outbound))

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Make a message look like this; see ``contracts.messenger``.

        Raises:
            MessageGone: There is no such message any more, or it has not the room for that.
            MessengerFault: Not changed, or it cannot be known whether it was.
        """
        await self._until_ready()
        await self._speaker.edit(message, await self._placed(outbound))

    def private_chat(self, account: str) -> Chat | None:
        """Return the room with somebody alone, if there is one; see ``contracts.chats``."""
        room = self._rooms.private.find(account)
        return self._rooms.chat(room) if room else None

    async def _placed(self, outbound: Outbound) -> Outbound:
        """Return what is said to an account as said in the room with it alone, which it may open.

        Raises:
            MessengerFault: There is none, or it cannot be known.
        """
        if not outbound.chat.id.startswith("@"):
            return outbound
        room = await self._rooms.private.open(outbound.chat.id)
        return replace(outbound, chat=self._rooms.chat(room))

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Keep a message in sight, or no longer; see ``contracts.messenger``.

        Raises:
            MessageGone: There is no such message any more.
            MessengerFault: Not done; only who may change the room's state can do it.
        """
        await self._until_ready()
        await self._speaker.pin(chat.id, message, pinned=pinned)

    async def react(self, chat: Chat, message: str, emoji: str) -> None:
        """Put an emoji beside a message.

        Raises:
            MessengerFault: It is not there, or it cannot be known.
        """
        await self._until_ready()
        await self._signs.put(chat.id, message, emoji)

    async def retract(self, chat: Chat, message: str) -> None:
        """Take a message out of a room; see ``contracts.messenger``.

        Raises:
            MessageGone: It can never be done.
            MessengerFault: Not done, or it cannot be known.
        """
        await self._until_ready()
        await self._speaker.retract(chat.id, message)

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Say something in answer to a tap; nothing waits here. Never raises."""
        if text and self._listener.ready.is_set():
            await self._speaker.answer(inbound.chat, text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file that somebody sent; see ``contracts.messenger``."""
        return self._fetcher.fetch(enclosure)

    async def _until_ready(self) -> None:
        if self._listener.ready.is_set():
            return
        try:
            async with asyncio.timeout(READY_WITHIN_S):
                await self._listener.ready.wait()
        except TimeoutError:
            raise MessengerFault(
                f"The messenger {self.name} is not connected. Nothing was sent."
            ) from None


def _nobody_is_told(_what: object) -> None:
    pass


def _anybody(_who: object) -> bool:
    return True


def matrix_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> MatrixMessenger:
    """Make it from its table in the configuration. Nothing is opened.

    Raises:
        ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
    """
    return MatrixMessenger(name, read_settings(name, settings), clock)
