"""One account at one homeserver: signed in, and each call with a bound on what is answered."""

from __future__ import annotations

import asyncio
import json
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final, TypeVar

import msgspec
import nio

from rosic.errors import ConfigurationError
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind, refusal, trouble
from rosic.messengers.matrix.olm_machine import AccountClient
from rosic.messengers.matrix.replay_guard import ReplayGuard
from rosic.messengers.matrix.sealed_folder import SealedFolder
from rosic.messengers.matrix.sync_answer import MOST_BYTES

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.messengers.matrix.olm_machine import OlmMachine
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
REACTION: Final = "m.reaction"
MOST_SAID: Final = 2**20
"""Bytes of an answer that is read as one piece."""
DEVICES_AT_MOST: Final = 50
"""Of one person, that are given the key of what anybody may read."""

log = logging.getLogger("rosic.messengers.matrix")


class SignedIn(msgspec.Struct, frozen=True):
    """A device of the account, and the token it speaks with."""

    user: str
    device: str
    token: str


class MatrixConnection:
    """Connections are open only while it is held.

    Args:
        name: Of the messenger, for the log and for sentences.
        knows: Whether somebody is known here, by their account.

    Attributes:
        folder: What is kept of the account.
        guard: Judges what was decrypted.
        is_known: Whether somebody is known here.
    """

    def __init__(
        self, name: str, settings: MatrixSettings, clock: Clock, knows: Callable[[str], bool]
    ) -> None:
        self.folder = SealedFolder(settings.folder)
        self.guard = ReplayGuard(settings.folder)
        self._name = name
        self._settings = settings
        self._clock = clock
        self.is_known = knows
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
    def machine(self) -> OlmMachine:
        """What decrypts for this device; there is one while it is held."""
        machine: OlmMachine = self._nio.olm
        return machine

    @property
    def library(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        """The client of matrix-nio, with its sessions and what it keeps; None until open."""
        return self._nio

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
                await self.guard.open()
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
            self.guard,
            self.is_known,
            self._settings.homeserver,
            self._settings.user,
            store_path=str(self._settings.folder),
            config=config,
        )

    def _opened(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return self._nio

    def _account(self) -> Any:  # noqa: ANN401 - matrix-nio has no types
        return self.machine.account

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
        found = await self.ask(lambda: library.login(password.reveal(), settings.device_name))
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

    def headers(self) -> dict[str, str]:
        """Return what every request carries."""
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
        said = _json(await self._exchange(method.upper(), path, text, most=MOST_SAID))
        return said if isinstance(said, dict) else {}

    async def get(self, path: str, *, most: int = MOST_BYTES, within_s: float = CALL_S) -> bytes:
        """Return an answer as it came, to be read in pieces.

        Raises:
            MatrixError: It was refused, or there was no answer.
        """
        return await self._exchange("GET", path, None, most=most, within_s=within_s)

    async def _exchange(
        self, method: str, path: str, text: str | None, *, most: int, within_s: float = CALL_S
    ) -> bytes:
        async def act() -> tuple[int, bytes]:
            response = await self._nio.send(method, path, text, self.headers(), None, within_s)
            try:
                return response.status, await self.read_body(response, most)
            finally:
                response.close()

        status, said = await self.ask(act, within_s=within_s)
        if status not in OK:
            raise refusal(status, _json(said[:MOST_SAID]))
        return said

    async def read_body(self, response: Any, most: int) -> bytes:  # noqa: ANN401 - aiohttp's
        """Return the body of an answer.

        Raises:
            MatrixError: It has more bytes than that. The rest of it is not read.
        """
        body = bytearray()
        async for piece in response.content.iter_any():
            body += piece
            if len(body) > most:
                raise MatrixError(
                    "The homeserver says more than can be read at once.",
                    MatrixErrorKind.TOO_LARGE,
                    f"more than {most} bytes",
                )
        return bytes(body)

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
                return await self.ask(call)
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

    async def ask(self, call: Callable[[], Awaitable[T]], *, within_s: float = CALL_S) -> T:
        """Make one call of matrix-nio's, once.

        Raises:
            MatrixError: No answer in time, or a refusal.
        """
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


def _json(body: bytes) -> object:
    """Return what an answer says; None where it is no JSON."""
    try:
        return msgspec.json.decode(body)
    except (ValueError, RecursionError):
        return None
