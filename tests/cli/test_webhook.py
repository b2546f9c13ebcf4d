"""`rosic webhook test`: one signed event, and what became of it."""

from __future__ import annotations

import base64
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING

import pytest

from rosic.api.webhooks.settings import key_of, signed
from rosic.cli.main import main
from rosic.core.secret import Secret
from tests.cli.running import CONFIG, write_config

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TEXT = f"whsec_{base64.b64encode(bytes(32)).decode()}"


class Receiver(ThreadingHTTPServer):
    status = 204

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.got: list[tuple[dict[str, str], bytes]] = []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/hook"

    def proves(self, secret: str) -> bool:
        """Return whether all that came was signed with it."""
        for headers, body in self.got:
            names = ("webhook-id", "webhook-timestamp", "webhook-signature")
            message, at_s, signature = (headers[name] for name in names)
            key = key_of(Secret(secret))
            if signed(key, message, int(at_s), body)["webhook-signature"] != signature:
                return False
        return bool(self.got)


class Handler(BaseHTTPRequestHandler):
    server: Receiver

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"]))
        self.server.got.append(({k.lower(): v for k, v in self.headers.items()}, body))
        self.send_response(self.server.status)
        self.end_headers()

    def log_message(self, *_args: object) -> None:
        """Say nothing."""


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    with Receiver() as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def test_one_event_is_posted_with_a_secret_that_is_shown(
    receiver: Receiver,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["webhook", "test", receiver.url]) == 0
    said = capsys.readouterr().out
    assert "Taken (204)" in said
    assert "private network: a [[webhook]] is posted there only if it says private = true." in said
    assert receiver.proves(next(word for word in said.split() if word.startswith("whsec_")))
    assert b'"type":"test"' in receiver.got[0][1]


def test_what_is_configured_is_signed_with_its_secret_which_is_not_shown(
    receiver: Receiver, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = f'\n[[webhook]]\nurl = "{receiver.url}"\nsecret = "{TEXT}"\nprivate = true\n'
    path = write_config(tmp_path, CONFIG + table)
    assert main(["webhook", "test", receiver.url, "-c", str(path)]) == 0
    assert receiver.proves(TEXT)
    assert TEXT not in capsys.readouterr().out


def test_a_private_address_that_is_not_said_to_be_one_is_not_asked(
    receiver: Receiver, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    named = receiver.url.replace("127.0.0.1", "localhost")
    for url, status, why in (
        (named, 1, "private = true is not said"),
        (receiver.url, 2, "This address is in a private network, so nothing is posted there."),
    ):
        table = f'\n[[webhook]]\nurl = "{url}"\nsecret = "{TEXT}"\n'
        path = write_config(tmp_path, CONFIG + table)
        assert main(["webhook", "test", url, "-c", str(path)]) == status
        assert why in capsys.readouterr().err
    assert not receiver.got


def test_what_is_not_taken_is_said(
    receiver: Receiver,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    receiver.status = 500
    assert main(["webhook", "test", receiver.url]) == 1
    assert "It was not taken: it answers 500." in capsys.readouterr().err


def test_what_is_no_address_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["webhook", "test", "ftp://example.org"]) == 2
    assert "no address to which something can be posted" in capsys.readouterr().err
