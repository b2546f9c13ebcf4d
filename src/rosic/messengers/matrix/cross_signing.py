"""Cross-signing: the robot's own three keys, and what the keys of others are worth.

Matrix specification v1.11, client-server API, "Cross-signing": ``POST
/_matrix/client/v3/keys/device_signing/upload`` and ``.../keys/signatures/upload``. Modern clients
encrypt to no device that its owner's self-signing key does not vouch for, so an account whose
device is not signed would hear nothing.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any, Final, Protocol

import msgspec

from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.errors import MatrixError
from rosic.messengers.matrix.identity_book import IdentityBook, IdentityStanding, KeyChange
from rosic.messengers.matrix.signed_json import ED25519, sign, signed_part, with_signature
from rosic.messengers.matrix.signing_keys import CrossSigningKeys, SigningSeeds, key_object
from rosic.messengers.matrix.user_keys import MASTER, SELF_SIGNING, USER_SIGNING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from nio.crypto import Olm

    from rosic.core.secret import Secret
    from rosic.messengers.matrix.signing_keys import DeviceAccount
    from rosic.messengers.matrix.user_keys import (
        Call,
        DeviceIdentity,
        KeyDirectory,
        UserKeys,
    )

_LOGGER = logging.getLogger(__name__)

UPLOAD_KEYS: Final = "/_matrix/client/v3/keys/device_signing/upload"
UPLOAD_SIGNATURES: Final = "/_matrix/client/v3/keys/signatures/upload"
KEYS_FILE: Final = "cross-signing.sealed"
BOOK_FILE: Final = "identities.sealed"
PASSWORD: Final = "m.login.password"  # noqa: S105 - the name of a way to authenticate

RECOVERY: Final = (
    "Bring the folder of this messenger back from your copy. Without one, reset the cross-signing"
    " keys of the account: everybody must then compare emoji with the robot once more."
)


class OlmDeviceAccount:
    """The device of nio's machine."""

    def __init__(self, olm: Olm) -> None:
        self._account = olm.account
        self.user: str = olm.user_id
        self.device: str = olm.device_id
        self.ed25519: str = olm.account.identity_keys["ed25519"]
        self.curve25519: str = olm.account.identity_keys["curve25519"]

    def sign(self, message: bytes) -> str:
        """Return its signature over these bytes, as Base64 without padding."""
        return str(self._account.sign(message.decode()))


class SealedStore(Protocol):
    """Keeps small files that nobody else can read or change unnoticed."""

    def read(self, name: str) -> bytes | None:
        """Return what was kept; None for nothing. Raises ``ConfigurationError`` when damaged."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Keep all of it, or what was there before. Raises ``OSError``."""
        ...


class CrossSigning:
    """What this account signs, and what it takes from others' signatures. Nothing before `start`.

    Args:
        account: This device.
        call: To the homeserver.
        folder: Keeps the private keys, and whose keys were compared.
        directory: What the homeserver shows of people's keys.
        tell: Hears what people must hear of: a master key that was replaced, a new device; of
            this account too. Called on the event loop, once for each.
        knows: Whether somebody is known to ROSIC: what was seen of them is never let go.
    """

    def __init__(
        self,
        account: DeviceAccount,
        call: Call,
        folder: SealedStore,
        directory: KeyDirectory,
        tell: Callable[[KeyChange], None],
        *,
        knows: Callable[[str], bool],
    ) -> None:
        self.account = account
        self._call = call
        self._folder = folder
        self.directory = directory
        self._tell = tell
        self._keys: CrossSigningKeys | None = None
        self._book = IdentityBook(account.user, knows)
        self._writing = asyncio.Lock()
        self._unwritten = False

    # ---- our own keys ----

    async def start(self, password: Secret | None = None) -> None:
        """Have the account's keys known to the homeserver and this device signed by them.

        The first time they are made. They are kept before the homeserver hears of them, so that it
        never knows keys that we have lost.

        Args:
            password: Of the account, for a homeserver that asks for it once more.

        Raises:
            ConfigurationError: The account has other keys already, or the homeserver wants to be
                authenticated to in another way. Nothing was changed there.
            MessengerFault: It did not answer, or did not take something; trying again may help.
        """
        self._restore()
        user = self.account.user
        shown = await self.directory.keys_of(user, fresh=True)
        if shown.master_object and (self._keys is None or shown.master != self._keys.public[0]):
            self._keys = None  # they are worth nothing: nobody is to vouch for them
            raise ConfigurationError(
                f"The account {user} has cross-signing keys that this gateway does not have.",
                hint=RECOVERY,
            )
        if self._keys is None:
            await self._make_keys()
        await self._publish(shown, password)

    async def reset(self, password: Secret) -> None:
        """Give the account new keys in place of those it has. Everybody must compare emoji anew.

        Raises:
            ConfigurationError: The password is wrong, or is not what the homeserver asks for.
            MessengerFault: It did not answer, or did not take something. Do it again.
        """
        self._restore_book()
        await self._make_keys()
        shown = await self.directory.keys_of(self.account.user, fresh=True)
        await self._publish(shown, password)

    def own_keys(self) -> dict[str, str]:
        """Return what others compare with us, by key id: this device and the master key."""
        device = self.account
        own = {f"{ED25519}:{device.device}": device.ed25519}
        if self._keys is not None:
            master = self._keys.public[0]
            own[f"{ED25519}:{master}"] = master
        return own

    def _restore(self) -> None:
        content = self._folder.read(KEYS_FILE)
        if content is not None:
            try:
                seeds = msgspec.json.decode(content, type=SigningSeeds)
                keys = CrossSigningKeys(seeds)
            except ValueError as error:
                raise ConfigurationError(
                    f"The kept cross-signing keys of {self.account.user} are damaged.",
                    hint=RECOVERY,
                ) from error
            if seeds.owner != self.account.user:
                raise ConfigurationError(
                    f"The kept cross-signing keys are those of {seeds.owner}, not of"
                    f" {self.account.user}.",
                    hint="Give each account a folder of its own.",
                )
            self._keys = keys
        self._restore_book()

    def _restore_book(self) -> None:
        content = self._folder.read(BOOK_FILE)
        if content is None:
            return
        try:
            self._book.restore(content)
        except ValueError as error:
            raise ConfigurationError(
                f"What was kept of the people that {self.account.user} knows is damaged.",
                hint=RECOVERY,
            ) from error

    async def _make_keys(self) -> None:
        keys = CrossSigningKeys.fresh(self.account.user)
        await self._write(KEYS_FILE, msgspec.json.encode(keys.seeds))
        self._keys = keys

    async def _publish(self, shown: UserKeys, password: Secret | None) -> None:
        keys, user = self._private(), self.account.user
        if (shown.master, shown.self_signing, shown.user_signing) != keys.public:
            await self._upload_keys(keys, password)
            shown = await self.directory.keys_of(user, fresh=True)
            if (shown.master, shown.self_signing, shown.user_signing) != keys.public:
                raise MessengerFault("The homeserver does not show the keys that it was given.")
        await self._sign_own(keys, shown)
        self._book.compared(user, keys.public[0])
        self._note(shown)
        await self._write_book()

    async def _upload_keys(self, keys: CrossSigningKeys, password: Secret | None) -> None:
        user, (master, self_signing, user_signing) = self.account.user, keys.public
        body: dict[str, Any] = {
            "master_key": key_object(user, MASTER, master),
            "self_signing_key": sign(
                key_object(user, SELF_SIGNING, self_signing), user, keys.master
            ),
            "user_signing_key": sign(
                key_object(user, USER_SIGNING, user_signing), user, keys.master
            ),
        }
        try:
            await self._call("POST", UPLOAD_KEYS, body)
        except MatrixError as refused:
            if "flows" not in refused.body:
                raise
            await self._upload_again(body, _authentication(refused.body, user, password))

    async def _upload_again(self, body: dict[str, Any], auth: dict[str, Any]) -> None:
        try:
            await self._call("POST", UPLOAD_KEYS, {**body, "auth": auth})
        except MatrixError as refused:
            if "flows" not in refused.body:
                raise
            raise ConfigurationError(
                f"The homeserver did not take the password of {self.account.user} for its"
                " cross-signing keys."
            ) from None

    async def _sign_own(self, keys: CrossSigningKeys, shown: UserKeys) -> None:
        """Sign this device with the self-signing key, and the master key with this device.

        What is signed of the device is what it has signed itself: nothing of a homeserver's.
        """
        account, user, master = self.account, self.account.user, keys.public[0]
        device = shown.device(account.device)
        if device is None:
            raise MessengerFault("The homeserver does not show the keys of this device yet.")
        if (device.ed25519, device.curve25519) != (account.ed25519, account.curve25519):
            raise MessengerFault("The homeserver shows other keys for this device than it has.")
        objects: dict[str, Any] = {}
        if not device.cross_signed:
            said = _unsigned(shown.shown_device(account.device))
            objects[account.device] = sign(said, user, keys.self_signing)
        if not shown.master_signed_by(user, account.device, account.ed25519):
            said = key_object(user, MASTER, master)
            signature = account.sign(signed_part(said))
            objects[master] = with_signature(said, user, f"{ED25519}:{account.device}", signature)
        if not objects:
            return
        await self._upload_signatures(user, objects)
        signed = (await self.directory.keys_of(user, fresh=True)).device(account.device)
        if signed is None or not signed.cross_signed:
            raise MessengerFault("The homeserver does not show the signature that it was given.")

    async def _upload_signatures(self, user: str, objects: Mapping[str, Any]) -> None:
        answer = await self._call("POST", UPLOAD_SIGNATURES, {user: dict(objects)})
        if answer.get("failures"):
            raise MessengerFault("The homeserver did not take a signature of ours.")

    def _private(self) -> CrossSigningKeys:
        if self._keys is None:
            raise MessengerFault("The cross-signing keys of this account are not ready yet.")
        return self._keys

    # ---- keys of others ----

    def is_compared(self, user: str) -> bool:
        """Whether a person's master key was compared, and no other was shown since."""
        return self._book.is_compared(user)

    async def look_up(self, user: str, *, fresh: bool = False) -> tuple[UserKeys, IdentityStanding]:
        """Return what is shown of a person's keys, and what their master key is worth.

        Args:
            user: The person.
            fresh: Ask the homeserver, whatever is kept.

        Raises:
            MessengerFault: The homeserver did not answer.
        """
        keys = await self.directory.keys_of(user, fresh=fresh)
        if self._note(keys) or self._unwritten:
            await self._write_book_if_possible()
        return keys, self._book.standing(user, keys.master)

    async def look_up_all(self, users: Iterable[str]) -> list[tuple[UserKeys, IdentityStanding]]:
        """Return the same of many people; of whom the homeserver does not answer, nothing."""
        found = await self.directory.keys_of_all(users)
        noted = [self._note(keys) for keys in found]
        if any(noted) or self._unwritten:
            await self._write_book_if_possible()
        return [(keys, self._book.standing(keys.user, keys.master)) for keys in found]

    @property
    def version(self) -> tuple[int, int]:
        """Another one after anything has changed that is known of anybody's keys."""
        return self._book.version, self.directory.version

    def was_compared(self, user: str) -> bool:
        """Whether two people have compared keys of this person."""
        return self._book.was_compared(user)

    async def is_confidential(self, room: str, members: Iterable[str]) -> bool:
        """Whether a room has, or ever had, a member whose keys were compared.

        What is said there is for such members alone from then on, whoever the homeserver says has
        left.
        """
        if self._book.is_confidential(room):
            return True
        if not any(self.was_compared(user) for user in members):
            return False
        self._book.make_confidential(room)
        await self._write_book_if_possible()
        return True

    async def keys_changed(self, users: Iterable[str]) -> None:
        """A sync says that keys of these people have changed. Of whom is known here, look at once.

        So a new device, or another master key, is told of before anything came from it. Never
        raises: what cannot be looked up now is looked up when it is needed.
        """
        for user in users:
            self.directory.forget(user)
            if not self._book.knows(user):
                continue
            try:
                await self.look_up(user)
            except MessengerFault as fault:
                _LOGGER.info("The keys of %s are looked up later: %s", user, fault)

    async def is_verified_device(
        self, user: str, device: str, *, trust_on_first_use: bool = False
    ) -> bool:
        """Whether a device is that person's, by keys that two people have compared.

        Either the device's own fingerprint was compared, or the person's self-signing key vouches
        for it, their master key vouches for that, and it is the one that was compared. Once
        another master key is shown nothing of theirs counts, until it was compared anew.

        Args:
            user: The person.
            device: Id of the device.
            trust_on_first_use: A master key that was merely seen first counts as well.

        Raises:
            MessengerFault: The homeserver did not answer.
        """
        keys, standing = await self.look_up(user)
        found = keys.device(device)
        return found is not None and self.is_verified(
            found, standing, trust_on_first_use=trust_on_first_use
        )

    def is_verified(
        self, device: DeviceIdentity, standing: IdentityStanding, *, trust_on_first_use: bool
    ) -> bool:
        """The same for a device that was looked up."""
        if standing is IdentityStanding.REPLACED:
            return False
        if self._book.is_compared_device(device):
            return True
        least = IdentityStanding.FIRST_SEEN if trust_on_first_use else IdentityStanding.COMPARED
        return device.cross_signed and standing >= least

    async def compared(self, device: DeviceIdentity, master: str) -> None:
        """Two people have compared this: from now on it counts.

        The master key is signed with our user-signing key; that the homeserver takes the signature
        is a convenience, and nothing hangs on it.

        Args:
            device: Whose own fingerprint was compared.
            master: The master key that was compared with it; empty for none.

        Raises:
            MessengerFault: It could not be kept, and does not count.
        """
        if device.user == self.account.user:
            raise MessengerFault("An account does not vouch for itself.")
        if master:
            self._book.compared(device.user, master)
        if not master or not device.cross_signed:
            self._book.compared_device(device)
        try:
            await self._write_book()
        except MessengerFault:
            self._book.revoke(device.user)
            raise
        if master:
            await self._vouch_for(device.user, master)

    async def revoke(self, user: str) -> None:
        """What was compared of this person counts no longer.

        Raises:
            MessengerFault: It could not be kept. It counts no longer until the next start.
        """
        self._book.revoke(user)
        await self._write_book()

    async def _vouch_for(self, user: str, master: str) -> None:
        try:
            by = self._private().user_signing
            said = sign(key_object(user, MASTER, master), self.account.user, by)
            await self._upload_signatures(user, {master: said})
        except MessengerFault as fault:
            _LOGGER.warning("The homeserver has no signature of ours for %s: %s", user, fault)
        self.directory.forget(user)

    # ---- what is kept ----

    def _note(self, keys: UserKeys) -> bool:
        changes, changed = self._book.observe(keys)
        for change in changes:
            if (change.user, change.device) != (self.account.user, self.account.device):
                self._tell(change)
        return changed

    async def _write_book_if_possible(self) -> None:
        try:
            await self._write_book()
        except MessengerFault as fault:
            _LOGGER.warning("%s", fault)

    async def _write_book(self) -> None:
        self._unwritten = True
        async with self._writing:
            await self._write(BOOK_FILE, self._book.content())
            self._unwritten = False

    async def _write(self, name: str, content: bytes) -> None:
        try:
            await asyncio.to_thread(self._folder.write, name, content)
        except OSError as error:
            raise MessengerFault("The keys of this Matrix account could not be kept.") from error


def _unsigned(value: Mapping[str, Any]) -> dict[str, Any]:
    return {name: of for name, of in value.items() if name not in ("signatures", "unsigned")}


def _authentication(asked: Mapping[str, Any], user: str, password: Secret | None) -> dict[str, Any]:
    """Answer a homeserver that asks for the password ("User-Interactive Authentication API")."""
    flows = asked.get("flows")
    stages = [flow.get("stages") for flow in flows if isinstance(flow, dict)] if flows else []
    if password is None or [PASSWORD] not in stages:
        raise ConfigurationError(
            f"The homeserver asks for the password of {user} before it takes its cross-signing"
            " keys."
            if [PASSWORD] in stages
            else f"The homeserver wants {user} to sign in on its own page before it takes"
            " cross-signing keys.",
            hint="Give the messenger a password, or allow it there and start again.",
        )
    return {
        "type": PASSWORD,
        "identifier": {"type": "m.id.user", "user": user},
        "password": password.reveal(),
        "session": asked.get("session", ""),
    }
