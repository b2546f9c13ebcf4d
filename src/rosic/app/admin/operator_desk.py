"""Brings what the operator asks about people and their rights to whoever does it.

The same desk answers in a running gateway and for a command that opened the data itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import msgspec

from rosic.app.admin.access import AccessAdmin, InviteAsk, RotateAsk
from rosic.app.admin.asked import Verb
from rosic.app.admin.containers import ContainersAdmin, LimitAsk
from rosic.app.admin.explain import Explainer
from rosic.app.admin.history import HistoryAsk, history_of
from rosic.app.admin.naming import people_lines, people_listed
from rosic.app.admin.schedule import BookAsk, ScheduleAdmin, ScheduleWindow
from rosic.config.profiles import known_units
from rosic.core.i18n import plain
from rosic.core.policy.limits import unit_converter
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
    from typing import TypeAlias

    from rosic.app.admin.api import AdminContext
    from rosic.app.admin.asked import Ask

    Doing: TypeAlias = Callable[[Ask], Awaitable[Iterable[str]]]

LINES_AT_ONCE = 500
ACCEPT = "accept"
NO_REQUEST = "That is no request I know."

T = TypeVar("T")

_encode = msgspec.json.Encoder(enc_hook=plain).encode


class AdminApi:
    """Answers each verb but those about robots' motion.

    Attributes:
        access: Who comes in, and whose access ends.
    """

    def __init__(self, books: AdminContext) -> None:
        self.access = AccessAdmin(books, unit_converter(known_units()))
        self._books = books
        self._planning = ScheduleAdmin(books)
        self._explaining = Explainer(books)
        self._containers = ContainersAdmin(books)
        self._doing: dict[Verb, Doing] = {
            Verb.PEOPLE: self._people,
            Verb.REVOKE: self._to(self.access.revoke),
            Verb.INVITE: self._invite,
            Verb.KEYS: self._keys,
            Verb.ROTATE: self._rotate,
            Verb.TAKE_KEY: self._to(self.access.take_key),
            Verb.LOCK: self._to(self.access.lock),
            Verb.UNLOCK: self._to(self.access.unlock),
            Verb.EXPLAIN: self._explain,
            Verb.SECURITY: self._security,
            Verb.WHO: self._who,
            Verb.TAKEN: self._taken,
            Verb.BOOK: self._book,
            Verb.CLOCK: self._clock,
            Verb.CONTAINERS: self._containers.list,
            Verb.CONTAINER: self._containers.show,
            Verb.CONTENT: self._containers.content,
            Verb.LIMIT: self._limit,
            Verb.ERASE: self._containers.erase,
            Verb.HISTORY: self._history,
        }

    async def do(self, ask: Ask) -> Iterable[str]:
        """Do what is asked, and return the answers.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        doing = self._doing.get(ask.verb)
        if doing is None:
            raise NotUnderstood(NO_REQUEST)
        return await doing(ask)

    def _to(self, act: Callable[[str], Awaitable[str]]) -> Doing:
        async def doing(ask: Ask) -> Iterable[str]:
            return (await act(" ".join(ask.names)),)

        return doing

    async def _people(self, ask: Ask) -> Iterable[str]:
        if ask.wants_json:
            return _lists(people_listed(self._books))
        return _together(people_lines(self._books) or ("Nobody is known yet.",))

    async def _invite(self, ask: Ask) -> Iterable[str]:
        return await self.access.invite(body_of(ask, InviteAsk))

    async def _keys(self, ask: Ask) -> Iterable[str]:
        if ask.wants_json:
            return _lists(self.access.keys_listed(ask.names))
        return _together(self.access.keys(ask.names))

    async def _rotate(self, ask: Ask) -> Iterable[str]:
        return (await self.access.rotate(" ".join(ask.names), body_of(ask, RotateAsk)),)

    async def _explain(self, ask: Ask) -> Iterable[str]:
        if len(ask.names) != 2:  # noqa: PLR2004 - a person and a line
            raise NotUnderstood(NO_REQUEST)
        return self._explaining.explain(*ask.names)

    async def _security(self, ask: Ask) -> Iterable[str]:
        security = self._books.access.security
        if ask.names == ("json",):
            return (_encode(security.report()).decode(),)
        return (security.text(),)

    async def _clock(self, ask: Ask) -> Iterable[str]:
        if ask.names not in {(), (ACCEPT,)}:
            raise NotUnderstood(NO_REQUEST)
        return (await self.access.clock(accept=ask.names == (ACCEPT,)),)

    async def _who(self, _ask: Ask) -> Iterable[str]:
        return (_encode(some).decode() for some in self._planning.who())

    async def _taken(self, ask: Ask) -> Iterable[str]:
        found = self._planning.taken(body_of(ask, ScheduleWindow))
        return (_encode(some).decode() for some in found)

    async def _book(self, ask: Ask) -> Iterable[str]:
        return (await self._planning.book(body_of(ask, BookAsk)),)

    async def _history(self, ask: Ask) -> Iterable[str]:
        return await history_of(self._books, body_of(ask, HistoryAsk))

    async def _limit(self, ask: Ask) -> Iterable[str]:
        return await self._containers.limit(ask, body_of(ask, LimitAsk))


def _together(lines: Sequence[str]) -> Iterator[str]:
    """Yield lines, many at a time: one answer has a longest size."""
    for at in range(0, len(lines), LINES_AT_ONCE):
        yield "\n".join(lines[at : at + LINES_AT_ONCE])


def _lists(listed: Sequence[object]) -> Iterator[str]:
    """Yield lists for programs, at least one."""
    for at in range(0, max(1, len(listed)), LINES_AT_ONCE):
        yield _encode(listed[at : at + LINES_AT_ONCE]).decode()


def body_of(ask: Ask, kind: type[T]) -> T:
    """Return what else a verb asks for.

    Raises:
        NotUnderstood: It is something else.
    """
    try:
        return msgspec.json.decode(ask.body, type=kind)
    except msgspec.MsgspecError as error:
        raise NotUnderstood(NO_REQUEST) from error
