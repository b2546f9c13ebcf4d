"""Requests for help: one robot is stuck, another or a person takes it on, exactly one of them.

Whoever accepts first has it: accepting looks and writes in one turn, and counts once it is on disk.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.records import Decided, Fact, Letter
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_NS, HOUR_NS
from rosic.errors import Expired, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.features.robot_to_robot import messages as words

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.records import Record

KIND: Final = "robot-help"
OPEN_OF_ONE: Final = 3
# Nobody may ever say that the help is over; then it no longer keeps two robots from their tasks.
ENGAGED_NS: Final = HOUR_NS
KEPT_NS: Final = DAY_NS
KEPT_OVER: Final = 500

log = logging.getLogger("rosic.robot_to_robot")


class _Body(msgspec.Struct, frozen=True, array_like=True):
    """In the open: ids and times."""

    robot: RobotId
    at_ns: int
    until_ns: int
    by: PrincipalId = ""
    helper: RobotId = ""
    accepted_ns: int = 0
    over_ns: int = 0


class HelpRequest(msgspec.Struct, frozen=True):
    """One request.

    Attributes:
        what: In the robot's own words.
        until_ns: Nobody can accept it later, wall clock.
        by: Who has accepted it, robot or person; empty: nobody.
        helper: The robot that helps; empty where a person does so themselves.
        over_ns: When it was over; 0: it is not.
    """

    id: str
    robot: RobotId
    what: str
    at_ns: int
    until_ns: int
    by: PrincipalId = ""
    helper: RobotId = ""
    accepted_ns: int = 0
    over_ns: int = 0

    @property
    def open(self) -> bool:
        """Whether nobody has accepted it, and it is not over."""
        return not self.by and not self.over_ns


_encode = msgspec.msgpack.Encoder().encode
_read = msgspec.msgpack.Decoder(_Body).decode


class HelpRequests:
    """Every request of the last day. Pure state: whoever decides something writes it down.

    The robot's words are sealed in its own container.
    """

    def __init__(self, wall_ns: Callable[[], int]) -> None:
        self._wall_ns = wall_ns
        self._helps: dict[str, HelpRequest] = {}
        self._under_way: dict[str, None] = {}

    # ---- looking ----

    def find(self, ident: str) -> HelpRequest:
        """Return a request.

        Raises:
            NotUnderstood: There is none of that id.
        """
        found = self._helps.get(ident)
        if found is None:
            raise NotUnderstood(words.no_such_help())
        return found

    def open(self) -> list[HelpRequest]:
        """Return what can be accepted now, oldest first."""
        now_ns = self._wall_ns()
        return [h for h in self._helps.values() if h.open and now_ns < h.until_ns]

    def under_way(self) -> list[HelpRequest]:
        """Return what somebody has accepted and is not over."""
        return [self._helps[ident] for ident in self._under_way]

    def engages(self, robot: RobotId) -> bool:
        """Whether a robot helps or is helped now, so that it has no time for tasks."""
        since_ns = self._wall_ns() - ENGAGED_NS
        return any(
            robot in {h.robot, h.helper} and h.accepted_ns > since_ns for h in self.under_way()
        )

    def late(self, now_ns: int) -> list[HelpRequest]:
        """Return what nobody has accepted in time."""
        return [h for h in self._helps.values() if h.open and now_ns >= h.until_ns]

    def same(self, robot: RobotId, what: str) -> HelpRequest | None:
        """Return the open request of a robot that says the same; None if there is none."""
        return next((h for h in self.open() if h.robot == robot and h.what == what), None)

    # ---- deciding ----

    def ask(self, ident: str, robot: RobotId, what: str, for_s: float) -> tuple[HelpRequest, Fact]:
        """Return a new request, and what is to be written so that there is one.

        Raises:
            TooManyRequests: The robot asks for as much as it may at once.
        """
        if sum(h.robot == robot for h in self.open()) >= OPEN_OF_ONE:
            raise TooManyRequests(words.asks_enough(OPEN_OF_ONE), retry_after_s=0.0)
        now_ns = self._wall_ns()
        made = HelpRequest(ident, robot, what, now_ns, now_ns + int(for_s * 1e9))
        return made, self._fact(made)

    def accept(
        self, ident: str, by: PrincipalId, helper: RobotId, name_of: Callable[[PrincipalId], str]
    ) -> tuple[Record, ...]:
        """Return what is to be written so that somebody helps.

        Args:
            ident: Of the request.
            by: Who accepts it.
            helper: The robot that helps, if one does.
            name_of: How whoever was faster is named to them.

        Raises:
            NotUnderstood: There is no such request.
            Expired: It is accepted already, over, or too old. The sentence says by whom.
            OutOfBounds: A robot would help itself.
        """
        found, now_ns = self.find(ident), self._wall_ns()
        if found.by:
            raise Expired(words.accepted_already(name_of(found.by)))
        if found.over_ns or now_ns >= found.until_ns:
            raise Expired(words.help_over())
        if helper == found.robot:
            raise OutOfBounds(words.helps_itself())
        taken = msgspec.structs.replace(found, by=by, helper=helper, accepted_ns=now_ns)
        decided = Decided(act="robot-help", by=by, about=ident, at_ns=now_ns)
        return (decided, self._fact(taken))

    def end(self, ident: str) -> Fact | None:
        """Return what is to be written so that a request is over; None if it is already."""
        found = self.find(ident)
        if found.over_ns:
            return None
        return self._fact(msgspec.structs.replace(found, over_ns=self._wall_ns()))

    def forgotten(self) -> list[Fact]:
        """Return what takes away all that is long over, and the oldest of too much that is."""
        before_ns = self._wall_ns() - KEPT_NS
        over = [h for h in self._helps.values() if h.over_ns]
        beyond = over[: max(0, len(over) - KEPT_OVER)]
        long_ago = (h for h in self._helps.values() if max(h.until_ns, h.over_ns) < before_ns)
        old = {h.id: h for h in (*beyond, *long_ago)}.values()
        return [Fact(kind=KIND, key=h.id, body=b"") for h in old]

    def _fact(self, made: HelpRequest) -> Fact:
        body = _Body(
            made.robot,
            made.at_ns,
            made.until_ns,
            made.by,
            made.helper,
            made.accepted_ns,
            made.over_ns,
        )
        letter = Letter(made.robot, made.what.encode(errors="ignore"))
        return Fact(kind=KIND, key=made.id, body=_encode(body), letter=letter)

    def forget(self, robot: RobotId) -> None:
        """Forget a robot's words: its container was erased. What was decided stays so."""
        for ident, made in self._helps.items():
            if made.robot == robot:
                self._helps[ident] = msgspec.structs.replace(made, what="")

    # ---- what is so ----

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. What was erased keeps its times without its words."""
        self._under_way.pop(fact.key, None)
        if not fact.body:
            self._helps.pop(fact.key, None)
            return
        try:
            body = _read(fact.body)
        except msgspec.MsgspecError:
            log.warning("a request for help cannot be read")
            return
        what = "" if fact.letter is None else bytes(fact.letter.content).decode(errors="replace")
        self._helps[fact.key] = HelpRequest(
            fact.key,
            body.robot,
            what,
            body.at_ns,
            body.until_ns,
            body.by,
            body.helper,
            body.accepted_ns,
            body.over_ns,
        )
        if body.by and not body.over_ns:
            self._under_way[fact.key] = None
