"""What can be seen of a robot, before anybody has drawn it: frames, maps, scenes, curves, ways."""

from __future__ import annotations

import enum
from math import cos, isfinite, sin
from typing import TypeAlias

import msgspec

Point: TypeAlias = tuple[float, float, float]
Colour: TypeAlias = tuple[int, int, int]


class ViewKind(enum.Enum):
    """What a robot's side can be asked to show."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    PICTURE = "picture"
    MAP = "map"


class Pose(msgspec.Struct, frozen=True, gc=False):
    """Where something is.

    Attributes:
        yaw_rad: About z; None where only the place is known.
        frame: In which it is counted; empty when the robot does not say.
    """

    x_m: float
    y_m: float
    z_m: float = 0.0
    yaw_rad: float | None = None
    frame: str = ""


# ---- what a robot's side shows ----


class CompressedFrame(msgspec.Struct, frozen=True, gc=False, tag="encoded"):
    """A frame as a camera driver compressed it: JPEG or PNG, unless it says what is not so."""

    data: bytes

    def __repr__(self) -> str:
        return f"Encoded({len(self.data)} bytes)"


class RawFrame(msgspec.Struct, frozen=True, gc=False, tag="raster"):
    """A frame of bare pixels.

    Attributes:
        encoding: ``rgb8``, ``bgr8``, ``mono8``, ``16UC1`` (depth in mm; 0 is unknown) ...
        step_bytes: From one row to the next.
    """

    width: int
    height: int
    encoding: str
    step_bytes: int
    data: bytes
    big_endian: bool = False

    def __repr__(self) -> str:
        return f"Raster({self.width} x {self.height} {self.encoding}, {len(self.data)} bytes)"


class OccupancyMap(msgspec.Struct, frozen=True, gc=False, tag="grid"):
    """A map of what is occupied, and where the robot is and goes on it.

    Attributes:
        origin: Of the lower left corner of the first cell, in the map's frame.
        cells: Row by row from the origin, x first: 0 to 100 %, 255 (-1) unknown.
        pose: Of the robot, in the map's frame; None when it is not known there.
        pose_ns: When the pose was heard, on the gateway's monotonic clock; None without a pose.
        path: Where it means to go, in the map's frame.
        note: Why something is missing; empty when nothing is.
    """

    width: int
    height: int
    resolution_m: float
    origin: Pose
    cells: bytes
    pose: Pose | None = None
    path: tuple[tuple[float, float], ...] = ()
    note: str = ""
    pose_ns: int | None = None

    @property
    def outside(self) -> Pose | None:
        """The robot's pose where that is beside the map, so that nobody sees it there."""
        pose, origin = self.pose, self.origin
        if pose is None or not (isfinite(pose.x_m) and isfinite(pose.y_m)):
            return None
        x, y = pose.x_m - origin.x_m, pose.y_m - origin.y_m
        c, s = cos(origin.yaw_rad or 0.0), sin(origin.yaw_rad or 0.0)
        across, up = c * x + s * y, c * y - s * x
        within_x = 0 <= across <= self.width * self.resolution_m
        within_y = 0 <= up <= self.height * self.resolution_m
        return None if within_x and within_y else pose

    def __repr__(self) -> str:
        return f"Grid({self.width} x {self.height} of {self.resolution_m} m)"


class Tube(msgspec.Struct, frozen=True, gc=False, tag="tube"):
    """A cylinder or a cone with its ends closed; a flat one is a disc."""

    start: Point
    end: Point
    radius_m: float
    colour: Colour
    end_radius_m: float | None = None


class Ball(msgspec.Struct, frozen=True, gc=False, tag="ball"):
    """A sphere."""

    centre: Point
    radius_m: float
    colour: Colour


class Box(msgspec.Struct, frozen=True, gc=False, tag="box"):
    """A cuboid that stands upright, turned about its own z axis.

    Attributes:
        top: Another colour for the upper face.
    """

    centre: Point
    size_m: Point
    colour: Colour
    yaw_rad: float = 0.0
    top: Colour | None = None


Solid: TypeAlias = Tube | Ball | Box


class Label(msgspec.Struct, frozen=True, gc=False):
    """A few words that float at a place."""

    text: str
    at: Point


class Scene(msgspec.Struct, frozen=True, gc=False, tag="scene"):
    """A room that has to be drawn, for robots that exist in a computer only.

    Attributes:
        backdrop: Walls and tables: behind or under everything else, and shadows fall on them.
        eye, target: From where one looks, and at what; m, z up.
        angle_rad: How wide one sees.
        floor: Corners of the floor: x and y, least and greatest.
    """

    solids: tuple[Solid, ...]
    eye: Point
    target: Point
    angle_rad: float = 0.7
    floor: tuple[float, float, float, float] = (-3.0, -3.0, 3.0, 3.0)
    labels: tuple[Label, ...] = ()
    backdrop: tuple[Solid, ...] = ()


Content: TypeAlias = CompressedFrame | RawFrame | OccupancyMap | Scene


class View(msgspec.Struct, frozen=True, gc=False):
    """What a robot's side has shown.

    Attributes:
        taken_ns: When, on the gateway's monotonic clock.
        foreign: Its stamp is of another clock, so that ``taken_ns`` is when it came here.
    """

    content: Content
    taken_ns: int
    foreign: bool = False


# ---- what the gateway has kept ----


class TimeSeries(msgspec.Struct, frozen=True, gc=False, tag="curve"):
    """One value over time.

    Attributes:
        points: Seconds before now (negative) and the value; in order. NaN is a gap.
        alert_below: Where a line is drawn that should not be crossed.
    """

    title: str
    unit: str
    points: tuple[tuple[float, float], ...]
    alert_below: float | None = None


class PathView(msgspec.Struct, frozen=True, gc=False, tag="way"):
    """Where a robot went.

    Attributes:
        points: In order; at least one.
        vertical: Height matters: it is drawn as well.
    """

    title: str
    points: tuple[Pose, ...]
    vertical: bool = False


class PathsView(msgspec.Struct, frozen=True, gc=False, tag="ways"):
    """Where several robots went, in one frame.

    Attributes:
        ways: At least one; the title of each is the name of its robot.
    """

    title: str
    ways: tuple[PathView, ...]


class Clip(msgspec.Struct, frozen=True, gc=False, tag="clip"):
    """Frames one after another.

    Attributes:
        frames: At least one.
        every_s: From one to the next.
    """

    frames: tuple[Content, ...]
    every_s: float


Subject: TypeAlias = Content | TimeSeries | PathView | PathsView | Clip


class Drawing(msgspec.Struct, frozen=True, gc=False):
    """A finished picture.

    Attributes:
        media_type: ``image/jpeg``, ``image/png`` or ``image/gif``.
    """

    media_type: str
    content: bytes
    width: int
    height: int

    def __repr__(self) -> str:
        size = f"{self.width} x {self.height}"
        return f"Drawing({self.media_type}, {size}, {len(self.content)} bytes)"
