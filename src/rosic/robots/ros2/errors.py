"""What can go wrong between this process and a ROS 2 graph, sorted by what is true afterwards.

The adapter above knows the robot's name and says it; these sentences name what stands in the
profile: a topic, a service, a type, a field.
"""

from __future__ import annotations

from rosic.errors import ConfigurationError, Fault


class RosMissing(ConfigurationError):
    """ROS 2 cannot be imported here. Nothing has been started."""

    code = "ros-missing"


class BadName(ConfigurationError):
    """A name in a profile is no ROS name, or the type, field or entry it names is not there.

    Nothing has been started.
    """

    code = "ros-name"


class BadValue(Fault):
    """A value does not fit the field it is meant for, or a field does not hold what was looked for.

    Nothing was sent.
    """

    code = "ros-value"


class NotSent(Fault):
    """Nothing was sent: nobody listens, too much is under way, or the link is closed."""

    code = "ros-not-sent"


class NoAnswer(Fault):
    """It was sent, and no answer came in time. It may or may not have been carried out."""

    code = "ros-no-answer"
