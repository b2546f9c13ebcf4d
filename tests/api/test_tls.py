"""Over TLS by certificate files; and never in the clear to other machines, unless told twice."""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING

import httpx
import pytest

from rosic.api.settings import ApiSettings
from rosic.app.config import read_config
from rosic.app.setup.check import check_all
from rosic.system import SystemClock
from tests.api.served import ANYWHERE, served
from tests.cli.running import CONFIG, write_config
from tests.interpreters.test_tls import CERTIFICATE, KEY

if TYPE_CHECKING:
    from pathlib import Path

IN_CLEAR = "is reached from other machines, and nothing there is encrypted."
TAKEN = "The API listens on 127.0.0.1:8765 already."
NO_ORIGIN = "'*' is no origin of a page."
TOGETHER = "A certificate and its private key belong together."
NO_ADDRESS = "is no address and port of this machine"
NOTHING = "No address is named, so nothing listens."
SENTENCES = (TAKEN, NO_ORIGIN, IN_CLEAR, TOGETHER, NO_ADDRESS, NOTHING)


async def test_it_speaks_tls_with_the_files_that_are_named(tmp_path: Path) -> None:
    (tmp_path / "cert.pem").write_text(CERTIFICATE)
    (tmp_path / "key.pem").write_text(KEY)
    settings = ApiSettings(
        listen=ANYWHERE,
        certificate=str(tmp_path / "cert.pem"),
        private_key=str(tmp_path / "key.pem"),
    )
    async with served(settings) as place:
        url = f"https://127.0.0.1:{place.server.port}"
        known = ssl.create_default_context(cadata=CERTIFICATE)
        async with httpx.AsyncClient(base_url=url, verify=known) as client:
            code = {"code": place.code("Ada")}
            signed_in = await client.post("/v1/sessions", json=code, headers={"Origin": url})
            assert signed_in.status_code == 201
            cookie = signed_in.headers["set-cookie"]
            assert cookie.startswith("__Host-rosic-session=")
            assert {"Secure", "HttpOnly", "SameSite=strict", "Path=/"} <= set(cookie.split("; "))
            answer = await client.get("/v1/me")
            assert answer.json()["name"] == "Ada"
            assert answer.headers["strict-transport-security"] == "max-age=31536000"
        with pytest.raises(httpx.ConnectError):
            async with httpx.AsyncClient(base_url=url) as stranger:
                await stranger.get("/v1/me")
        with pytest.raises(httpx.HTTPError):
            async with httpx.AsyncClient(base_url=url.replace("https", "http")) as plain:
                await plain.get("/v1/me")


@pytest.mark.parametrize(
    ("table", "refused"),
    [
        ('listen = "127.0.0.1:8765"', ""),
        ('listen = "[::1]:8765"', ""),
        ('listen = "0.0.0.0:8765"', IN_CLEAR),
        ('listen = "192.0.2.1:8765"', IN_CLEAR),
        ('listen = "[::]:8765"', IN_CLEAR),
        ('listen = "0.0.0.0:8765"\nwithout_tls = "yes"', IN_CLEAR),
        ('listen = "0.0.0.0:8765"\nurl = "https://robots.example.org"', IN_CLEAR),
        ('listen = "0.0.0.0:8765"\nproxies = ["192.0.2.7"]', IN_CLEAR),
        ('listen = "0.0.0.0:8765"\nwithout_tls = "public address, no TLS"', ""),
        ('listen = "0.0.0.0:8765"\ncertificate = "c.pem"\nprivate_key = "k.pem"', ""),
        (
            'listen = "0.0.0.0:8765"\nproxies = ["192.0.2.7"]\nurl = "https://robots.example.org"',
            "",
        ),
        ('listen = "127.0.0.1:8765"\ncertificate = "c.pem"', TOGETHER),
        ('listen = "robots.example.org:8765"', NO_ADDRESS),
        ('listen = "127.0.0.1:8765"\nrosbridge = "127.0.0.1:9090"', ""),
        ('listen = "127.0.0.1:8765"\nrosbridge = "0.0.0.0:9090"', IN_CLEAR),
        ('listen = "127.0.0.1:8765"\nrosbridge = "localhost"', NO_ADDRESS),
        ('listen = "127.0.0.1:8765"\nrosbridge = "127.0.0.1:8765"', TAKEN),
        ('rosbridge = "127.0.0.1:9090"', NOTHING),
        ('listen = "127.0.0.1:8765"\norigins = ["https://panel.example.org"]', ""),
        ('listen = "127.0.0.1:8765"\norigins = ["*"]', NO_ORIGIN),
        ('url = "https://robots.example.org"', NOTHING),
    ],
)
def test_a_public_address_without_tls_is_refused(tmp_path: Path, table: str, refused: str) -> None:
    path = tmp_path / "rosic.toml"
    path.write_text(f"[api]\n{table}\n")
    path.chmod(0o600)
    errors = " ".join(str(error) for error in read_config(path, environ={}).errors)
    found = [sentence for sentence in SENTENCES if sentence in errors]
    assert found == ([refused] if refused else [])


TOPIC = """
[[api.topic]]
name = "/omni/cmd_vel"
type = "geometry_msgs/msg/Twist"
robot = "omni"
"""


@pytest.mark.parametrize(
    ("certificate", "key", "topic", "refused"),
    [
        (CERTIFICATE, KEY, "", ""),
        ("", KEY, "", "cert.pem cannot be read (No such file or directory)."),
        (CERTIFICATE, "", "", "key.pem cannot be read (No such file or directory)."),
        (CERTIFICATE, CERTIFICATE, "", "are no certificate and its private key."),
        (CERTIFICATE, KEY, TOPIC, "A skill publishes to this topic."),
    ],
)
def test_what_would_end_a_start_is_found_by_check(
    tmp_path: Path, certificate: str, key: str, topic: str, refused: str
) -> None:
    for name, text in (("cert.pem", certificate), ("key.pem", key)):
        if text:
            (tmp_path / name).write_text(text)
    files = 'certificate = "cert.pem"\nprivate_key = "key.pem"\n'
    path = write_config(tmp_path, f'{CONFIG}\n[api]\nlisten = "127.0.0.1:0"\n{files}{topic}')
    errors = [str(error) for error in check_all(path, SystemClock()).errors]
    about = [error for error in errors if "api." in error]
    assert len(about) == bool(refused)
    assert all(refused in error for error in about)
