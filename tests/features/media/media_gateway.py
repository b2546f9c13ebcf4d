"""A gateway with robots that show something, and a painter that writes down what it drew."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.robot.profile import Telemetry
from rosic.core.robot.view import CompressedFrame, Drawing, OccupancyMap, Pose, ViewKind
from rosic.messengers.memory import MemoryMessenger
from rosic.robots.ros2.profile import Camera, MapSource, PoseSource
from tests.gateway.place import FLEET, Place, profile

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.message import Outbound
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.view import Subject
    from rosic.testing.clock import ManualClock

FRAME = CompressedFrame(b"frame")
GRID = OccupancyMap(1, 1, 0.1, Pose(0, 0), b"\0")


class Sketcher:
    """Draws nothing, and remembers what it was asked to draw.

    Attributes:
        drawn: Subjects, and whether they were to be coarse.
        wrote: A word of each picture, as it was written.
        wait: Unset, it keeps everybody waiting.
        threads: On which it was called.
    """

    def __init__(self) -> None:
        self.drawn: list[tuple[Subject, bool]] = []
        self.wrote: list[str] = []
        self.threads: set[int] = set()
        self.wait = threading.Event()
        self.wait.set()

    def __call__(
        self, subject: Subject, *, low: bool = False, say: Callable[[str], str] = str
    ) -> Drawing:
        self.threads.add(threading.get_ident())
        assert self.wait.wait(60)
        self.drawn.append((subject, low))
        self.wrote.append(say(said("now")))
        return Drawing("image/png", b"png", 1, 1)


def seen(name: str) -> Profile:
    """Return a robot that shows all there is."""
    return replace(
        profile(name),
        title=f"The {name}",
        camera=Camera(topic="/c"),
        map=MapSource(topic="/m"),
        pose=PoseSource(topic="/p"),
        telemetry={"battery": Telemetry(unit="%", alert_below=20.0), "x": Telemetry(unit="m")},
    )


ROBOTS = (seen("omni"), seen("cf1"), *(one for one in FLEET if one.id == "kuka1"))


def without_files(clock: ManualClock) -> MemoryMessenger:
    return MemoryMessenger("memory", clock=clock, file_bytes=0)


class Booth(Place):
    """Everything in one.

    Attributes:
        renderer: Who draws.
    """

    renderer: Sketcher

    def prepare(self) -> None:
        """Let the robots show something; to be called once it is open."""
        for name in ("omni", "cf1"):
            robot = self.robot(name)
            robot.shows = {ViewKind.PICTURE: FRAME, ViewKind.MAP: GRID}
            robot.pose = Pose(1.0, 2.0)
            robot.values = {"battery": 80.0, "x": 0.5, "mode": "idle"}

    async def see(self, text: str, **how: object) -> Outbound:
        """Say something, and return the next message, however long that is drawn."""
        before = len(self.chat.told)
        await self.say(text, **how)
        return await self.shown(before)

    async def shown(self, before: int) -> Outbound:
        """Return the newest message once there are more than so many."""
        for _ in range(20_000):
            if len(self.chat.told) > before:
                return self.chat.told[-1].outbound
            await self.clock.advance(0.01)
            await asyncio.sleep(0.001)
        raise AssertionError("nothing was shown")


def booth(renderer: Sketcher | None, **how: object) -> Booth:
    """Return a booth; without a painter Pillow is missing."""
    made = Booth(fleet=ROBOTS, **how)  # type: ignore[arg-type]
    parts = made.gateway._parts
    made.gateway._parts = replace(parts, renderer=renderer)
    if renderer is not None:
        made.renderer = renderer
    return made
