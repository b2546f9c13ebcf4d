"""What people read about recordings."""

from __future__ import annotations

from typing import Final

from rosic.container.file_messages import amount
from rosic.core.i18n import joined, said
from rosic.organiser.calendar_messages import length

HOW: Final = said(
    "Say which robot, and how long: /record omni 5 min; with camera adds its pictures. "
    "/record omni end ends it. You get a file that Foxglove opens: what was asked of the robot "
    "beside what moved."
)
NO_RECORDER: Final = said(
    "Recordings cannot be made here: mcap is missing. The operator installs it with "
    "pip install 'rosic[foxglove]', in a checkout .venv/bin/pip install -e '.[foxglove]'."
)
TOO_MANY: Final = said("Too much is being recorded just now. Try again in a moment.")
NO_MORE_PARTS: Final = said("Nothing more of this recording can be kept.")
NOT_SENT: Final = said("I could not send it.")


def begun(robot: str, seconds: float, *, pictures: bool) -> str:
    """Return that a recording has begun."""
    figures = {"robot": robot, "length": length(round(seconds))}
    if pictures:
        return said("Recording {robot}, with its camera, for {length}.", **figures)
    return said("Recording {robot} for {length}.", **figures)


def complete(robot: str, size: int) -> str:
    """Return that the time of a recording is over."""
    return said("The recording of {robot} is complete: {size}.", robot=robot, size=amount(size))


def ended_by_you(robot: str, size: int) -> str:
    """Return that somebody ended their recording."""
    return said("You ended the recording of {robot}: {size}.", robot=robot, size=amount(size))


def not_seen_any_more(robot: str, size: int) -> str:
    """Return that a right ended, and a recording with it."""
    return said(
        "You may not see {robot} any more, so its recording ended. This was recorded until then: "
        "{size}.",
        robot=robot,
        size=amount(size),
    )


def full(robot: str, size: int) -> str:
    """Return that a recording has as much room as it gets."""
    return said(
        "The recording of {robot} is as large as it may be, so it ended: {size}.",
        robot=robot,
        size=amount(size),
    )


def kept(ended: str, why: str, name: str) -> str:
    """Return that a recording is not sent, why, and where it lies."""
    where = said("It is kept among your files: /files get {name}.", name=name)
    return joined(" ", (ended, why, where))


def broken(robot: str, name: str) -> str:
    """Return that a recording could not be written to its end.

    Args:
        robot: As it is shown.
        name: Of the file that holds what was written; empty: none does by now.
    """
    if name:
        return said(
            "The recording of {robot} ended, as it could not be written any further. What came "
            "before is kept among your files: /files get {name}.",
            robot=robot,
            name=name,
        )
    return said(
        "The recording of {robot} ended, as it could not be written any further. The operator has "
        "to look. What of it can be read is looked for at my next start, and you are told.",
        robot=robot,
    )


def rescued(name: str) -> str:
    """Return that a recording was cut off by a restart, and is a file all the same."""
    return said(
        "A recording of yours was cut off when I was restarted. What was written before is kept "
        "among your files: /files get {name}.",
        name=name,
    )


def cut_off(name: str) -> str:
    """Return that a recording was cut off, and nothing of it can be read."""
    return said(
        "{name}, a recording of yours, was cut off when I was restarted, and nothing of it can be "
        "read.",
        name=name,
    )


def already(robot: str) -> str:
    """Return that somebody records a robot already."""
    return said(
        "You record {robot} already. /record {robot} end ends that.",
        robot=robot,
    )


def none_of(robot: str) -> str:
    """Return that somebody records a robot not."""
    return said("You do not record {robot} now.", robot=robot)


def no_camera(robot: str) -> str:
    """Return that a robot shows no pictures to people."""
    return said(
        "{robot} has no camera that people may look through. Nothing was begun.", robot=robot
    )


def length_bounds(longest_s: float) -> str:
    """Return how long a recording may be."""
    return said(
        "A recording lasts from 1 s to {longest}. Nothing was begun.",
        longest=length(int(longest_s)),
    )
