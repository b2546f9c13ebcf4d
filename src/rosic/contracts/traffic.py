"""What a messenger or a robot's link may be able to say besides: how much passes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from rosic.core.traffic import TrafficCount


@runtime_checkable
class CountsTraffic(Protocol):
    """A link that counts what comes in and goes out where it really does."""

    @property
    def traffic(self) -> TrafficCount:
        """Return what has passed since it was made; it only grows, and asking costs nothing."""
        ...


def traffic_of(link: object) -> TrafficCount | None:
    """Return what has passed a link; None: it does not count."""
    return link.traffic if isinstance(link, CountsTraffic) else None


@runtime_checkable
class HasConnection(Protocol):
    """It can tell whether its platform answers; see `is_connected`."""

    def is_connected(self) -> bool:
        """Return whether it did when it was asked last."""


def is_connected(messenger: object) -> bool | None:
    """Whether a messenger's platform answers; None: it cannot tell, or has none."""
    return messenger.is_connected() if isinstance(messenger, HasConnection) else None
