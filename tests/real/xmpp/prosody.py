"""A real XMPP server on this machine alone: Prosody, in a folder of its own."""

from __future__ import annotations

import random
import secrets
import shutil
import socket
import subprocess
import time
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from tests.pace import pace
from tests.servers import needed

if TYPE_CHECKING:
    from types import TracebackType

DOMAIN: Final = "rosic.test"
"""What accounts are called after: a name that no network knows."""
ROOMS: Final = f"rooms.{DOMAIN}"
LOOPBACK: Final = "127.0.0.1"
READY_WITHIN_S: Final = 20.0
ENDS_WITHIN_S: Final = 10.0
MODULES: Final = Path(__file__).parent / "modules"
_ASKS_EVERY_S: Final = 0.02
# Below what Linux lends to outgoing connections: none of them takes it while the server is away.
_PORTS: Final = range(20_000, 32_000)
_STARTS: Final = 3
_CONFIG: Final = """
daemonize = false
run_as_root = true
pidfile = "{folder}/prosody.pid"
data_path = "{folder}/data"
plugin_paths = {{ "{modules}" }}
log = {{ warn = "{folder}/prosody.log" }}
interfaces = {{ "127.0.0.1" }}
c2s_ports = {{ {port} }}
c2s_require_encryption = {tls}
allow_unencrypted_plain_auth = true
http_interfaces = {{ "127.0.0.1" }}
http_ports = {{ {http} }}
https_ports = {{ }}
modules_enabled = {{ "roster", "saslauth", "disco", "smacks", "ping", "unconfirmed", {more} }}
modules_disabled = {{ "s2s" }}
authentication = "internal_plain"
network_settings = {{ nagle = false }}
http_host = "127.0.0.1"
http_external_url = "http://127.0.0.1:{http}/"
certificates = "{folder}/certificates"
VirtualHost "{domain}"
Component "{rooms}" "muc"
    muc_room_locking = false
    muc_room_default_public_jids = {public}
Component "upload.{domain}" "http_file_share"
    http_file_share_size_limit = 2000000
"""


class Account(NamedTuple):
    """An account of the server: its address, and what it signs in with."""

    user: str
    password: str


class NotReady(Exception):
    """The server did not start, or did not in time; says its last words."""


class Prosody:
    """One server. It speaks to no other.

    Args:
        folder: Its own, and empty.
        tls: Nobody is let in without encryption; its certificate is in ``certificate``.
        public: In rooms everybody is shown the addresses of everybody.
    """

    def __init__(self, folder: Path, *, tls: bool = False, public: bool = True) -> None:
        self._program = needed("prosody")
        self.folder = folder
        self.port = self.http = 0
        self.certificate = folder / "certificates" / f"{DOMAIN}.crt"
        self._tls, self._public = tls, public
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

    def start(self) -> None:
        """Start it, and return once it answers; a second time on the same port.

        Raises:
            NotReady: It ended, or did not answer in time.
        """
        known = bool(self.port)
        if self._tls and not self.certificate.exists():
            self._certify()
        for _ in range(_STARTS):
            if not known:
                self.port, self.http = _free_port(), _free_port()
            if self._started():
                return
            if known:
                break
        raise NotReady(f"Prosody did not start: {self.said()[-300:]}")

    def stop(self) -> None:
        """End it as its administrator would; harmless where it is not running."""
        self._end(kill=False)

    def kill(self) -> None:
        """End it as a power cut would."""
        self._end(kill=True)

    def said(self) -> str:
        """Return what it says of itself."""
        files = (self.folder / "console.log", self.folder / "prosody.log")
        return "".join(file.read_text(errors="replace") for file in files if file.exists())

    def create_account(self, name: str, password: str = "") -> Account:
        """Make an account that no test before has met."""
        local, password = f"{name}{next(self._numbers)}", password or secrets.token_hex(8)
        accounts = self.folder / "data" / DOMAIN.replace(".", "%2e") / "accounts"
        accounts.mkdir(parents=True, exist_ok=True)
        (accounts / f"{local}.dat").write_text(f'return {{ ["password"] = "{password}" }};\n')
        return Account(f"{local}@{DOMAIN}", password)

    def _started(self) -> bool:
        """Start it once; say whether it answers, and leave nothing behind where it does not."""
        config = self.folder / "prosody.cfg.lua"
        config.write_text(
            _CONFIG.format(
                folder=self.folder,
                modules=MODULES,
                port=self.port,
                http=self.http,
                tls=str(self._tls).lower(),
                more='"tls"' if self._tls else "",
                public=str(self._public).lower(),
                domain=DOMAIN,
                rooms=ROOMS,
            )
        )
        # It ends with whoever started it, however that ended.
        bound = [shutil.which("setpriv"), "--pdeathsig", "KILL"]
        with (self.folder / "console.log").open("ab") as console:
            self._process = subprocess.Popen(  # noqa: S603 - the program that was found
                [*filter(None, bound if bound[0] else []), self._program, "-F", "--config", config],
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=console,
                stderr=console,
                start_new_session=True,
            )
        give_up_s = time.monotonic() + READY_WITHIN_S * pace()
        while self._process.poll() is None and time.monotonic() < give_up_s:
            if self._answers():
                return True
            time.sleep(_ASKS_EVERY_S)
        self.kill()
        return False

    def _answers(self) -> bool:
        """Whether it, and not another that was faster on these ports, answers."""
        mine = (self.folder / "prosody.pid").exists()
        for port in (self.port, self.http):
            with suppress(OSError), socket.create_connection((LOOPBACK, port), 1.0):
                continue
            return False
        return mine

    def _end(self, *, kill: bool) -> None:
        if self._process is None:
            return
        (self._process.kill if kill else self._process.terminate)()
        try:
            self._process.wait(timeout=ENDS_WITHIN_S * pace())
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        (self.folder / "prosody.pid").unlink(missing_ok=True)
        self._process = None

    def _certify(self) -> None:
        self.certificate.parent.mkdir(parents=True, exist_ok=True)
        made = ("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2")
        named = ("-subj", f"/CN={DOMAIN}", "-addext", f"subjectAltName=DNS:{DOMAIN}")
        key = self.certificate.with_suffix(".key")
        put = ("-keyout", str(key), "-out", str(self.certificate))
        subprocess.run(  # noqa: S603 - the program that was found
            [needed("openssl"), *made, *named, *put], check=True, capture_output=True, timeout=60
        )


def _free_port() -> int:
    """Return a port of loopback that nobody has; who starts a server there may yet be too late."""
    while True:
        port = random.choice(_PORTS)  # noqa: S311 - neighbours start apart, and rarely meet
        with socket.socket() as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                one.bind((LOOPBACK, port))
            except OSError:
                continue
        return port
