"""I13: a record that was lost, emptied, swapped or put back moves nothing and revives nobody."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

import pytest

from rosic.cli.main import main
from rosic.stores.data_dir import LOCK
from rosic.stores.record_mark import DATABASE, MARK, STOPS
from tests.cli.running import CONFIG, gateway, rosic, write_config

if TYPE_CHECKING:
    from pathlib import Path

MEMORY = CONFIG.replace('"simulated"', '"memory"')


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Return the configuration of a place where Bob was let in and revoked."""
    path = write_config(tmp_path, MEMORY)
    with gateway(path):
        assert rosic("revoke", "Bob", "-c", path).status == 0
    return path


def _emptied(path: Path) -> None:
    os.truncate(path, 0)


def test_what_is_emptied_in_place_ends_motion_and_the_stop_file_is_mended(tmp_path: Path) -> None:
    config, data = write_config(tmp_path, MEMORY), tmp_path / "rosic-data"
    with gateway(config) as running:
        _emptied(data / STOPS)
        running.wait_for(f"{STOPS} of my record is gone or was replaced, emptied or overwritten")
        running.wait_for("are all there again")
        running.say("omni move 10 cm")
        running.wait_for("0.10 m")
        _emptied(data / DATABASE)
        running.say("omni move 20 cm")
        running.wait_for("nothing may move")
        running.wait_for(f"{DATABASE} of my record is gone or was replaced, emptied or overwritten")
        assert "rosic.db-wal and record.mark as they were last" in running.err()
        running.say("stop")
        running.wait_for("at rest")
        assert running.end() == 0
        assert "Traceback" not in running.err()
    assert rosic("run", "-c", config).status == 1


def _without_database(data: Path) -> None:
    for path in data.glob(f"{DATABASE}*"):
        path.unlink()


def test_a_lost_record_does_not_start_and_revives_nobody(config: Path) -> None:
    data = config.parent / "rosic-data"
    _without_database(data)
    ran = rosic("run", "-c", config)
    assert ran.status == 1
    assert ran.err.startswith("rosic: The record in ")
    assert "rosic run --begin-anew" in ran.err
    assert "revoked" in ran.err
    assert not (data / DATABASE).exists()
    assert "look at this: The record in" in rosic("doctor", "-c", config).out
    assert "rosic run --begin-anew" in rosic("people", "-c", config).err
    with gateway(config, begin_anew=True) as running:
        assert running.end() == 0
    with gateway(config) as running:  # and from then on it is the record
        assert running.end() == 0


def test_an_older_record_does_not_start_and_revives_nobody(tmp_path: Path) -> None:
    config, data = write_config(tmp_path, MEMORY), tmp_path / "rosic-data"
    with gateway(config) as running:
        assert running.end() == 0
    older = tmp_path / "older.db"
    shutil.copy(data / DATABASE, older)
    with gateway(config) as running:
        assert rosic("revoke", "Bob", "-c", config).status == 0
        assert running.end() == 0
    shutil.copy(older, data / DATABASE)
    ran = rosic("run", "-c", config)
    assert ran.status == 1
    assert f"it is older than {MARK}" in ran.err


def test_the_option_says_what_it_does(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "--begin-anew" in said
    assert "whoever was revoked or locked since may come in again" in said


def test_a_second_gateway_does_not_start_though_the_lock_file_is_removed(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)
    with gateway(config):
        (tmp_path / "rosic-data" / LOCK).unlink()
        ran = rosic("run", "-c", config)
        assert ran.status == 1
        assert "Another gateway is already running on this data" in ran.err


@pytest.mark.parametrize(
    ("name", "how"),
    [
        (DATABASE, "removed"),
        (STOPS, "replaced"),
    ],
)
def test_what_vanishes_under_a_gateway_ends_motion_and_not_stops(
    tmp_path: Path, name: str, how: str
) -> None:
    config = write_config(tmp_path, MEMORY)
    path, aside = tmp_path / "rosic-data" / name, tmp_path / "aside"
    with gateway(config) as running:
        running.say("omni move 10 cm")
        running.wait_for("done")
        if how == "replaced":
            shutil.copy(path, aside)
            path.rename(tmp_path / "original")
            aside.rename(path)
        else:
            path.rename(tmp_path / "original")
        running.say("omni move 20 cm")
        running.wait_for("nothing may move")
        running.wait_for("is gone or was replaced")  # the admin is told
        assert f"{name} of the record is gone or was replaced" in running.err()
        status = rosic("status", "-c", config)
        assert f"{name} of my record is gone or was replaced" in status.out
        assert f"look at this: {name} of my record is gone" in rosic("doctor", "-c", config).out
        running.say("stop")
        running.wait_for("at rest")
        assert "stopped" in rosic("status", "omni", "-c", config).out

        (tmp_path / "original").rename(path)  # healed without a restart
        running.wait_for("are all there again")
        running.say("resume omni")
        running.wait_for("is ready again")
        running.say("omni move 30 cm")
        running.wait_for("0.30 m")
        assert "Traceback" not in running.err()
