"""The servers that `rosic bench api` compares: a whole gateway, rosbridge_server, a bare echo."""

from __future__ import annotations

import os
import re
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.bench.gateway_process import (
    LOCAL,
    STARTED_WITHIN_S,
    busy_s,
    free_port,
    is_listening,
    key_headers,
)
from rosic.bench.topic_process import FROM_ROS, TO_ROS, TYPE
from rosic.errors import ConfigurationError
from rosic.robots.ros2.interfaces.build import InterfacePackage
from rosic.robots.ros2.interfaces.cache import ensure_built

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.testing.ros2.graph import RosGraph, RosProcess

CONFIG: Final = """\
[gateway]
name = "bench"
data = "data"

[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "ros2"

[role.bench]
scopes = ["omni:share", "omni:read"]

[api]
listen = "{listen}"

[[api.topic]]
name = "{to_ros}"
type = "{type}"
robot = "omni"
publish = "share"

[[api.topic]]
name = "{from_ros}"
type = "{type}"
robot = "omni"
"""


class BridgeServer(NamedTuple):
    """A server that hands topics on to WebSockets.

    Attributes:
        headers: That its clients show.
        process: In which it runs.
    """

    name: str
    url: str
    headers: dict[str, str]
    process: RosProcess

    def busy_s(self) -> float:
        """Return how much of a processor it has used so far."""
        return busy_s(self.process.process.pid)

    def memory_mb(self) -> float:
        """Return how much memory it holds."""
        status = Path(f"/proc/{self.process.process.pid}/status").read_text(encoding="utf-8")
        found = re.search(r"VmRSS:\s+(\d+) kB", status)
        return int(found[1]) / 1024 if found else 0.0


@contextmanager
def gateway(graph: RosGraph, folder: Path) -> Iterator[BridgeServer]:
    """Run a whole gateway: a key, scopes, the record on disk."""
    port = free_port()
    listen = f"{LOCAL}:{port}"
    config = folder / "rosic.toml"
    text = CONFIG.format(listen=listen, to_ros=TO_ROS, from_ros=FROM_ROS, type=TYPE)
    config.write_text(text, encoding="utf-8")
    process = graph.start("-m", "rosic", "run", "-c", config, ready=None, ends_with_input=False)
    _await_port(process, port)
    headers = key_headers(config)
    try:
        yield BridgeServer("ROSIC", f"ws://{listen}/rosbridge", headers, process)
    finally:
        process.stop()


def script_of(checkout: Path) -> Path:
    """Return the program in a checkout of rosbridge_suite.

    Raises:
        ConfigurationError: It is none.
    """
    script = checkout / "rosbridge_server" / "scripts" / "rosbridge_websocket.py"
    if not script.is_file():
        raise ConfigurationError(
            f"There is no rosbridge_suite in {checkout}.",
            hint="Name a checkout of its branch ros2.",
        )
    return script


@contextmanager
def rosbridge_server(graph: RosGraph, checkout: Path) -> Iterator[BridgeServer]:
    """Run rosbridge_server from a checkout of rosbridge_suite.

    Raises:
        ConfigurationError: There is none, or what it needs is not installed.
    """
    script = script_of(checkout)
    messages = InterfacePackage("rosbridge_msgs", checkout / "rosbridge_msgs")
    built = ensure_built(messages, Path(os.environ["ROS_LOG_DIR"]) / "interfaces")
    sources = [checkout / name / "src" for name in ("rosbridge_library", "rosbridge_server")]
    port = free_port()
    process = graph.start(
        *(script, "--port", str(port), "--address", LOCAL),
        python_path=[*sources, built],
        ready=None,
        ends_with_input=False,
    )
    _await_port(process, port)
    try:
        yield BridgeServer("rosbridge_server", f"ws://{LOCAL}:{port}", {}, process)
    finally:
        process.stop()


@contextmanager
def echo(graph: RosGraph) -> Iterator[BridgeServer]:
    """Run what sends back whatever it is sent."""
    process = graph.start("-m", "rosic.bench.socket_process", "echo", ready=None)
    port = process.expect("ready", timeout_s=STARTED_WITHIN_S)
    try:
        yield BridgeServer("bare echo", f"ws://{LOCAL}:{port}", {}, process)
    finally:
        process.stop()


def _await_port(process: RosProcess, port: int) -> None:
    """Wait until something listens there.

    Raises:
        ConfigurationError: It ended; says its last words.
    """
    if is_listening(port, lambda: process.process.poll() is None):
        return
    raise ConfigurationError(
        f"A server of the bench did not start: {' '.join(list(process.lines)[-3:])[-400:]}",
        hint="rosbridge_server needs tornado, pymongo and pillow: pip install them.",
    )
