"""What the handlers of seeing work with, as the composition root made it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from rosic.contracts.clock import Clock
from rosic.core.identity import PrincipalId
from rosic.core.language import VocabularyHolder
from rosic.core.message import Chat
from rosic.core.robot.profile import Profile, RobotId
from rosic.features.media.render_queue import RenderQueue
from rosic.features.media.telemetry_buffer import TelemetrySampler
from rosic.linker.linker import Linker


class MediaQueries(msgspec.Struct, frozen=True, kw_only=True):
    """What other rooms say of who asks.

    Attributes:
        visible: The robots that somebody may see.
        selected: The robot or group that somebody chose in a chat; empty for none.
    """

    visible: Callable[[PrincipalId], frozenset[RobotId]]
    selected: Callable[[PrincipalId, Chat], str]


class MediaContext(msgspec.Struct, frozen=True, kw_only=True):
    """The robots, what is remembered of them, and where pictures are made."""

    vocabularies: VocabularyHolder
    profiles: Mapping[RobotId, Profile]
    sides: MediaQueries
    linker: Linker
    render_queue: RenderQueue
    sampler: TelemetrySampler
    clock: Clock

    def age_s(self, at_ns: int) -> float:
        """Return how long ago something was, on the monotonic clock."""
        return max(0.0, (self.clock.monotonic_ns() - at_ns) / 1e9)
