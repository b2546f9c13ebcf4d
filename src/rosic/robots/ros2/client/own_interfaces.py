"""The interfaces that come with ROSIC, made importable when something first needs them."""

from __future__ import annotations

import sys
from threading import Timer
from typing import TYPE_CHECKING

from rosic.errors import ConfigurationError
from rosic.robots.ros2.interfaces.build import unheard
from rosic.robots.ros2.interfaces.cache import KNOWN, OWN, make_importable

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.robots.ros2.interfaces.build import InterfacePackage, Progress

SAY_AFTER_S = 1.0
BUILDING = "Building the ROS 2 interfaces that come with ROSIC; this is done once.\n"


def find_interfaces(types: Iterable[str], progress: Progress = unheard) -> None:
    """Make the packages of these types importable, as far as they come with ROSIC.

    Args:
        types: Such as ``nav2_msgs/action/NavigateToPose``.
        progress: Told how far building is; not called for what is there.

    Raises:
        ConfigurationError: One is not here and cannot be built.
    """
    wanted = {name.partition("/")[0] for name in types}
    for name in sorted(wanted & KNOWN.keys()):
        _find(KNOWN[name], progress)


def find_own_interfaces() -> None:
    """Make rosic_interfaces importable. Raises as `find_interfaces` does."""
    _find(OWN)


def _find(package: InterfacePackage, progress: Progress = unheard) -> None:
    """Make a package importable: from the sourced workspace, from the cache, or built now.

    Building takes some seconds, which is said on standard error. It blocks; several processes may
    ask at once, and one of them builds.
    """
    say = Timer(SAY_AFTER_S, sys.stderr.write, [BUILDING])
    say.daemon = True
    say.start()
    try:
        make_importable(package, progress=progress)
    except ConfigurationError as error:
        raise ConfigurationError(
            f"The ROS interfaces {package.name} that come with ROSIC are not built: {error}",
            hint=f"With colcon: build {package.name} in your workspace and source it.",
        ) from error
    finally:
        say.cancel()
