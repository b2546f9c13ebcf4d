"""What is kept, container by container, as the operator of the machine looks at it and ends it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.naming import the_one
from rosic.core.i18n import plain
from rosic.core.identity import OPERATOR
from rosic.errors import NotUnderstood
from rosic.features.personal_data import operator_view

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.app.admin.api import AdminContext, AdminRequest
    from rosic.gateway.container_context import ContainerContext

LISTED_AT_ONCE = 500
NONE_HERE = "There are no containers to look into here."
NEEDS_A_GATEWAY = (
    "Only a running gateway erases: it ends rights and brings robots to rest first. Start it with "
    "rosic run, then ask again."
)

# A container of nobody who is known is named by a sentence, which is more than `str`.
_encode = msgspec.json.Encoder(enc_hook=plain).encode


class LimitParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one container may keep; None leaves it as it is."""

    names: int | None = None
    most_bytes: int | None = None


class ContainersAdmin:
    """Answers in JSON; the command makes a table or a file of it."""

    def __init__(self, books: AdminContext) -> None:
        self._books = books

    async def list(self, _ask: AdminRequest) -> Iterable[str]:
        """Return every container, some at a time."""
        found = await operator_view.list_containers(self._data_context)
        ats = range(0, len(found), LISTED_AT_ONCE)
        return (_encode(found[at : at + LISTED_AT_ONCE]).decode() for at in ats)

    async def show(self, ask: AdminRequest) -> Iterable[str]:
        """Return how much of what one holds.

        Raises:
            NotUnderstood: There is none, or several people are called so.
            StoreFault: It cannot be read now.
        """
        shown = await operator_view.show_container(self._data_context, await self._meant(ask))
        return (_encode(shown).decode(),)

    async def content(self, ask: AdminRequest) -> Iterable[str]:
        """Return which container was meant, then what is in it as JSON lines, many at a time.

        Raises:
            NotUnderstood, StoreFault: As `show`.
        """
        container = await self._meant(ask)
        lines = await operator_view.export_container(self._data_context, container)
        return (each for some in ((container,), lines) for each in some)

    async def limit(self, ask: AdminRequest, asked: LimitParameters) -> Iterable[str]:
        """Say what one container may keep; no other is read or touched.

        Raises:
            NotUnderstood, OutOfBounds, RecordUnavailable: Nothing was changed.
        """
        container = await self._meant(ask)
        said = await operator_view.limit_container(
            self._data_context, container, OPERATOR, names=asked.names, most_bytes=asked.most_bytes
        )
        return (said,)

    async def erase(self, ask: AdminRequest) -> Iterable[str]:
        """Erase a container, for good.

        Raises:
            NotUnderstood, NotPermitted, RobotBusy, RecordUnavailable: As `ErasureCommands.erase`.
        """
        if self._books.erasing is None:
            raise NotUnderstood(NEEDS_A_GATEWAY)
        container = await self._meant(ask)
        data_context, erasing = self._data_context, self._books.erasing
        return (await operator_view.erase_container(data_context, erasing, container, OPERATOR),)

    @property
    def _data_context(self) -> ContainerContext:
        if self._books.data_context is None:
            raise NotUnderstood(NONE_HERE)
        return self._books.data_context

    async def _meant(self, ask: AdminRequest) -> str:
        """Return the container that is meant: by its id, a robot's id, or a person's name."""
        name = " ".join(ask.names)
        data_context = self._data_context
        if name in data_context.robots or name in await data_context.container_store.containers():
            return name
        return the_one(self._books.authoriser.directory, name).id
