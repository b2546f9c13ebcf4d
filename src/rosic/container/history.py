"""What people ask for often: the commands they are offered first, and the last one, to ask again.

Counted in memory while orders pass, sealed in the person's own container now and then.
"""

from __future__ import annotations

import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.core.records import Fact, Letter

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat

KIND: Final = "habits"
# What is asked for once is no habit.
OFTEN = 2
OFFERED = 3
COMMANDS_AT_MOST = 40
PEOPLE_AT_MOST = 10_000
LONGEST = 80

_Name: TypeAlias = str
_Habits: TypeAlias = dict[tuple[_Name, str], int]

log = logging.getLogger("rosic.container")

_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(list[tuple[str, str, int]]).decode


class CommandHistory:
    """Everybody's. Bounded: whoever has not been here for longest is forgotten first."""

    def __init__(self) -> None:
        self._people: OrderedDict[PrincipalId, _Habits] = OrderedDict()
        self._last: OrderedDict[tuple[PrincipalId, str, str], tuple[_Name, str]] = OrderedDict()
        self._kept: dict[PrincipalId, frozenset[tuple[_Name, str]]] = {}
        self._changed: dict[PrincipalId, None] = {}

    def note(self, principal: PrincipalId, chat: Chat, name: str, command: str) -> None:
        """Take in that somebody gave a command to a robot or a group, as typed, in a chat."""
        said = (name, command)
        self._last[principal, chat.platform, chat.id] = said
        if len(self._last) > PEOPLE_AT_MOST:
            self._last.popitem(last=False)
        if len(command) > LONGEST:
            return
        command_history = self._people.get(principal)
        if command_history is None:
            command_history = self._people[principal] = {}
            if len(self._people) > PEOPLE_AT_MOST:
                self._kept.pop(self._people.popitem(last=False)[0], None)
        command_history[said] = times = command_history.get(said, 0) + 1
        if times > OFTEN:
            return
        if times == OFTEN:
            self._changed[principal] = None
        if len(command_history) > COMMANDS_AT_MOST:
            self._people[principal] = {what: n // 2 for what, n in command_history.items() if n > 1}
            self._changed[principal] = None

    def last(self, principal: PrincipalId, chat: Chat) -> tuple[str, str] | None:
        """Return whom somebody commanded last in a chat, and how."""
        return self._last.get((principal, chat.platform, chat.id))

    def favourites(self, principal: PrincipalId, name: str) -> tuple[str, ...]:
        """Return what somebody often asks of a robot or a group, most often first."""
        command_history = self._people.get(principal, {})
        often = [
            (-n, said[1]) for said, n in command_history.items() if said[0] == name and n >= OFTEN
        ]
        return tuple(command for _, command in sorted(often)[:OFFERED])

    # ---- what is kept ----

    def unwritten(self) -> tuple[Fact, ...]:
        """Return what to write so that habits outlive a restart: of people whose habits changed.

        What is counted between two such moments is lost with a crash.
        """
        facts: list[Fact] = []
        for principal in tuple(self._changed):
            command_history = self._people.get(principal, {})
            often = frozenset(said for said, n in command_history.items() if n >= OFTEN)
            if often == self._kept.get(principal, frozenset()):
                del self._changed[principal]
            else:
                content = _encode([(*said, command_history[said]) for said in sorted(often)])
                letter = Letter(container=principal, content=content)
                facts.append(Fact(kind=KIND, key=principal, body=b"1", letter=letter))
        return tuple(facts)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read, or is erased, is no habit."""
        principal = fact.key
        if not fact.body or fact.letter is None:
            self.forget(principal)
            return
        try:
            kept = _decode(fact.letter.content)
        except msgspec.MsgspecError:
            log.warning("what somebody often asks for cannot be read; it is counted anew")
            return
        command_history = self._people.setdefault(principal, {})
        for name, command, n in kept[:COMMANDS_AT_MOST]:
            command_history[name, command] = max(n, command_history.get((name, command), 0))
        self._kept[principal] = frozenset((name, command) for name, command, _ in kept)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes somebody's habits back."""
        return (Fact(kind=KIND, key=principal, body=b""),) if principal in self._kept else ()

    def forget(self, principal: PrincipalId) -> None:
        """Know nothing of somebody any more."""
        for known in (self._people, self._kept, self._changed):
            known.pop(principal, None)
        for where in [key for key in self._last if key[0] == principal]:
            del self._last[where]
