"""ROS 2 itself, imported when it is first needed and never before."""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from dataclasses import dataclass
from functools import cache
from threading import Timer
from typing import TYPE_CHECKING, Any, TypeAlias

from rosic.errors import ConfigurationError, how_to_install
from rosic.robots.ros2.errors import RosMissing
from rosic.robots.ros2.interfaces.build import unheard
from rosic.robots.ros2.interfaces.cache import KNOWN, OWN, make_importable

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.robots.ros2.interfaces.build import InterfacePackage, Progress


# ---- importing rclpy ----
# When it is first needed, and never before.

# rclpy and its messages carry no types that hold from one distribution to the next; what crosses
# this border is checked by value, in `messages`.
RosObject: TypeAlias = Any

_HOW_TO_GET_IT = f"Source your ROS 2 distribution, or run {how_to_install('ros2')}."

_MODULES = (
    "rclpy",
    "rclpy.node",
    "rclpy.executors",
    "rclpy.qos",
    "rclpy.signals",
    "rclpy.serialization",
    "rclpy.action",
    "unique_identifier_msgs.msg",
)


@dataclass(frozen=True)
class RclpyModules:
    """The parts of ROS 2 that the adapter uses."""

    rclpy: RosObject
    node: RosObject
    executors: RosObject
    qos: RosObject
    signals: RosObject
    serialization: RosObject
    action: RosObject
    ids: RosObject


@cache
def load_ros() -> RclpyModules:
    """Import ROS 2, with the checks of message fields switched on.

    They are off by default, and then ``Vector3(x=1)`` arrives as 5e-324 without an exception. Our
    own conversion checks every field; this is the second lock on the same door. It is read when a
    message module is first imported, so it has to be set before.

    Raises:
        RosMissing: ROS 2 is not installed, or its libraries are not on the path.
    """
    os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
    try:
        # The parsers that rclpy drags in when a node is made use what Python has deprecated. That
        # is for them to mend; whoever treats warnings as errors must not lose ROS over it.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            modules = [importlib.import_module(name) for name in _MODULES]
            importlib.import_module("rosidl_generator_py")
    except ImportError as error:
        raise RosMissing(
            f"ROS 2 cannot be used by this Python ({sys.version_info.major}."
            f"{sys.version_info.minor}): {str(error).splitlines()[0]}.",
            hint=_HOW_TO_GET_IT,
        ) from error
    return RclpyModules(*modules)


def make_executor(ros: RclpyModules, context: RosObject) -> RosObject:
    """Return the executor that keeps up: the one driven by events, where the distribution has it.

    The older one polls every entity on every turn; it is correct, slower, and drops more of a
    flood.
    """
    try:
        events = importlib.import_module("rclpy.experimental.events_executor")
    except ImportError:
        return ros.executors.SingleThreadedExecutor(context=context)
    return events.EventsExecutor(context=context)


# ---- the interfaces that come with ROSIC ----

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
