"""What people read under a picture, and instead of one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import figure, joined, said
from rosic.core.language.common_names import shown_name
from rosic.core.units import measured

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.view import Pose

MINUTE_S, HOUR_S = 60.0, 3600.0
TENTHS_UNTIL_S = 10.0
NOTHING_M = 0.005
"""A shorter way reads as 0.00 m."""
SHOWN_VALUES = 8

NO_RENDERER = said(
    "Pictures cannot be drawn here: Pillow is missing. The operator installs it with "
    "pip install 'rosic[pictures]', in a checkout .venv/bin/pip install -e '.[pictures]'."
)
NO_FILES = said("This messenger cannot show pictures.")
BROKEN = said("The picture could not be made. The log says why.")
NOT_SENT = said("The picture could not be sent. Ask for it again, perhaps with low.")
GONE = said("You may not look at that robot any more.")


def age(seconds: float) -> str:
    """Return ``0.4 s ago``."""
    if seconds < TENTHS_UNTIL_S:
        return said("{number} s ago", number=figure(f"{max(0.0, seconds):.1f}"))
    if seconds < 2 * MINUTE_S:
        return said("{number} s ago", number=f"{seconds:.0f}")
    if seconds < 2 * HOUR_S:
        return said("{number} min ago", number=f"{seconds / MINUTE_S:.0f}")
    return said("{number} h ago", number=f"{seconds / HOUR_S:.0f}")


def caption(
    robot: str,
    what: str,
    age_s: float,
    *,
    foreign: bool,
    low: bool,
    pose_age_s: float | None = None,
) -> str:
    """Return ``KUKA iiwa, camera, 0.4 s ago``.

    Args:
        robot: As it is shown.
        what: It is.
        age_s: Of what is shown.
        foreign: Its stamp is of another clock.
        low: It is coarse.
        pose_age_s: Of where a map shows the robot, which may be much younger or older than the map.
    """
    parts = [robot, what]
    if foreign:
        parts.append(said("came {ago}; its clock is not ours", ago=age(age_s)))
    else:
        parts.append(age(age_s))
    if pose_age_s is not None:
        parts.append(said("position {ago}", ago=age(pose_age_s)))
    if low:
        parts.append(said("low quality"))
    return joined(", ", parts)


def camera() -> str:
    """Return what a picture is of."""
    return said("camera")


def clip(seconds: float) -> str:
    """Return what a clip is."""
    return said("clip of {seconds} s", seconds=figure(f"{seconds:.1f}"))


def plan() -> str:
    """Return what a map is."""
    return said("map")


def outside(robot: str, pose: Pose) -> str:
    """Return that a robot is beside the map, and where."""
    return said(
        "{robot} is outside this map, at x {x}, y {y}.",
        robot=robot,
        x=measured(f"{pose.x_m:.2f} m", pose.x_m, "m"),
        y=measured(f"{pose.y_m:.2f} m", pose.y_m, "m"),
    )


def stayed(robot: str, words: str, *, over: bool) -> str:
    """Return that there is no way to draw: it stood where it is."""
    if over:
        return said(
            "{robot} did not move from its place with the last order ({order}).",
            robot=robot,
            order=words,
        )
    return said(
        "{robot} has not moved from its place with this order so far ({order}).",
        robot=robot,
        order=words,
    )


def way(words: str, metres: float, seconds: float, *, over: bool) -> str:
    """Return what a way is: of which order, how long, how far."""
    figures = {
        "way": measured(f"{metres:.2f} m", metres, "m"),
        "seconds": figure(f"{seconds:.1f}"),
        "order": words,
    }
    if over:
        return said("way of the last order ({order}): {way} in {seconds} s", **figures)
    return said("way of this order so far ({order}): {way} in {seconds} s", **figures)


def chart(name: str, value: str, seconds: float) -> str:
    """Return what a chart shows."""
    long = f"{seconds / MINUTE_S:.0f} min" if seconds >= 2 * MINUTE_S else f"{seconds:.0f} s"
    return said("{name} over {long}: now {value}", name=name, long=long, value=value)


# ---- why not ----


def no_camera(robot: str) -> str:
    """Nobody has opened its camera to people."""
    return said("{robot} has no camera that people may look through.", robot=robot)


def no_map(robot: str) -> str:
    """It offers no map."""
    return said("{robot} has no map to show.", robot=robot)


def no_pose(robot: str) -> str:
    """It does not say where it is."""
    return said("{robot} does not say where it is, so its way cannot be drawn.", robot=robot)


def no_way(robot: str) -> str:
    """It has carried out nothing yet."""
    return said("{robot} has carried out no order since I was started.", robot=robot)


def no_values(robot: str) -> str:
    """It reports nothing that could be drawn."""
    return said("{robot} reports no numbers to draw.", robot=robot)


def no_samples(robot: str, name: str) -> str:
    """Nothing was heard yet."""
    return said("{robot} has not reported {name} lately.", robot=robot, name=name)


def which_value(robot: str) -> str:
    """Several could be drawn."""
    return said("Which value of {robot}?", robot=robot)


def no_such_value(robot: str, name: str, known: Sequence[str]) -> str:
    """It reports others."""
    return said(
        "{robot} does not report {name}. There is: {known}.",
        robot=robot,
        name=name[:32],
        known=joined(", ", map(shown_name, known[:SHOWN_VALUES])),
    )


def too_much(verb: str) -> str:
    """More was said than the robot and whether it may be coarse."""
    return said("Say {verb}, the robot, and perhaps low for a smaller picture.", verb=verb)


def too_often(wait_s: float) -> str:
    """The bucket is empty."""
    return said(
        "That is more pictures than one person may ask for. Again in {seconds} s.",
        seconds=max(1, round(wait_s)),
    )


def somebody_looks(robot: str) -> str:
    """One picture at a time."""
    return said("A picture of {robot} is being made already. Try again in a moment.", robot=robot)


def too_many_look() -> str:
    """Everybody's pictures share one render queue."""
    return said("Too many pictures are being made just now. Try again in a moment.")
