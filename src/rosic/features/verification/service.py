"""Verifications under way, and who is shown their emoji.

Whoever runs a homeserver may stand between ROSIC and a person, and would let each of them see other
emoji. So they are shown to whoever looks after the place where it could neither put in others nor
answer in their name: on another messenger, or in a chat whose keys were compared before; and to
whoever sits at the machine itself, who is the first.
"""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

from rosic.contracts.chats import chat_assurance_of
from rosic.contracts.verification import VerificationEnd, VerifiesDevices
from rosic.core.identity import Address
from rosic.core.message import ChatKind
from rosic.core.policy.roles import Assurance
from rosic.core.records import Decided
from rosic.errors import Expired, MessengerFault
from rosic.features.verification import messages as words
from rosic.gateway.delivery.notifier import Notification

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.verification import ShownCode, VerificationResult
    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.message import Chat
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions

PENDING_AT_MOST: Final = 200
LASTS_S: Final = 600.0
"""As long as one lasts at the most, so do the buttons."""
SHOWN_AT_MOST: Final = 5
"""Of one account in that time: whoever runs a homeserver begins as many as they like."""


log = logging.getLogger("rosic.verification")


class PendingVerification:
    """One that is under way.

    Attributes:
        number: What people and buttons name it by.
        messenger: On which.
        account: Whose devices are verified there.
        code: What is compared; None: it is not there yet.
        shown_in: Messenger and chat where it was shown.
        result: How it ended; None: it has not.
        shown_ns: When the code was shown, monotonic clock.
    """

    def __init__(self, number: int, messenger: Messenger, account: str, verification: str) -> None:
        self.number = number
        self.messenger = messenger
        self.account = account
        self.verification = verification
        self.code: ShownCode | None = None
        self.shown_in: set[tuple[str, str]] = set()
        self.told: tuple[PrincipalId, ...] = ()
        self.result: VerificationResult | None = None
        self.shown_ns = 0

    @property
    def is_verified(self) -> bool:
        """Whether it has ended well."""
        return self.result is not None and self.result.end is VerificationEnd.COMPARED

    def landed(self, messenger: Messenger, chat: Chat, _message: str) -> None:
        """Hear where it was shown."""
        self.shown_in.add((messenger.name, chat.id))

    def ends(self, result: VerificationResult) -> None:
        """Take in how it ended."""
        self.result = result

    def shows(self, code: ShownCode, told: tuple[PrincipalId, ...], now_ns: int) -> None:
        """Take in what is compared, by whom, and from when on."""
        self.code, self.told, self.shown_ns = code, told, now_ns


class DeviceVerifications:
    """Shows emoji to whoever may compare them, and takes what they say.

    Args:
        rooms: Who knows people.
        reach: Tells them.
        changes: Writes down who has verified whom.
        admins: Who looks after the place.
        clock: Dates it.
    """

    def __init__(
        self,
        rooms: Components,
        reach: Notifier,
        changes: Transactions,
        admins: Callable[[], Iterable[PrincipalId]],
        clock: Clock,
    ) -> None:
        self._directory = rooms.authoriser.directory
        self._reach = reach
        self._changes = changes
        self._admins = admins
        self._clock = clock
        self._number = 0
        self._pending: dict[tuple[str, str], PendingVerification] = {}
        self._ended: dict[int, PendingVerification] = {}
        self._shown_ns: dict[tuple[str, str], list[int]] = {}
        self._served: dict[str, Messenger] = {}
        self._devices: dict[str, VerifiesDevices] = {}

    def serve(self, messenger: Messenger) -> None:
        """Compare for a messenger's people from now on, if their devices can be verified."""
        if isinstance(messenger, VerifiesDevices):
            self._served[messenger.name] = messenger
            self._devices[messenger.name] = messenger
            messenger.verify_with(MessengerPrompt(self, messenger))

    def serves(self) -> bool:
        """Whether there is a messenger whose people's devices can be verified."""
        return bool(self._served)

    def can_verify(self, messenger: Messenger) -> bool:
        """Whether the devices of a messenger's people can be verified."""
        return messenger.name in self._devices

    # ---- beginning ----

    async def begin(self, messenger: Messenger, account: str) -> PendingVerification:
        """Ask somebody's client.

        Raises:
            Expired: It could not be asked.
        """
        try:
            verification = await self._devices[messenger.name].begin_verification(account)
        except MessengerFault as fault:
            raise Expired(words.NOT_ASKED) from fault
        return self._of(messenger, account, verification)

    async def begin_with(self, person: Principal) -> PendingVerification | None:
        """Ask somebody's client, wherever their devices can be verified; None: nowhere.

        Raises:
            Expired: It could not be asked.
        """
        for messenger in self._served.values():
            for address in person.addresses:
                if address.platform == messenger.platform:
                    return await self.begin(messenger, address.account)
        return None

    def _of(self, messenger: Messenger, account: str, verification: str) -> PendingVerification:
        key = (messenger.name, verification)
        found = self._pending.get(key)
        if found is None:
            while len(self._pending) >= PENDING_AT_MOST:
                del self._pending[next(iter(self._pending))]
            self._number += 1
            found = PendingVerification(self._number, messenger, account, verification)
            self._pending[key] = found
        return found

    # ---- who compares ----

    def comparers(self, messenger: Messenger) -> tuple[str, ...]:
        """Return the names of those who can be shown emoji of a messenger's people."""
        return tuple(
            self._directory.name(admin)
            for admin in self._admins()
            if any(_is_apart(messenger, *one) for one in self._reach.chats(admin))
        )

    def pending(self) -> tuple[PendingVerification, ...]:
        """Return those under way, oldest first."""
        return tuple(self._pending.values())

    def find(self, number: str) -> PendingVerification | None:
        """Return one that is under way; None: there is none of this number, or it has ended."""
        return next((one for one in self._pending.values() if str(one.number) == number), None)

    def were_shown(self, where: tuple[str, str], *, but: PendingVerification) -> bool:
        """Whether another was shown in a chat lately that did not end well, as far as is kept."""
        since_ns = self._clock.monotonic_ns() - int(LASTS_S * 1e9)
        return any(
            where in one.shown_in and one is not but and one.shown_ns >= since_ns
            for one in self._ended.values()
            if not one.is_verified
        )

    def ended(self, number: int) -> PendingVerification | None:
        """Return one of the last that have ended."""
        return self._ended.get(number)

    def name(self, pending: PendingVerification) -> str:
        """Return how whoever is verified is shown."""
        person = self._who(pending)
        return pending.account if person is None else self._directory.name(person)

    def _who(self, pending: PendingVerification) -> PrincipalId | None:
        found = self._directory.at(Address(pending.messenger.platform, pending.account))
        return None if found is None else found[0].id

    # ---- what comes of it ----

    async def confirm(self, pending: PendingVerification, by: PrincipalId) -> None:
        """Somebody has compared: the same. It is on disk before it counts.

        Raises:
            RecordUnavailable: It cannot be written down; nothing is verified.
            Expired: It ended meanwhile.
        """
        device = "" if pending.code is None else pending.code.device
        whose = f"{pending.messenger.platform}:{pending.account} {device}"
        decided = Decided(
            act="verify",
            by=by,
            about=self._who(pending) or "",
            at_ns=self._clock.wall_ns(),
            digest=blake2b(whose.encode(), digest_size=16).digest(),
        )
        async with self._changes.turn() as turn:
            await turn.write((decided,))
        try:
            await self._devices[pending.messenger.name].confirm_verification(pending.verification)
        except MessengerFault as fault:
            raise Expired(words.ENDED) from fault

    async def reject(self, pending: PendingVerification) -> None:
        """Somebody has compared: not the same.

        Raises:
            Expired: It ended meanwhile.
        """
        try:
            await self._devices[pending.messenger.name].reject_verification(pending.verification)
        except MessengerFault as fault:
            raise Expired(words.ENDED) from fault

    # ---- what a messenger says ----

    def knows(self, messenger: Messenger, account: str) -> bool:
        """Whether somebody is known here."""
        return self._directory.at(Address(messenger.platform, account)) is not None

    def shown(self, messenger: Messenger, code: ShownCode) -> None:
        """Show a code to whoever may compare it; where that is nobody, say so to its owner.

        Of one account so many are shown and no more: alarms may not drown in them.
        """
        if not self._may_show(messenger, code.user):
            log.warning("%s: too many verifications of one account", messenger.name)
            return
        pending = self._of(messenger, code.user, code.verification)
        admins = tuple(self._admins())
        pending.shows(code, admins, self._clock.monotonic_ns())
        notice = Notification(
            text=words.compare(self.name(pending), code.user, code.device, code.text),
            buttons=words.buttons(pending.number),
            urgent=True,
            lifetime_s=LASTS_S,
            landed=pending.landed,
        )
        if not self._give(admins, notice, lambda *there: _is_apart(messenger, *there)):
            self._tell_them(pending, words.NOBODY_COMPARES)

    def _may_show(self, messenger: Messenger, account: str) -> bool:
        now_ns, key = self._clock.monotonic_ns(), (messenger.name, account)
        since_ns = now_ns - int(LASTS_S * 1e9)
        lately = [one for one in self._shown_ns.pop(key, ()) if one > since_ns]
        may = len(lately) < SHOWN_AT_MOST
        self._shown_ns[key] = [*lately, now_ns] if may else lately
        while len(self._shown_ns) > PENDING_AT_MOST:
            del self._shown_ns[next(iter(self._shown_ns))]
        return may

    def told(self, messenger: Messenger, result: VerificationResult) -> None:
        """Tell both sides how one ended."""
        pending = self._pending.pop((messenger.name, result.verification), None)
        if pending is None:
            return
        pending.ends(result)
        self._ended[pending.number] = pending
        while len(self._ended) > PENDING_AT_MOST:
            del self._ended[next(iter(self._ended))]
        self._tell_them(pending, words.YOU_ARE if pending.is_verified else words.YOU_ARE_NOT)
        self._reach.give(pending.told, Notification(text=self.outcome(pending)))

    def outcome(self, pending: PendingVerification) -> str:
        """Return how one ended, for whoever compared; empty: it has not."""
        result, name = pending.result, self.name(pending)
        if result is None:
            return ""
        if pending.is_verified:
            return words.is_verified(name, pending.account)
        kept = result.end is not VerificationEnd.NOT_KEPT
        why = words.WHY.get(result.code, words.CANCELLED) if kept else words.NOT_KEPT
        return words.is_not_verified(name, pending.account, why)

    def _tell_them(self, pending: PendingVerification, text: str) -> None:
        who = self._who(pending)
        if who is not None:
            platform = pending.messenger.platform
            notice = Notification(text=text)
            self._give((who,), notice, lambda messenger, _: messenger.platform == platform)

    def _give(
        self,
        people: Iterable[PrincipalId],
        notice: Notification,
        where: Callable[[Messenger, Chat], bool],
    ) -> int:
        """Tell each of them in every chat of theirs that is such a one; return how many."""
        count = 0
        for who in people:
            places = [one for one in self._reach.places(who) if where(one.messenger, one.chat)]
            count += self._reach.give_at(who, places, notice)
        return count


def _is_apart(verified: Messenger, messenger: Messenger, chat: Chat) -> bool:
    """Whether whoever runs one messenger could put nothing into a chat in our name or another's."""
    if messenger.platform != verified.platform:
        return True
    private = chat.kind is ChatKind.PRIVATE
    return private and chat_assurance_of(messenger, chat) >= Assurance.E2EE_VERIFIED


class MessengerPrompt:
    """Implements `contracts.verification.VerificationPrompt` for one messenger."""

    def __init__(self, verifications: DeviceVerifications, messenger: Messenger) -> None:
        self._verifications = verifications
        self._messenger = messenger

    def accepts(self, user: str) -> bool:
        """Whether this person is known here."""
        return self._verifications.knows(self._messenger, user)

    def show(self, code: ShownCode) -> None:
        """Show a code to whoever may compare it."""
        self._verifications.shown(self._messenger, code)

    def tell(self, result: VerificationResult) -> None:
        """Tell both sides how one ended."""
        self._verifications.told(self._messenger, result)
