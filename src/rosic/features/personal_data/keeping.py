"""``/data``: small values kept with a robot, or with oneself (storeData, getSharedData)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.container import messages
from rosic.errors import NotUnderstood
from rosic.features.personal_data import messages as words
from rosic.gateway.builtin_commands import Reply
from rosic.gateway.office import check_private

if TYPE_CHECKING:
    from rosic.container.shared_data import SharedValue
    from rosic.core.identity import PrincipalId
    from rosic.features.personal_data.context import ContainerContext
    from rosic.gateway.office import CommandContext

MOST_LINES = 40


class SharedDataCommands:
    """The clerk of shared data. Of one's own container is spoken in private alone."""

    def __init__(self, holdings: ContainerContext) -> None:
        self._holdings = holdings
        self._shelf = holdings.shelf

    async def data(self, asked: CommandContext) -> Reply:
        """Show what a container keeps, store a value, or remove one.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        said, principal = asked.rest.strip(), asked.caller.principal
        owner, rest = self._owner(principal, said)
        if owner == principal:
            check_private(asked)
        if "=" not in rest:
            return Reply(self._show(principal, owner, rest))
        name, _, value = (part.strip() for part in rest.partition("="))
        async with self._holdings.changes.turn() as turn:
            if value:
                await turn.write(self._shelf.store(principal, owner, name, value))
                return Reply(words.DATA_STORED)
            await turn.write(self._shelf.remove(principal, owner, name))
        return Reply(words.DATA_REMOVED)

    def _owner(self, principal: PrincipalId, said: str) -> tuple[str, str]:
        """Return whose container is meant, and what else was said."""
        first, _, rest = said.partition(" ")
        if first in self._holdings.visible(principal):
            return first, rest.strip()
        if said and "=" not in said and not self._mine(principal, said):
            raise NotUnderstood(words.HOW_TO_KEEP, offers=("/data",))
        return principal, said

    def _mine(self, principal: PrincipalId, name: str) -> bool:
        return bool(self._shelf.history(principal, principal, name))

    def _show(self, principal: PrincipalId, owner: str, name: str) -> str:
        shown = words.YOU if owner == principal else self._holdings.shown(owner)
        found = (
            self._shelf.history(principal, owner, name)
            if name
            else self._shelf.names(principal, owner)
        )
        if not found:
            return messages.nothing_kept(shown, name)
        return messages.kept_lines(shown, [*map(self._line, found[-MOST_LINES:])])

    def _line(self, kept: SharedValue) -> str:
        age_s = (self._holdings.clock.wall_ns() - kept.at_ns) / 1e9
        sender, ago = self._holdings.name(kept.sender), messages.age(age_s)
        return messages.kept_line(kept.name, kept.value, sender, ago)
