"""``/share bay with Bo for 2h`` and ``/shelf``: what I keep, lend, and am lent."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from rosic.container import messages
from rosic.core.i18n import joined
from rosic.core.language.keywords import option_typed
from rosic.core.language.sanitise import clean_name
from rosic.core.language.time_tokens import TimeTokens, UnclearTime
from rosic.core.message import Button
from rosic.core.messages import ago as age_in_words
from rosic.core.time_units import DAY_S
from rosic.errors import NotUnderstood
from rosic.features.personal_data import messages as words
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply, check_length, check_private
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.container.shared_data import SharedValue
    from rosic.container.shared_data_access import SharedDataGrant
    from rosic.core.identity import PrincipalId
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext

BACK: Final = "back"
LONGEST_LINE: Final = 300
MOST_LINES: Final = 40
MOST_BUTTONS: Final = 12
LONGEST_S: Final = 366.0 * DAY_S
_WITH = re.compile(r"\s+(?:with|mit)\s+", re.IGNORECASE)
_FROM = re.compile(r"\s+(?:from|von)\s+", re.IGNORECASE)
_FOR = re.compile(r"\s+(?:for|für)\s+", re.IGNORECASE)


class ShareCommands:
    """The handler who lends. Speaks of one's own container in private alone."""

    def __init__(self, data_context: ContainerContext) -> None:
        self._data_context = data_context
        self._shelf = data_context.shelf
        self._lending = data_context.shelf.lending

    # ---- /shelf ----

    async def shelf(self, asked: CommandContext) -> Reply:
        """Show what is mine, what I lend, and what others lend me.

        Raises:
            NotPermitted: Others read along.
        """
        check_private(asked)
        principal = asked.caller.principal
        lent = self._lending.by(principal)
        lines = [*self._mine(principal), *self._lent(principal, lent), *self._to_me(principal)]
        buttons = [
            Button(words.take_back(self._name(loan.reader)), self._back(loan))
            for loan in lent[:MOST_BUTTONS]
        ]
        return Reply(joined("\n", lines or [words.EMPTY]), rows(buttons))

    def _mine(self, principal: PrincipalId) -> list[str]:
        kept = self._shelf.names(principal, principal)[-MOST_LINES:]
        if not kept:
            return []
        quota, (names, size) = self._shelf.quota(principal), self._shelf.used(principal)
        used = words.used(names, quota.names, size, quota.most_bytes)
        return [words.MINE, *(f"  {self._line(each)}" for each in kept), used]

    def _lent(self, principal: PrincipalId, lent: Sequence[SharedDataGrant]) -> list[str]:
        if not lent:
            return []
        lines = [
            words.lent_line(loan.name, self._name(loan.reader), self._until(principal, loan))
            for loan in lent[:MOST_LINES]
        ]
        return [words.LENT, *lines]

    def _to_me(self, principal: PrincipalId) -> list[str]:
        readers = (principal, *sorted(self._data_context.visible(principal)))
        loans = [loan for loan in self._lending.to(readers) if loan.owner != principal]
        found = [self._shelf.latest(principal, loan.owner, loan.name) for loan in loans]
        lines = [f"  {self._line(kept)}" for kept in dict.fromkeys(found) if kept is not None]
        return [words.TO_ME, *lines[:MOST_LINES]] if lines else []

    def _line(self, kept: SharedValue) -> str:
        ago = age_in_words((self._data_context.clock.wall_ns() - kept.at_ns) / 1e9)
        return messages.kept_line(kept.name, kept.value, self._data_context.name(kept.sender), ago)

    def _until(self, principal: PrincipalId, loan: SharedDataGrant) -> str:
        if not loan.until_ns:
            return ""
        zone = self._data_context.zone_of(principal)
        return moment(loan.until_ns, self._data_context.clock.wall_ns(), zone)

    def _name(self, reader: str) -> str:
        data_context = self._data_context
        return (
            data_context.shown(reader)
            if reader in data_context.robots
            else data_context.name(reader)
        )

    @staticmethod
    def _back(loan: SharedDataGrant) -> str:
        return f"/share {BACK} {loan.name} from {loan.reader}"

    # ---- /share ----

    async def share(self, asked: CommandContext) -> Reply:
        """Lend a name of one's own to somebody, or take it back.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        check_private(asked)
        said, principal = " ".join(asked.rest.split()), asked.caller.principal
        check_length(said, LONGEST_LINE)
        first, _, rest = said.partition(" ")
        if option_typed(first.casefold()) == BACK and rest and not _WITH.search(said):
            return await self._take_back(principal, rest)
        name, *others = _WITH.split(said, maxsplit=1)
        if not name.strip() or not others:
            raise NotUnderstood(words.HOW_TO_SHARE, offers=("/shelf",))
        return await self._lend(principal, clean_name(name), others[0])

    async def _lend(self, principal: PrincipalId, name: str, rest: str) -> Reply:
        data_context = self._data_context
        who, *said = _FOR.split(rest, maxsplit=1)
        # Somebody may be called "Bo for 2h", and another Bo.
        found: list[tuple[str, tuple[str, ...]]] = []
        if said:
            found += [(one, ()) for one in data_context.find(rest)]
        if not found or data_context.find(who):
            found += [(one, tuple(said)) for one in self._found(principal, who)]
        if len(found) > 1:
            return self._which(name, found)
        [(reader, lasts)] = found
        if reader == principal:
            raise NotUnderstood(words.YOURSELF)
        until_ns = data_context.clock.wall_ns() + _length_ns(lasts[0]) if lasts else 0
        async with data_context.changes.turn() as turn:
            if self._shelf.latest(principal, principal, name) is None:
                raise NotUnderstood(words.nothing_to_share(name), offers=("/shelf",))
            await turn.write(self._lending.lend(principal, reader, name, until_ns=until_ns))
        if reader not in data_context.robots:
            by = data_context.name(principal)
            data_context.tell((reader,), words.somebody_shares(by, name))
        (loan,) = (
            one for one in self._lending.by(principal) if (one.reader, one.name) == (reader, name)
        )
        text = words.shared(name, self._name(reader), self._until(principal, loan))
        return Reply(text, ((Button(words.TAKE_BACK, self._back(loan)),),))

    async def _take_back(self, principal: PrincipalId, rest: str) -> Reply:
        name, *others = _FROM.split(rest, maxsplit=1)
        reader = self._one(principal, others[0]) if others else ""
        async with self._data_context.changes.turn() as turn:
            await turn.write(self._lending.take_back(principal, clean_name(name), reader))
        return Reply(words.taken_back(clean_name(name)))

    # ---- who ----

    def _found(self, principal: PrincipalId, said: str) -> tuple[str, ...]:
        """Return a robot that they see, or everybody who is called so.

        Raises:
            NotUnderstood: There is none.
        """
        said, data_context = said.strip(), self._data_context
        for robot in sorted(data_context.visible(principal)):
            if said.casefold() in {robot.casefold(), data_context.shown(robot).casefold()}:
                return (robot,)
        found = data_context.find(said)
        if not found:
            raise NotUnderstood(words.nobody_called(said), offers=("/shelf",))
        return found

    def _one(self, principal: PrincipalId, said: str) -> str:
        lent = {loan.reader for loan in self._lending.by(principal)}
        if said.strip() in lent:  # whoever it is, and whether or not they have access still
            return said.strip()
        found = self._found(principal, said)
        meant = [one for one in found if one in lent] or list(found)
        return meant[0]

    def _which(self, name: str, found: Sequence[tuple[str, tuple[str, ...]]]) -> Reply:
        buttons = [
            Button(
                words.numbered(self._name(one), number),
                f"/share {name} with {one}{f' for {lasts[0]}' if lasts else ''}",
            )
            for number, (one, lasts) in enumerate(found[:MOST_BUTTONS], start=1)
        ]
        return Reply(words.SEVERAL, rows(buttons))


def _length_ns(text: str) -> int:
    """Return for how long, from now.

    Raises:
        NotUnderstood: It is no length of time, or too long a one.
    """
    try:
        length_s = TimeTokens(text).length_s
    except UnclearTime:
        length_s = None
    if length_s is None or not 0 < length_s <= LONGEST_S:
        raise NotUnderstood(words.HOW_LONG)
    return int(length_s * 1e9)
