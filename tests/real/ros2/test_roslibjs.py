"""The JavaScript client of rosbridge and a panel built on it, unmodified, with a ROS 2 robot."""

from __future__ import annotations

import asyncio
import math
import threading
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.api.settings import ApiSettings, OpenedTopicSettings
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.testing.ros2.graph import RosGraph
from tests.api.served import ANYWHERE, ServedGateway, served
from tests.console.browser import chromium
from tests.pace import pace
from tests.real.ros2.simulated import shipped, simulated, until
from tests.servers import needed, node_modules

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from playwright.async_api import Page

CLIENT = Path(__file__).with_name("roslibjs_client.mjs")
RULES = RoleRules(roles=DEFAULT_ROLES | {"sharer": Role(scopes=("omni:*", "omni:share"))})
STRING = "std_msgs/msg/String"
CHATTER = OpenedTopicSettings(name="/chatter", type=STRING, robot="omni", publish="share")
PANEL = """<!DOCTYPE html>
<html><head><meta charset="UTF-8"><title>Keyboard</title>
<script src="/eventemitter2/lib/eventemitter2.js"></script>
<script src="/roslib-1/build/roslib.js"></script></head>
<body><script src="/keyboardteleopjs/build/keyboardteleop.js"></script><script src="/panel.js"></script></body></html>
"""  # noqa: E501
# As in the example that the package brings, with another address and another topic.
SCRIPT = """
const ros = new ROSLIB.Ros({ url: new URLSearchParams(location.search).get("ros") });
ros.on("connection", () => { document.title = "connected"; });
ros.on("close", () => { document.title = "closed"; });
const teleop = new KEYBOARDTELEOP.Teleop({ ros: ros, topic: "/omni/cmd_vel" });
teleop.scale = 0.9;
"""


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[RosGraph]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("roslibjs")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni"):
        yield graph


class _PanelFiles(SimpleHTTPRequestHandler):
    """The packages as they are, and a page beside them; whatever it says of itself is dropped."""

    def do_GET(self) -> None:
        own = {"/": ("text/html", PANEL), "/panel.js": ("text/javascript", SCRIPT)}
        found = own.get(self.path.partition("?")[0])
        if found is None:
            super().do_GET()
            return
        self.send_response(200)
        self.send_header("Content-Type", found[0])
        self.end_headers()
        self.wfile.write(found[1].encode())

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def panel_server() -> Iterator[str]:
    """Serve the panel on another port than the gateway; yield its origin."""
    handler = partial(_PanelFiles, directory=str(node_modules()))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def origin() -> Iterator[str]:
    with panel_server() as origin:
        yield origin


@pytest.fixture
async def place(graph: RosGraph, origin: str) -> AsyncIterator[ServedGateway]:  # noqa: ARG001 - joined by its variables
    settings = ApiSettings(
        listen=ANYWHERE, rosbridge=ANYWHERE, origins=(origin,), topics=(CHATTER,)
    )
    async with served(settings, rules=RULES, profiles=(shipped("omni"),)) as place:
        await until(lambda: place.gateway.rooms.linker.presence("omni").online is True)
        yield place


async def test_roslibjs_reads_publishes_drives_sends_goals_and_stops(place: ServedGateway) -> None:
    roslib = str(node_modules() / "roslib")
    url = f"ws://127.0.0.1:{place.server.rosbridge_port}"
    process = await asyncio.create_subprocess_exec(
        *(needed("node"), str(CLIENT), roslib, url, await place.key("sharer")),
        stdout=asyncio.subprocess.PIPE,
    )
    assert process.stdout is not None
    async with asyncio.timeout(150 * pace()):
        told = (await process.stdout.read()).decode().splitlines()
        await process.wait()
    assert told == [
        "topics true true false",
        "type nav_msgs/msg/Odometry",
        "chatter none true",
        "chatter png true",
        "chatter cbor true",
        "drive true true",
        "goal true true true",
        "refused error",
        "stop true",
        "over",
    ]
    assert place.gateway.rooms.stops["omni"].latched
    skills = [order.skill for order in place.server.context.feed.newest()]
    assert skills == ["move", "drive"]


async def hold(page: Page, key: str, seconds: float) -> None:
    """Hold a key, which repeats as a keyboard's does."""
    end_s = asyncio.get_running_loop().time() + seconds
    while asyncio.get_running_loop().time() < end_s:
        await page.keyboard.down(key)
        await asyncio.sleep(0.05)
    await page.keyboard.up(key)


def yaw_rad(place: ServedGateway) -> float:
    """Return how the robot stands, as its side says."""
    pose = place.gateway.rooms.linker.presence("omni").pose
    assert pose is not None
    assert pose.yaw_rad is not None
    return pose.yaw_rad


async def test_a_public_panel_drives_and_turns_from_a_page_elsewhere_and_is_let_in_by_name_alone(
    place: ServedGateway, origin: str
) -> None:
    sharer = await place.program("sharer")
    bridge = f"ws://127.0.0.1:{place.server.rosbridge_port}/"

    async def panel(page: Page, at: str) -> None:
        ticket = (await sharer.post("/v1/tickets")).json()["ticket"]
        await page.goto(f"{at}/?ros={bridge}?ticket={ticket}")

    feed = place.server.context.feed
    async with chromium() as browser:
        page = await browser.new_page()
        await panel(page, origin)
        await page.wait_for_function("document.title == 'connected'")
        await hold(page, "w", 1.0)
        await until(lambda: any(order.is_over for order in feed.newest()))
        [order] = feed.newest()
        assert (order.robot, order.skill, order.ending) == ("omni", "drive", "done")

        # This panel sets linear.z, too, when it turns; a base has nothing that could follow it.
        before_rad = yaw_rad(place)
        await hold(page, "a", 1.5)
        await until(lambda: all(order.is_over for order in feed.newest()))
        turned, _ = feed.newest()
        assert (turned.skill, turned.ending) == ("drive", "done")
        await until(lambda: math.remainder(yaw_rad(place) - before_rad, math.tau) > 0.3)

        with panel_server() as other:  # the same page, from where nobody has named
            await panel(page, other)
            await page.wait_for_function("document.title == 'closed'")
    assert len(tuple(feed.newest())) == 2
