"""What an older ROSIC wrote opens here with everything in it, and is gone on with.

`record-of-a428673.tar.xz` is the data folder of a gateway of commit a428673: `rosic run` with two
simulated robots, and these lines typed at it: an order to omni, `/settings units ft`,
`/book omni 2026-12-24 9:00 1h`, `/task kuka1 home`, `/revoke Bo`, `stop kuka1`. The key, the
database and the stop file are what that program left.
"""

from __future__ import annotations

import json
import tarfile
from pathlib import Path

import pytest

from tests.cli.running import gateway, rosic

RECORD = Path(__file__).with_name("record-of-a428673.tar.xz")
CONFIG = """
[gateway]
name = "lab"
data = "data"

[[messenger]]
kind = "terminal"
plain = true

[[robot]]
profile = "omni"
link = "simulated"

[[robot]]
profile = "kuka1"
link = "simulated"

[[principal]]
name = "Ada"
address = "terminal:0"
role = "admin"

[[principal]]
name = "Bo"
address = "terminal:1001"
role = "operator"
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    with tarfile.open(RECORD) as archive:
        archive.extractall(tmp_path, filter="data")
    written = tmp_path / "rosic.toml"
    written.write_text(CONFIG)
    written.chmod(0o600)
    return written


def told(config: Path, *command: str) -> list[dict[str, object]]:
    ran = rosic(*command, "--json", "-c", config)
    assert ran.status == 0, ran.err
    lines: list[dict[str, object]] = json.loads(ran.out)
    return lines


def everything(config: Path) -> tuple[object, ...]:
    people = {one["name"]: one["state"] for one in told(config, "people")}
    did = [(one["robot"], one["skill"], one["outcome"]) for one in told(config, "history")]
    return people, did


def test_people_ended_accesses_orders_and_stops_are_what_they_were(config: Path) -> None:
    people = {"Ada": "good", "Bo": "ended"}
    did = [("omni", "move", "done"), ("kuka1", "home", "done"), ("kuka1", "stopped", "stopped")]
    assert everything(config) == (people, did)
    with gateway(config):
        robots = {one["robot"]: one["stopped"] for one in told(config, "status")}
        assert robots == {"omni": False, "kuka1": True}
        assert everything(config) == (people, did), "what is written in the file revives nobody"
        assert rosic("resume", "kuka1", "-c", config).status == 0
    assert (config.parent / "data" / "record.mark").exists()
    with gateway(config):
        assert not any(one["stopped"] for one in told(config, "status"))
