"""Places that are kept under a name for a robot: this is the dock; go to the dock."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.places.commands import PlaceCommands
from rosic.features.places.place_book import KIND, PlaceBook
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["PlacesFeature", "setup"]


class PlacesFeature(Feature):
    """Keeps places."""

    def __init__(self, book: PlaceBook) -> None:
        self._book = book

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Let what is kept for a robot that is added again be said."""
        self._book.say(newcomer.profile.id)


def setup(kernel: Kernel) -> PlacesFeature:
    """Let people keep places, and say them."""
    book = PlaceBook(kernel.rooms.vocabularies)
    kernel.keep(KIND, book.restore, book.apply)
    PlaceCommands(kernel.rooms, kernel.changes, kernel.naming, book).register(kernel.commands)
    return PlacesFeature(book)
