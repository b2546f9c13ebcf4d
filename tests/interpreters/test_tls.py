"""Over TLS: a good answer, and none from whoever cannot show that it is the one that was named."""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING

import pytest

from rosic.contracts.interpreter import AnswerKind
from tests.interpreters.hostile import GOOD
from tests.interpreters.scripted import ScriptedEndpoint, client_of, saying
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

# Made for these tests alone, for 127.0.0.1, from 2000 to 2100; nothing else trusts it.
CERTIFICATE = """\
-----BEGIN CERTIFICATE-----
MIIBZDCCAQqgAwIBAgIBATAKBggqhkjOPQQDAjAYMRYwFAYDVQQDDA1vZiB0ZXN0
cyBvbmx5MCAXDTAwMDEwMTAwMDAwMFoYDzIxMDAwMTAxMDAwMDAwWjAYMRYwFAYD
VQQDDA1vZiB0ZXN0cyBvbmx5MFkwEwYHKoZIzj0CAQYIKoZIzj0DAQcDQgAEpqVn
TxsYDSEm+ffju8Ja6o5jNg4YaZ3Y4JIaPyaoqUw44APO3P0zqmLJhhUCcyZMm2Nq
+m+U1hth/SXKu6QQpaNDMEEwDwYDVR0RBAgwBocEfwAAATAPBgNVHRMBAf8EBTAD
AQH/MB0GA1UdDgQWBBRcWrPnmDRun6pz4LkC0VjC5tw1zzAKBggqhkjOPQQDAgNI
ADBFAiAFYAWv/sGtC6hRWRWbI0q/Z1hCoUUMZqP37AMEUJgaqwIhAO4mB+l6w1Wx
CWaPyvXlojpIdTioBWEBUo+9u92i5Xfv
-----END CERTIFICATE-----
"""
KEY = """\
-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQglI5mVU684hJsggBF
MP/Ko87lOPjdMDW/3eTE3/KyvWGhRANCAASmpWdPGxgNISb59+O7wlrqjmM2Dhhp
ndjgkho/JqipTDjgA87c/TOqYsmGFQJzJkybY2r6b5TWG2H9Jcq7pBCl
-----END PRIVATE KEY-----
"""


@pytest.fixture
def endpoint(tmp_path: Path) -> Iterator[ScriptedEndpoint]:
    (tmp_path / "pair.pem").write_text(CERTIFICATE + KEY)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(tmp_path / "pair.pem")
    with ScriptedEndpoint(saying(GOOD), tls=context) as running:
        yield running


@pytest.fixture
def trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have this machine trust the certificate."""
    (tmp_path / "trusted.pem").write_text(CERTIFICATE)
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "trusted.pem"))


@pytest.mark.usefixtures("trusted")
async def test_a_good_answer_is_read(endpoint: ScriptedEndpoint) -> None:
    answer = await client_of(endpoint.address, key="sk-1", timeout_s=30 * pace()).ask("r", "t")
    assert (answer.kind, answer.text) == (AnswerKind.ANSWERED, GOOD)
    assert "Bearer sk-1" in endpoint.calls[0].head


async def test_whom_nobody_vouches_for_is_told_nothing(endpoint: ScriptedEndpoint) -> None:
    answer = await client_of(endpoint.address, key="sk-1", timeout_s=30 * pace()).ask("r", "t")
    assert answer.kind is AnswerKind.UNREACHABLE
    assert endpoint.calls == []


@pytest.mark.usefixtures("trusted")
async def test_whoever_has_another_name_is_told_nothing(endpoint: ScriptedEndpoint) -> None:
    address = endpoint.address.replace("127.0.0.1", "localhost")
    answer = await client_of(address, key="sk-1", timeout_s=30 * pace()).ask("r", "t")
    assert answer.kind is AnswerKind.UNREACHABLE
    assert endpoint.calls == []
