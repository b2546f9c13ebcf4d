"""`rosic record` against a running gateway, and what is left when one of them is killed."""

from __future__ import annotations

import re
import signal
import sqlite3
import stat
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.foxglove.recorder import McapRecorder
from tests.cli.running import CONFIG, ROSIC, environment, gateway, rosic, write_config
from tests.features.recording.studio import read
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.cli.running import Gateway


def recording(folder: Path, file: Path, *more: str) -> subprocess.Popen[str]:
    """Begin `rosic record`, and wait until it records."""
    process = subprocess.Popen(  # noqa: S603 - our own command
        [*ROSIC, "record", "-c", str(folder / "rosic.toml"), *more, str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    assert process.stderr is not None
    assert process.stderr.readline() == "Recording. Ctrl-C ends it.\n"
    return process


def ended(file: Path) -> bool:
    """Whether the end of an order stands in what was written of a file so far."""
    whole = McapRecorder().repair(file.read_bytes())
    steps = read(whole).get("/omni/orders", []) if whole else []
    return any(step["over"] for step in steps)


def parts(folder: Path) -> int:
    """Return how many parts of files are on the record."""
    with closing(sqlite3.connect(folder / "rosic-data" / "rosic.db")) as record:
        [[count]] = record.execute("select count(*) from facts where kind = 'file-part'")
        return int(count)


def wait_until(so: Callable[[], bool]) -> None:
    end_s = time.monotonic() + 60 * pace()
    while not so():
        assert time.monotonic() < end_s
        time.sleep(0.1)


def moved(running: Gateway) -> None:
    running.say("omni move 1 m")
    running.wait_for("done")


def test_a_recording_ends_by_an_interrupt_and_is_whole(tmp_path: Path) -> None:
    file = tmp_path / "omni.mcap"
    with gateway(write_config(tmp_path)) as running:
        process = recording(tmp_path, file, "--robot", "omni")
        moved(running)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60 * pace())
        assert (process.returncode, err) == (0, "")
        assert out.startswith(f"{file}: ")
        assert out.endswith(" KB. Foxglove opens it.\n")
        assert running.end() == 0
    found = read(file.read_bytes())
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    steps = found["/omni/orders"]
    assert {step["words"] for step in steps} == {"move, 1.00 m forward"}
    assert steps[-1]["stage"] == "done"
    way = [one["pose"]["position"]["x"] for one in found["/omni/pose"]]
    assert max(way) - min(way) == pytest.approx(1.0, abs=0.05)
    assert not any(topic.startswith("/kuka1") for topic in found)


def test_it_ends_by_itself_after_its_time(tmp_path: Path) -> None:
    with gateway(write_config(tmp_path)):
        file = tmp_path / "all.mcap"
        done = rosic("record", "-c", tmp_path / "rosic.toml", "--for", "2s", file)
        assert done.status == 0
        assert {"/omni/state", "/kuka1/state"} <= read(file.read_bytes()).keys()


def test_what_the_page_reads_it_with_reads_it(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs/howto/record-and-replay.md").read_text()
    [script] = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    with gateway(write_config(tmp_path)) as running:
        process = recording(tmp_path, tmp_path / "night.mcap")
        moved(running)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60 * pace())
    done = subprocess.run(  # noqa: S603 - our own page
        [sys.executable, "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
        env=environment(),
    )
    assert '"stage":"done"' in done.stdout


def test_a_gateway_that_is_killed_leaves_a_file_that_is_read(tmp_path: Path) -> None:
    file = tmp_path / "cut.mcap"
    with gateway(write_config(tmp_path)) as running:
        process = recording(tmp_path, file)
        moved(running)
        wait_until(lambda: ended(file))
        running.end(signal.SIGKILL)
        _, err = process.communicate(timeout=60 * pace())
    assert process.returncode == 1
    assert err == f"{file} was broken off. What was written before is whole in it now.\n"
    assert read(file.read_bytes())["/omni/orders"][-1]["stage"] == "done"


def test_whoever_is_killed_ends_the_recording_and_leaves_what_was_written(tmp_path: Path) -> None:
    file = tmp_path / "cut.mcap"
    with gateway(write_config(tmp_path)) as running:
        process = recording(tmp_path, file)
        moved(running)
        wait_until(lambda: ended(file))
        process.kill()
        process.communicate(timeout=60 * pace())
        before = file.read_bytes()
        assert not before.endswith(b"\x89MCAP0\r\n")
        again = rosic("record", "-c", tmp_path / "rosic.toml", "--for", "1s", tmp_path / "b.mcap")
        assert again.status == 0
        assert "Traceback" not in running.err()


def test_a_recording_of_a_chat_outlives_the_gateway(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    with gateway(config) as running:
        running.say("/record omni 10 min")
        running.wait_for("Recording omni for 10 min.")
        moved(running)
        before = parts(tmp_path)
        wait_until(lambda: parts(tmp_path) >= before + 2)  # the first may have begun before
        running.end(signal.SIGKILL)
    with gateway(config) as running:
        running.wait_for("A recording of yours was cut off when I was restarted.")
        name = running.out().split("/files get ")[1].split(".mcap")[0] + ".mcap"

        def fetched() -> bool:  # a rate may be used up for the moment: it is asked for again
            running.say(f"/files get {name}")
            time.sleep(1)
            return "It lies in " in running.out()

        wait_until(fetched)
        file = Path(running.out().split("It lies in ")[1].split(": only you")[0])
        found = read(file.read_bytes())
    assert found["/omni/orders"][-1]["stage"] == "done"
    assert found["/omni/pose"][-1]["pose"]["position"]["x"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--robot", "nobody"], "There is no robot called nobody. There are: omni, kuka1."),
        (["--for", "0s"], "--for 0s is no time at all."),
        (["--for", "-1h"], "--for -1h is less than no time."),
        (["--for", "soon"], "I cannot read --for 'soon' as a length of time."),
        (["--for", "2days"], "--for 2days is longer than a day."),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_no_file(
    tmp_path: Path, arguments: list[str], said: str
) -> None:
    file = tmp_path / "none.mcap"
    text = CONFIG.replace('"simulated"', '"memory"')
    with gateway(write_config(tmp_path, text)):
        done = rosic("record", "-c", tmp_path / "rosic.toml", *arguments, file)
    assert done.status != 0
    assert said in done.err
    assert len(done.err.splitlines()) == 1
    assert not file.exists()


def test_without_a_gateway_and_over_a_file_that_is_there(tmp_path: Path) -> None:
    config, file = write_config(tmp_path), tmp_path / "omni.mcap"
    done = rosic("record", "-c", config, file)
    assert done.status == 1
    assert "No gateway is running" in done.err
    assert not file.exists()
    file.write_text("mine")
    done = rosic("record", "-c", config, file)
    assert "is there already. Nothing was recorded." in done.err
    assert file.read_text() == "mine"
    done = rosic("record", "-c", config, tmp_path / "nowhere" / "a.mcap")
    assert "cannot be made" in done.err
