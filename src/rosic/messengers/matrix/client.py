"""One account at one homeserver, by way of matrix-nio: everything that crosses the wire."""

from __future__ import annotations

import asyncio
import json
import logging
import uuid
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final, TypeVar
from urllib.parse import quote

import msgspec
import nio

from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind, refusal, trouble
from rosic.messengers.matrix.olm_machine import AccountClient
from rosic.messengers.matrix.sealed_folder import SealedFolder

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.messengers.matrix.settings import MatrixSettings

T = TypeVar("T")

DEVICE_FILE: Final = "device.sealed"
CALL_S: Final = 20.0
FILE_S: Final = 300.0
GIVE_UP_S: Final = 20.0
WAITS_S: Final = (0.3, 1.0)
"""Before something is said once more. It has the same transaction, so it is shown once."""
OK: Final = range(200, 300)
DENIED: Final = 401
API: Final = "/_matrix/client/v3"

log = logging.getLogger("rosic.messengers.matrix")


class SignedIn(msgspec.Struct, frozen=True):
    """A device of the account, and the token it speaks with."""

    user: str
    device: str
    token: str


class MatrixClient:
    """Connections are open only while it is held.

    Args:
        name: Of the messenger, for the log and for sentences.
    """

    def __init__(self, name: str, settings: MatrixSettings, clock: Clock) -> None:
        self.folder = SealedFolder(settings.folder)
        self._name = name
        self._settings = settings
        self._clock = clock
        self._nio: Any = None
        self._held = 0
        self._opening = asyncio.Lock()
        self._signing_in = asyncio.Lock()

    @property
    def user(self) -> str:
        """The account's id."""
        return self._settings.user

    @property
    def device(self) -> str:
        """The device's id; empty until it is signed in."""
        return "" if self._nio is None else str(self._nio.device_id or "")

    @property
    def library(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """The client of matrix-nio, with its sessions and the devices it knows; None until open."""
        return self._nio

    @property
    def rooms(self) -> Mapping[str, Any]:
        """What is known of the rooms that this account is in."""
        rooms: Mapping[str, Any] = {} if self._nio is None else self._nio.rooms
        return rooms

    def members(self, room: str) -> frozenset[str]:
        """Return who is in a room, or was invited; nobody, of a room that is not known."""
        found = self.rooms.get(room)
        return frozenset() if found is None else frozenset({*found.users, *found.invited_users})

    def is_encrypted(self, room: str) -> bool:
        """Whether a room is encrypted; once it was, nothing that the homeserver says undoes it."""
        found = self.rooms.get(room)
        return found is not None and bool(found.encrypted)

    # ---- beginning and end ----

    @asynccontextmanager
    async def held(self) -> AsyncIterator[None]:
        """Keep connections open while inside.

        Raises:
            ConfigurationError: The account or its folder cannot be used.
            MatrixError: The homeserver did not answer.
        """
        self._held += 1
        try:
            await self._open()
            yield
        finally:
            self._held -= 1
            if not self._held:
                await self._close()

    async def _open(self) -> None:
        async with self._opening:
            if self._nio is not None and self._nio.access_token:
                return
            await asyncio.to_thread(self.folder.open)
            if self._nio is None:
                self._nio = self._library()
            kept = self._kept()
            if kept is not None:
                self._nio.restore_login(kept.user, kept.device, kept.token)
                return
            try:
                signed_in = await self._sign_in()
            except MatrixError as refused:
                raise self._denied(refused) from None
            await self._keep(signed_in)

    def _library(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        config = nio.AsyncClientConfig(
            max_limit_exceeded=0,
            max_timeouts=0,
            encryption_enabled=True,
            pickle_key=self.folder.passphrase,
            store_sync_tokens=False,
            request_timeout=CALL_S,
        )
        return AccountClient(
            self._settings.homeserver,
            self._settings.user,
            store_path=str(self._settings.folder),
            config=config,
        )

    def _opened(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return self._nio

    def _account(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return self._nio.olm.account

    def _machine(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return self._nio.olm

    def _kept(self) -> SignedIn | None:
        content = self.folder.read(DEVICE_FILE)
        if content is None:
            return None
        kept = msgspec.json.decode(content, type=SignedIn)
        if kept.user != self._settings.user:
            raise ConfigurationError(
                f"The folder of the messenger {self._name} holds the keys of {kept.user}.",
                hint="Give each account a folder of its own.",
            )
        return kept

    async def _keep(self, signed_in: SignedIn) -> None:
        content = msgspec.json.encode(signed_in)
        try:
            await asyncio.to_thread(self.folder.write, DEVICE_FILE, content)
        except OSError as error:
            raise ConfigurationError(
                f"The folder of the messenger {self._name} cannot be written.",
                hint=f"({type(error).__name__})",
            ) from None

    async def _sign_in(self) -> SignedIn:
        """Sign in: as the device that this folder is of, or as a new one."""
        settings, library, password = self._settings, self._nio, self._settings.password
        if password is None:
            token = settings.token
            return await self._whose("" if token is None else token.reveal())
        found = await self._ask(lambda: library.login(password.reveal(), settings.device_name))
        if found.user_id != settings.user:
            raise ConfigurationError(
                f"The homeserver calls the account of the messenger {self._name} {found.user_id}.",
                hint="Write that as its user.",
            )
        return SignedIn(found.user_id, found.device_id, found.access_token)

    async def _whose(self, token: str) -> SignedIn:
        library = self._opened()
        library.access_token = token
        try:
            said = await self.call("GET", f"{API}/account/whoami")
        except MatrixError:
            library.access_token = ""
            raise
        user, device = said.get("user_id"), said.get("device_id")
        if user != self._settings.user or not isinstance(device, str):
            raise ConfigurationError(f"The token of the messenger {self._name} is of {user}.")
        self._nio.restore_login(user, device, token)
        return SignedIn(user, device, token)

    def _denied(self, refused: MatrixError) -> MatrixError | ConfigurationError:
        if refused.kind in {MatrixErrorKind.LOST, MatrixErrorKind.TOO_FAST}:
            return refused
        return ConfigurationError(
            f"The homeserver does not let the messenger {self._name} in.",
            hint="Check its user and its password, or its token.",
        )

    async def sign_in_again(self, refused: MatrixError) -> None:
        """Get a new token for the same device, whose keys and sessions stay.

        Raises:
            MatrixError: What was refused, where no password is known; or another fault.
        """
        if self._settings.password is None:
            raise refused
        before = self._nio.access_token
        async with self._signing_in:
            if self._nio.access_token != before:
                return
            log.warning("%s: signed out; signing in again (%s)", self._name, refused.reason)
            signed_in = await self._sign_in()
            if not refused.soft and self._nio.olm is not None:
                # The homeserver has forgotten the device, and with it the keys: they are put there
                # again, the same ones.
                account = self._account()
                account.shared = False
            await self._keep(signed_in)

    async def _close(self) -> None:
        library = self._nio
        if library is None:
            return
        await library.close()
        if library.store is not None and not library.store.database.is_closed():
            library.store.database.close()

    # ---- receiving ----

    async def sync(
        self, since: str, *, timeout_ms: int, full: bool, shape: Mapping[str, Any]
    ) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """Ask for what is new. What came encrypted is decrypted, where its key is known.

        Raises:
            MatrixError: No answer, or a refusal.
        """
        library = self._opened()
        # It passes over an answer that it believes to know, without decrypting it: what was not
        # confirmed is asked for again.
        library.next_batch = ""
        return await self._ask(
            lambda: library.sync(
                timeout_ms, dict(shape), since or None, full_state=full, set_presence="offline"
            ),
            within_s=CALL_S + timeout_ms / 1_000 if not full else FILE_S,
        )

    async def upkeep(self) -> None:
        """Keep the keys as they must be: ours at the homeserver, those of others known here."""
        library = self._nio
        for due, act in (
            (library.should_upload_keys, library.keys_upload),
            (library.should_query_keys, library.keys_query),
            (library.should_claim_keys, self._claim),
            (bool(library.outgoing_to_device_messages), library.send_to_device_messages),
        ):
            if due:
                try:
                    await self._ask(act)
                except MessengerFault as fault:
                    log.info("%s: keys were not looked after: %s", self._name, fault)

    async def renew_fallback_key(self) -> None:
        """Have a key at the homeserver for those who come when all one-time keys are used up.

        Raises:
            MatrixError: It is not there, or it cannot be known.
        """
        machine = self._machine()
        # matrix-nio makes none; what is underneath it does.
        account = machine.account._account  # noqa: SLF001
        account.generate_fallback_key()
        keys: dict[str, Any] = {}
        for name, key in account.fallback_key.items():
            said = {"key": key.to_base64(), "fallback": True}
            signature = machine.sign_json(said)
            owner = {self.user: {f"ed25519:{self.device}": signature}}
            keys[f"signed_curve25519:{name}"] = {**said, "signatures": owner}
        machine.save_account()
        await self.persist(lambda: self.call("POST", f"{API}/keys/upload", {"fallback_keys": keys}))
        account.mark_keys_as_published()
        machine.save_account()

    async def _claim(self) -> object:
        return await self._nio.keys_claim(self._nio.get_users_for_key_claiming())

    def decrypt(self, event: Any) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """Return an event that came encrypted as it was written; None where its key is missing."""
        try:
            return self._nio.decrypt_event(event)
        except nio.EncryptionError:
            return None

    # ---- sending ----

    async def send(
        self, room: str, kind: str, content: Mapping[str, Any], *, within_s: float = GIVE_UP_S
    ) -> str:
        """Put an event into a room, encrypted where the room is, and return its id.

        Raises:
            MatrixError: It is not there, or it cannot be known.
        """
        transaction = str(uuid.uuid4())
        found = await self.persist(
            lambda: self._nio.room_send(
                room, kind, dict(content), transaction, ignore_unverified_devices=True
            ),
            within_s=within_s,
        )
        return str(found.event_id)

    async def redact(self, room: str, event: str) -> None:
        """Take an event out of a room.

        Raises:
            MatrixError: It is still there, or it cannot be known.
        """
        transaction = str(uuid.uuid4())
        await self.persist(lambda: self._nio.room_redact(room, event, tx_id=transaction))

    async def upload(
        self,
        source: Callable[[], AsyncIterator[bytes]],
        size: int,
        media_type: str,
        *,
        encrypt: bool,
    ) -> tuple[str, dict[str, Any] | None]:
        """Put a file there; return its address, and how to decrypt it where it was encrypted.

        Raises:
            MatrixError: It is not there, or not as promised.
        """
        broken: list[Exception] = []

        async def read() -> AsyncGenerator[bytes]:
            try:
                async for piece in source():
                    yield piece
            except Exception as error:
                broken.append(error)
                raise

        async def act() -> Any:  # noqa: ANN401 - matrix-nio has no types
            answer, keys = await self._nio.upload(
                lambda *_: read(),
                "application/octet-stream" if encrypt else media_type,
                encrypt=encrypt,
                filesize=size,
            )
            return answer if isinstance(answer, nio.ErrorResponse) else (answer, keys)

        try:
            answer, keys = await self._ask(act, within_s=FILE_S)
        except MatrixError:
            if broken:
                raise MatrixError(
                    str(broken[0]), MatrixErrorKind.REFUSED, "its content broke"
                ) from None
            raise
        return str(answer.content_uri), keys

    async def download(self, address: str) -> AsyncGenerator[bytes]:
        """Yield what is stored at an address of Matrix's (``mxc://``), piece by piece.

        Raises:
            MatrixError: It cannot be had.
        """
        server, _, media = address.removeprefix("mxc://").partition("/")
        if not address.startswith("mxc://") or not server or not media:
            raise MatrixError("That is no file of Matrix.", MatrixErrorKind.REFUSED, "address")
        path = f"/_matrix/client/v1/media/download/{quote(server, safe='')}/{quote(media, safe='')}"
        response = await self._ask(lambda: self._get(path))
        try:
            if response.status not in OK:
                raise refusal(response.status, None)
            pieces = response.content.iter_chunked(2**16)
            while (piece := await self._ask(lambda: anext(pieces, None))) is not None:
                yield piece
        finally:
            response.close()

    async def _get(self, path: str) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return await self._nio.send("GET", path, headers=self._headers(), timeout=FILE_S)

    def _headers(self) -> dict[str, str]:
        return {
            "Authorization": f"Bearer {self._nio.access_token}",
            "Content-Type": "application/json",
        }

    async def call(
        self, method: str, path: str, body: Mapping[str, Any] | None = None
    ) -> dict[str, Any]:
        """Make one call as this account and return what it answers.

        Raises:
            MatrixError: It was refused, or there was no answer. What was said with a refusal is in
                ``body``.
        """
        text = None if body is None else json.dumps(body)

        async def act() -> tuple[int, object]:
            response = await self._nio.send(method.upper(), path, text, self._headers())
            return response.status, await self._nio.parse_body(response)

        status, said = await self._ask(act)
        if status not in OK:
            raise refusal(status, said)
        return said if isinstance(said, dict) else {}

    # ---- one call ----

    async def persist(
        self, call: Callable[[], Awaitable[Any]], *, within_s: float = GIVE_UP_S
    ) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """Make a call that can be made twice without harm, again where that may help.

        Raises:
            MatrixError: It did not succeed in time.
        """
        give_up_ns = self._clock.monotonic_ns() + int(within_s * 1e9)
        failures = 0
        while True:
            try:
                return await self._ask(call)
            except MatrixError as error:
                wait_s = error.wait_s
                if error.kind is MatrixErrorKind.LOST and failures < len(WAITS_S):
                    wait_s = WAITS_S[failures]
                elif error.kind is MatrixErrorKind.SIGNED_OUT and not failures:
                    await self.sign_in_again(error)
                elif error.kind is not MatrixErrorKind.TOO_FAST:
                    raise
                failures += 1
                if self._clock.monotonic_ns() + int(wait_s * 1e9) > give_up_ns:
                    raise
                await self._clock.sleep(wait_s)

    async def _ask(self, call: Callable[[], Awaitable[T]], *, within_s: float = CALL_S) -> T:
        if self._nio is None or not self._held:
            raise MatrixError(
                f"The messenger {self._name} is not connected.", MatrixErrorKind.LOST, "not open"
            )
        try:
            async with asyncio.timeout(within_s):
                found = await call()
        except Exception as error:  # noqa: BLE001 - whatever the libraries raise means something
            raise trouble(error) from None
        if isinstance(found, nio.ErrorResponse):
            raise _refused(found)
        return found


def _refused(response: Any) -> MatrixError:  # noqa: ANN401 - matrix-nio has no types
    carried = response.transport_response
    status = 0 if carried is None else carried.status
    return refusal(
        status,
        {
            "errcode": response.status_code,
            "error": response.message,
            "retry_after_ms": response.retry_after_ms,
            "soft_logout": response.soft_logout,
        },
    )
