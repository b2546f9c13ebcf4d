"""Synapse in a process of its own, with a database of its own."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import random
import secrets
import socket
import subprocess
import time
from itertools import count
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self
from urllib.request import ProxyHandler, Request, build_opener

from rosic.testing.ros2.graph import environment_for_another_python

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path
    from types import TracebackType

DOMAIN: Final = "rosic.test"
"""What users and rooms are called after: a name that no network knows."""
READY_WITHIN_S: Final = 60.0
ENDS_WITHIN_S: Final = 20.0
ANSWERS_WITHIN_S: Final = 30.0
_ASKS_EVERY_S: Final = 0.05
# Below what Linux lends to outgoing connections: none of them takes it while the server is away.
_PORTS: Final = range(20_000, 32_000)
_STARTS: Final = 3
_OWN: Final = "test.rosic.server"
_PORT_TAKEN: Final = "Address already in use"
# It ends with whoever started it, however that ended: then its standard input is at its end.
_RUN: Final = """
import os, signal, threading
def follow():
    os.read(0, 1)
    os.kill(os.getpid(), signal.SIGKILL)
threading.Thread(target=follow, daemon=True).start()
from synapse.app.homeserver import main
main()
"""

_NO_LIMIT: Final = {"per_second": 1e6, "burst_count": 1_000_000}
_NO_LIMITS: Final[dict[str, Any]] = {
    **dict.fromkeys(
        (
            "rc_3pid_validation",
            "rc_admin_redaction",
            "rc_delayed_event_mgmt",
            "rc_joins_per_room",
            "rc_key_requests",
            "rc_media_create",
            "rc_message",
            "rc_profile",
            "rc_registration",
            "rc_registration_token_validity",
            "rc_reports",
            "rc_room_creation",
            "rc_third_party_invite",
            "rc_user_directory",
        ),
        _NO_LIMIT,
    ),
    "rc_invites": {"per_room": _NO_LIMIT, "per_user": _NO_LIMIT, "per_issuer": _NO_LIMIT},
    "rc_joins": {"local": _NO_LIMIT, "remote": _NO_LIMIT},
    "rc_login": {"address": _NO_LIMIT, "account": _NO_LIMIT, "failed_attempts": _NO_LIMIT},
    "rc_presence": {"per_user": _NO_LIMIT},
}


class Account(NamedTuple):
    """A user of the homeserver.

    Attributes:
        user: As in ``@ada:rosic.test``.
        password: To log in with.
        url: Of the homeserver.
    """

    user: str
    password: str
    url: str


class HomeserverFault(Exception):
    """The homeserver did not start, or did not in time; says its last words."""


class Synapse:
    """One homeserver. It federates with nobody, limits nobody, and knows nothing of presence.

    Attributes:
        url: Where it listens; the same after a restart.
        folder: Its database, its media and its log.
    """

    def __init__(
        self, folder: Path, python: Path, *, patience: float = 1.0, **settings: object
    ) -> None:
        """Prepare one; nothing is started.

        Args:
            folder: Its own, and empty.
            python: Of an environment that Synapse is installed in.
            patience: So many times as long as on a fast machine it may take.
            settings: Of Synapse's configuration, over those of this class.
        """
        self.folder = folder
        self.url = ""
        self._python = python.absolute()  # it runs in a folder of its own
        self._patience = patience
        self._settings = settings
        self._registering = secrets.token_hex(16)
        self._seed = base64.b64encode(secrets.token_bytes(32)).decode().rstrip("=")
        self._own = secrets.token_hex(8)
        self._numbers = count(1)
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    # ---- the process ----

    @property
    def log(self) -> Path:
        """What it says of itself."""
        return self.folder / "homeserver.log"

    @property
    def database(self) -> Path:
        """The file of its database, of SQLite."""
        return self.folder / "homeserver.db"

    @property
    def media(self) -> Path:
        """Where it keeps files."""
        return self.folder / "media"

    def start(self) -> None:
        """Start it, and return once it answers.

        Raises:
            HomeserverFault: It ended, or did not answer in time.
        """
        known = bool(self.url)
        for _ in range(_STARTS):
            if not known:
                self.url = f"http://127.0.0.1:{_free_port()}"
            if self._started():
                return
            if known or _PORT_TAKEN not in self._said():
                break
        last = (self._said().strip().splitlines() or ["it said nothing"])[-1].strip()
        raise HomeserverFault(f"Synapse did not start: {last}")

    def stop(self) -> None:
        """End it as its administrator would; harmless where it is not running."""
        self._end(kill=False)

    def kill(self) -> None:
        """End it as a power cut would."""
        self._end(kill=True)

    def restart(self) -> None:
        """Stop it and start it again, with everything that it knew."""
        self.stop()
        self.start()

    def _started(self) -> bool:
        """Start it once; say whether it answers, and leave nothing behind where it does not."""
        config = self.folder / "homeserver.yaml"
        config.write_text(json.dumps(self._config(), indent=1))  # which is YAML, too
        try:
            self._process = self._spawned(config)
        except OSError as trouble:
            why = f"{trouble.strerror}: {trouble.filename}"
            raise HomeserverFault(f"Synapse did not start: {why}") from trouble
        give_up_s = time.monotonic() + READY_WITHIN_S * self._patience
        while self._process.poll() is None and time.monotonic() < give_up_s:
            if self._answers():
                return True
            time.sleep(_ASKS_EVERY_S)
        self.kill()
        return False

    def _spawned(self, config: Path) -> subprocess.Popen[bytes]:
        with (self.folder / "console.log").open("wb") as console:
            return subprocess.Popen(  # noqa: S603 - the Python of its own environment
                [self._python, "-c", _RUN, "--config-path", config],
                cwd=self.folder,
                env=environment_for_another_python(),
                stdin=subprocess.PIPE,
                stdout=console,
                stderr=console,
                start_new_session=True,  # an interrupt of the tests is for them; they end it
            )

    def _answers(self) -> bool:
        """Whether it, and not another that was faster on this port, answers."""
        try:
            told = _asked(Request(f"{self.url}/.well-known/matrix/client"), 1.0)  # noqa: S310
        except (OSError, ValueError):
            return False
        return isinstance(told, dict) and told.get(_OWN) == self._own

    def _end(self, *, kill: bool) -> None:
        if self._process is None:
            return
        if kill:
            self._process.kill()
        else:
            self._process.terminate()
        try:
            self._process.wait(timeout=ENDS_WITHIN_S * self._patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process = None

    def _said(self) -> str:
        return (self.folder / "console.log").read_text(errors="replace")

    def _config(self) -> dict[str, Any]:
        place = self.url.removeprefix("http://").rpartition(":")
        listener = {
            "type": "http",
            "bind_addresses": [place[0]],
            "port": int(place[2]),
            "resources": [{"names": ["client"]}],
        }
        return {
            "server_name": DOMAIN,
            "public_baseurl": self.url,
            "listeners": [listener],
            "extra_well_known_client_content": {_OWN: self._own},
            "pid_file": str(self.folder / "homeserver.pid"),
            "database": {"name": "sqlite3", "args": {"database": str(self.database)}},
            "media_store_path": str(self.media),
            "log_config": str(self._log_config()),
            "signing_key": f"ed25519 a_test {self._seed}",
            "registration_shared_secret": self._registering,
            "macaroon_secret_key": self._registering,
            "form_secret": self._registering,
            "bcrypt_rounds": 4,
            "federation_domain_whitelist": [],
            "trusted_key_servers": [],
            "suppress_key_server_warning": True,
            "presence": {"enabled": False},
            "user_directory": {"enabled": False},
            "push": {"enabled": False},
            "report_stats": False,
            "url_preview_enabled": False,
            "max_upload_size": "100M",
            **_NO_LIMITS,
            **self._settings,
        }

    def _log_config(self) -> Path:
        handler = {"class": "logging.FileHandler", "filename": str(self.log), "formatter": "line"}
        config = {
            "version": 1,
            "disable_existing_loggers": False,
            "formatters": {"line": {"format": "%(asctime)s %(levelname)s %(name)s %(message)s"}},
            "handlers": {"file": handler},
            "root": {"level": "WARNING", "handlers": ["file"]},
        }
        path = self.folder / "log.yaml"
        path.write_text(json.dumps(config))
        return path

    # ---- its users ----

    def create_account(self, name: str, *, admin: bool = False) -> Account:
        """Make a user whom no test before has met; none of their devices is there yet.

        Args:
            name: What the user is called after; a number follows.
            admin: An administrator of the homeserver.
        """
        local, password = f"{name.lower()}{next(self._numbers)}", secrets.token_hex(8)
        nonce = self._administer("GET", {})["nonce"]
        signed = "\0".join((nonce, local, password, "admin" if admin else "notadmin"))
        mac = hmac.new(self._registering.encode(), signed.encode(), hashlib.sha1)
        registered = self._administer(
            "POST",
            {
                "nonce": nonce,
                "username": local,
                "displayname": name,
                "password": password,
                "admin": admin,
                "mac": mac.hexdigest(),
                "inhibit_login": True,
            },
        )
        return Account(registered["user_id"], password, self.url)

    def _administer(self, method: str, body: Mapping[str, object]) -> dict[str, Any]:
        address = f"{self.url}/_synapse/admin/v1/register"
        said = json.dumps(body).encode() if body else None
        found: dict[str, Any] = _asked(
            Request(address, said, method=method),  # noqa: S310 - of our own server
            ANSWERS_WITHIN_S * self._patience,
        )
        return found


def _asked(request: Request, within_s: float) -> Any:  # noqa: ANN401 - as JSON says
    """Return what the server answers.

    Raises:
        OSError: It does not, or with an error.
        ValueError: That was no JSON.
    """
    with build_opener(ProxyHandler({})).open(request, timeout=within_s) as answer:
        return json.loads(answer.read())


def _free_port() -> int:
    """Return a port of loopback that nobody has; who starts a server there may yet be too late."""
    while True:
        port = random.choice(_PORTS)  # noqa: S311 - neighbours start apart, and rarely meet
        with socket.socket() as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                one.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
