"""``/history``: who asked for what, when, with which values, and what came of it.

Everybody reads their own. A robot's is read by whoever looks after people here, or gives rights on
that robot: what its users asked of it is shown to nobody else (I11).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.container import letters
from rosic.core.history import REFUSED, RESUMED, HistoryEntry, HistoryQuery
from rosic.core.identity import PrincipalId
from rosic.core.language import clean
from rosic.core.life import ended_as
from rosic.core.message import Button
from rosic.core.saying import joined, said
from rosic.errors import NotPermitted, NotUnderstood, RecordUnavailable, StoreFault
from rosic.organiser.words_calendar import moment
from rosic.pipeline.containers import words_containers as words
from rosic.pipeline.desk import Reply
from rosic.pipeline.office import check_private

if TYPE_CHECKING:
    from rosic.core.robot import RobotId
    from rosic.pipeline.containers.parts import Holdings
    from rosic.pipeline.office import Asked

SHOWN: Final = 10
MORE: Final = 50
LONGEST: Final = 300
"""Letters of what somebody wrote or a robot said that one line repeats."""
NOTHING_YET: Final = said("Nothing was asked for yet, as far as the record goes back.")
HOW: Final = said(
    "Say history for what you asked for, or history and a robot's name; more shows more of it."
)
_MORE: Final = "more"


class Read(msgspec.Struct, frozen=True, kw_only=True):
    """One command in words.

    Attributes:
        asked: ``omni: move forward 0.5 m``; the skill alone where its words were erased.
        came: What came of it, as it was told.
    """

    who: PrincipalId
    at_ns: int
    robot: str
    skill: str
    outcome: str
    ended_ns: int | None
    asked: str
    came: str


class History:
    """The clerk of what was asked for."""

    def __init__(self, holdings: Holdings) -> None:
        self._holdings = holdings

    async def history(self, asked: Asked) -> Reply:
        """Show one's own, or a robot's.

        Raises:
            NotPermitted: Others read along, or that robot's is not theirs to read.
            NotUnderstood: It names no robot that they see.
            RecordUnavailable: It cannot be read now.
        """
        check_private(asked)
        who, said_words = asked.caller.principal, asked.rest.casefold().split()
        limit = MORE if _MORE in said_words else SHOWN
        named = [word for word in said_words if word != _MORE]
        robot = self._robot(who, named)
        query = HistoryQuery(principal="" if robot else who, robot=robot, limit=limit + 1)
        try:
            found = await self._holdings.vault.history(query)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault
        if not found:
            return Reply(NOTHING_YET)
        lines = [self._line(read_entry(e), who) for e in reversed(found[:limit])]
        further = Button(said("More"), " ".join(("/history", *named, _MORE)))
        return Reply(joined("\n", lines), ((further,),) if limit < len(found) <= MORE else ())

    def _robot(self, who: PrincipalId, named: list[str]) -> RobotId:
        if not named:
            return ""
        [robot, *rest] = named
        if rest or robot not in self._holdings.visible(who):
            raise NotUnderstood(HOW, offers=("/history",))
        if not self._holdings.may_oversee(who, robot):
            shown = self._holdings.shown(robot)
            raise NotPermitted(
                said(
                    "What was asked of {robot} is read by admins and by whoever gives rights on "
                    "it. Your own is in history.",
                    robot=shown,
                )
            )
        return robot

    def _line(self, read: Read, who: PrincipalId) -> str:
        zone, now_ns = self._holdings.zone_of(who), self._holdings.clock.wall_ns()
        when = moment(read.at_ns, now_ns, zone)
        name = "" if read.who == who else self._holdings.name(read.who)
        parts = [when, *filter(None, (name, read.asked)), read.came]
        return joined(" · ", parts)


def read_entry(entry: HistoryEntry) -> Read:
    """Return an entry in words; what was erased, or cannot be read any more, is left out."""
    return Read(
        who=entry.principal,
        at_ns=entry.at_ns,
        robot=entry.robot,
        skill=entry.skill or (RESUMED if entry.kind == RESUMED else ""),
        outcome=entry.outcome or (RESUMED if entry.kind == RESUMED else ""),
        ended_ns=entry.ended_ns,
        asked=_asked(entry),
        came=_came(entry),
    )


def _asked(entry: HistoryEntry) -> str:
    if entry.kind == RESUMED:
        return f"resume {entry.robot}"
    if entry.kind == REFUSED:
        return ""
    if entry.letter is not None:
        try:
            return _one_line(letters.read_reply_to(entry.letter).title)
        except msgspec.MsgspecError:
            pass
    return f"{entry.robot}: {entry.skill}"


def _came(entry: HistoryEntry) -> str:
    if entry.kind == RESUMED:
        return said("ready again")
    if entry.kind == REFUSED:
        return _refusal(entry)
    if entry.words:
        return _one_line(entry.words.decode("utf-8", "replace"))
    if not entry.outcome:
        return said("no end is known yet")
    return ended_as(entry.outcome)


def _refusal(entry: HistoryEntry) -> str:
    if entry.letter is not None:
        try:
            return _one_line(letters.read_answer(entry.letter).text)
        except msgspec.MsgspecError:
            pass
    return said("refused ({code})", code=entry.outcome)


def _one_line(text: str) -> str:
    return " ".join(clean(text[:LONGEST]).split())
