"""The homeserver that tests start is one, is restarted with what it knew, and ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from tests.pace import pace
from tests.real.matrix.synapse import DOMAIN, HomeserverFault, synapse_in

if TYPE_CHECKING:
    from tests.real.matrix.synapse import Account, Synapse


ROOT = Path(__file__).parents[3]
STARTS_ONE = """
import sys, time
from pathlib import Path
from tests.real.matrix.synapse import synapse_in
with synapse_in(Path(sys.argv[1])) as running:
    print(running.url, flush=True)
    time.sleep(600)
"""


def log_in(account: Account) -> httpx.Response:
    asked = {
        "type": "m.login.password",
        "identifier": {"type": "m.id.user", "user": account.user},
        "password": account.password,
    }
    return httpx.post(f"{account.url}/_matrix/client/v3/login", json=asked, trust_env=False)


def test_it_knows_its_users_after_a_restart_and_after_a_power_cut(synapse: Synapse) -> None:
    ada = synapse.create_account("Ada")
    bo = synapse.create_account("Bo", admin=True)
    url = synapse.url
    assert ada.user.endswith(f":{DOMAIN}")
    assert ada.user != synapse.create_account("Ada").user

    for end in (synapse.stop, synapse.kill):
        end()
        with pytest.raises(httpx.ConnectError):
            log_in(ada)
        synapse.start()

    assert synapse.url == url
    assert log_in(ada).json()["user_id"] == ada.user
    assert log_in(bo).json()["user_id"] == bo.user


def test_it_limits_nobody(synapse: Synapse) -> None:
    ada = synapse.create_account("Ada")
    wrong = ada._replace(password=ada.password[1:])

    assert {log_in(wrong).status_code for _ in range(20)} == {httpx.codes.FORBIDDEN}
    assert {log_in(ada).status_code for _ in range(20)} == {httpx.codes.OK}


def test_one_that_cannot_start_says_why(tmp_path: Path) -> None:
    with pytest.raises(HomeserverFault, match=r"Synapse did not start: .*invalid format"):
        synapse_in(tmp_path, server_name="not a name").start()


def test_one_whose_port_another_takes_meanwhile_finds_another(
    synapse: Synapse, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = int(synapse.url.rpartition(":")[2])
    ports = iter((taken, taken + 1 if taken < 31_999 else taken - 1))
    monkeypatch.setattr("rosic.testing.matrix.synapse._free_port", lambda: next(ports))

    with synapse_in(tmp_path) as other:
        assert other.url != synapse.url
        assert log_in(other.create_account("Ada")).status_code == httpx.codes.OK


def test_it_ends_with_the_test_that_was_killed(tmp_path: Path, synapse: Synapse) -> None:  # noqa: ARG001 - or it is skipped
    with subprocess.Popen(  # noqa: S603 - our own test
        [sys.executable, "-c", STARTS_ONE, str(tmp_path)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        assert httpx.get(f"{url}/health", trust_env=False).text == "OK"
        os.kill(process.pid, signal.SIGKILL)

    give_up_s = time.monotonic() + 30 * pace()
    while _answers(url):
        assert time.monotonic() < give_up_s, "the homeserver outlived the test"
        time.sleep(0.05)


def _answers(url: str) -> bool:
    try:
        return httpx.get(f"{url}/health", trust_env=False).text == "OK"
    except httpx.TransportError:
        return False
