"""The interfaces that come with ROSIC, made importable when something first needs them."""

from __future__ import annotations

import sys
from threading import Timer

from rosic.errors import ConfigurationError
from rosic.robots.ros2.interfaces.cache import OWN, make_importable

SAY_AFTER_S = 1.0
BUILDING = "Building the ROS 2 interfaces that come with ROSIC; this is done once.\n"


def find_own_interfaces() -> None:
    """Make rosic_interfaces importable: from the sourced workspace, from the cache, or built now.

    Building takes some seconds, which is said on standard error. It blocks; several processes may
    ask at once, and one of them builds.

    Raises:
        ConfigurationError: It is not here and cannot be built.
    """
    say = Timer(SAY_AFTER_S, sys.stderr.write, [BUILDING])
    say.daemon = True
    say.start()
    try:
        make_importable()
    except ConfigurationError as error:
        raise ConfigurationError(
            f"The ROS interfaces that come with ROSIC are not built: {error}",
            hint=f"With colcon: build {OWN.name} ({OWN.source}) in your workspace and source it.",
        ) from error
    finally:
        say.cancel()
