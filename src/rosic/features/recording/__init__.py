"""What was asked of robots beside what moved, recorded as a file that Foxglove opens."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.recording.commands import RecordingCommands
from rosic.features.recording.service import RecordingService
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.gateway.feature import Kernel

__all__ = ["RecordingFeature", "setup"]


class RecordingFeature(Feature):
    """Everybody's recordings.

    Attributes:
        service: Makes them.
    """

    def __init__(self, service: RecordingService, own: RecordingCommands | None) -> None:
        self.service = service
        self._own = own

    async def restore(self) -> None:
        """Make whole what the last run had not recorded to the end, and say so."""
        if self._own is not None:
            await self._own.keeper.restore()

    async def close(self) -> None:
        """End every recording; people's are made whole at the next start."""
        await self.service.close()

    async def end(self, principal: PrincipalId) -> None:
        """Record nothing more for somebody."""
        await self.service.end(principal)


def setup(kernel: Kernel) -> RecordingFeature:
    """Let robots be recorded: for whoever may see them, where the record can keep files."""
    service = RecordingService(kernel)
    kernel.shared.alarm_news.connect(service.notice)
    own: RecordingCommands | None = None
    if kernel.containers is not None:
        own = RecordingCommands(kernel, kernel.containers, service)
        own.register(kernel.commands)
    feature = RecordingFeature(service, own)
    kernel.erasure.join(end=feature.end)
    return feature
