"""What `rosic.testing.ros2` promises to whoever writes tests with it."""

from __future__ import annotations

import os
import re
import sys
import time
from pathlib import Path

import pytest

from rosic.testing.ros2.graph import YOUNG_S, Domain, RosGraph, RosProcess, sweep, why_missing
from tests.pace import pace

PEER = Path(__file__).with_name("peer.py")


def test_no_two_tests_share_a_domain() -> None:
    domains = [Domain() for _ in range(10)]
    try:
        assert len({domain.id for domain in domains}) == 10
        assert all(1 <= domain.id <= 101 for domain in domains)
    finally:
        for domain in domains:
            domain.release()
    again = Domain()
    assert again.id == domains[0].id
    again.release()


def test_this_process_is_on_the_graph_while_it_is_open(tmp_path: Path) -> None:
    before = dict(os.environ)
    with RosGraph(tmp_path) as graph:
        assert os.environ["ROS_DOMAIN_ID"] == str(graph.domain_id)
        assert os.environ["ROS_LOCALHOST_ONLY"] == "1"
        assert os.environ["ROS_LOG_DIR"] == str(tmp_path)
        assert "ROS_STATIC_PEERS" not in os.environ
    assert dict(os.environ) == before


def test_a_node_ends_when_its_test_does(tmp_path: Path) -> None:
    with RosGraph(tmp_path) as graph:
        peer = graph.start(PEER)
        assert peer.process.poll() is None
    assert peer.process.poll() == 0


def test_a_program_that_does_not_come_up_shows_its_last_words(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("raise SystemExit('no robot here')\n")
    with (
        RosGraph(tmp_path) as graph,
        pytest.raises(AssertionError, match=r"ended with 1; it said:\nno robot here"),
    ):
        graph.start(tmp_path / "broken.py")


def test_a_program_that_says_nothing_is_waited_for_no_longer_than_asked(tmp_path: Path) -> None:
    (tmp_path / "mute.py").write_text("import sys; sys.stdin.read()\n")
    with RosGraph(tmp_path) as graph:
        mute = graph.start(tmp_path / "mute.py", ready=None)
        with pytest.raises(AssertionError, match=r"0\.1 s went by; it said:\n\(nothing\)"):
            mute.expect("word", timeout_s=0.1)
    assert mute.process.poll() == 0


def test_a_program_that_does_not_listen_is_ended_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "deaf.py").write_text(
        "import signal, time\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "print('ready', flush=True)\ntime.sleep(60)\n"
    )
    deaf = RosProcess([sys.executable, str(tmp_path / "deaf.py")], dict(os.environ), patience_s=0.2)
    deaf.expect("ready")
    assert deaf.stop() == -9


def test_what_a_killed_node_leaves_is_swept(tmp_path: Path) -> None:
    with RosGraph(tmp_path) as graph:
        killed = graph.start(PEER)
        left = _segments(killed)
        killed.kill()
        assert left
        end = time.monotonic() + 60 * pace()
        while any(file.exists() for file in left) and time.monotonic() < end:
            sweep(graph.domain_id)
            time.sleep(0.1)
        assert not any(file.exists() for file in left)


def test_what_a_living_node_uses_is_not_swept(tmp_path: Path) -> None:
    with RosGraph(tmp_path) as graph:
        living = graph.start(PEER)
        used = _segments(living)
        assert used
        while time.time() - max(file.stat().st_ctime for file in used) < YOUNG_S + 0.5:
            time.sleep(0.1)
        sweep(graph.domain_id)
        assert all(file.exists() for file in used)
        living.say("burst 1")
        living.expect("ok burst")


def _segments(node: RosProcess) -> list[Path]:
    """The files in shared memory that are this node's own."""
    opened = {file.resolve() for file in Path(f"/proc/{node.process.pid}/fd").iterdir()}
    return [file for file in opened if re.fullmatch(r"fastdds_[0-9a-f]{16}_el", file.name)]


def test_ros_is_looked_for_without_importing_it() -> None:
    assert why_missing() is None
