"""Files that people send, keep, hand to robots and fetch from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.features.files.background import BackgroundTransfer
from rosic.features.files.commands import FileCommands
from rosic.features.files.transfer import FileTransfer, TransferWays
from rosic.features.files.upload import FileUpload
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.contracts.robot import FileFolders
    from rosic.core.identity import PrincipalId
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["FilesFeature", "setup"]

NEEDS: Final = ("file_offers",)


class FilesFeature(Feature):
    """Everybody's files.

    Attributes:
        receiving: Takes in files that people send.
        aside: Brings files beside the chat.
    """

    def __init__(
        self, receiving: FileUpload, aside: BackgroundTransfer, folders: FileFolders
    ) -> None:
        self.receiving, self.aside = receiving, aside
        self._folders = folders

    async def restore(self) -> None:
        """Take away what the last run had not received to the end, and say so."""
        await self.receiving.finish()

    async def leave(self) -> None:
        """Break off what is coming and going."""
        await self.receiving.close()
        await self.aside.close()

    async def end(self, principal: PrincipalId) -> None:
        """Let no file of somebody come or go any more."""
        await self.receiving.end(principal)
        await self.aside.end(principal)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Know the folders of one more robot."""
        if newcomer.profile.files is not None:
            self._folders.add_robot(newcomer.profile.id, newcomer.profile.files)


def setup(kernel: Kernel) -> Feature:
    """Take in files and hand them on, where the record can keep them."""
    containers, pipeline, rooms = kernel.containers, kernel.pipeline, kernel.rooms
    if containers is None:
        return Feature()
    aside = BackgroundTransfer(pipeline.answer, pipeline.plain, kernel.machine_clock)
    ways = TransferWays(kernel.folders, rooms.linker.deliver, rooms.stops)
    handing = FileTransfer(containers, rooms.organiser, rooms.profiles, ways, pipeline.plain, aside)
    FileCommands(containers, aside, handing, pipeline.plain).register(kernel.commands)
    receiving = FileUpload(containers, pipeline.answer, pipeline.plain)
    for offer in (handing.offer, *kernel.shared.file_offers):
        receiving.offer_too(offer)
    pipeline.hooks.enclosed.bind(receiving.take)
    feature = FilesFeature(receiving, aside, kernel.folders)
    kernel.erasure.join(end=feature.end)
    return feature
