"""Who asked for a right that they lack, and what became of it.

An access request is open until the first answer or until it lapses, and is remembered for an hour
after: so that nobody asks again at once for what was denied, and nobody floods those who have to
answer.
"""

from __future__ import annotations

import enum
import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import REQUEST_ID_BYTES, PrincipalId
from rosic.core.records import Decided, Fact
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_S, HOUR_S, SECOND_NS
from rosic.errors import Expired, OutOfBounds, TooManyRequests
from rosic.organiser import access_request_messages as words

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Entropy
    from rosic.core.records import Record

ACCESS_REQUEST: Final = "petition"
WAITS_S: Final = HOUR_S
REMEMBERED_S: Final = HOUR_S
SHORTEST_S: Final = 30.0
LONGEST_S: Final = 7.0 * DAY_S
MOST_OPEN: Final = 3
MOST_AN_HOUR: Final = 5
MOST_OF_ALL: Final = 300

log = logging.getLogger("rosic.organiser")


class RequestState(enum.Enum):
    """What became of an access request."""

    OPEN = "open"
    ALLOWED = "allowed"
    DENIED = "denied"
    LAPSED = "lapsed"


class WantedRight(msgspec.Struct, frozen=True, kw_only=True):
    """What somebody asks for: one thing that a robot does, or a role on it.

    Attributes:
        robot: Id, or the name of a group: of all that are in it.
        skill: Id; empty when it is a role.
        role: Name; empty when it is a skill.
        lasts_s: From the moment it is given.
    """

    robot: RobotId
    skill: str = ""
    role: str = ""
    lasts_s: float

    def same(self, other: WantedRight) -> bool:
        """Whether it is the same right, for however long."""
        mine, theirs = (self.robot, self.skill, self.role), (other.robot, other.skill, other.role)
        return mine == theirs


class AccessRequest(msgspec.Struct, frozen=True, kw_only=True):
    """The body of the fact; its key is the id.

    Attributes:
        principal: Who asks.
        asked_ns: Wall clock.
        settled_ns: Wall clock; 0 while it is open.
        by: Who answered.
        digest: Of what it would give when it was asked; whoever allows it, allows that. Empty in
            what versions before this one wrote: nobody can allow that any more.
    """

    id: str
    principal: PrincipalId
    want: WantedRight
    asked_ns: int
    state: RequestState = RequestState.OPEN
    settled_ns: int = 0
    by: PrincipalId = ""
    digest: bytes = b""

    @property
    def lapses_ns(self) -> int:
        """When it lapses unless somebody answers; wall clock."""
        return self.asked_ns + WAITS_S * SECOND_NS

    @property
    def forgotten_ns(self) -> int:
        """Until when it is remembered; wall clock."""
        return max(self.asked_ns, self.settled_ns) + REMEMBERED_S * SECOND_NS


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(AccessRequest).decode


class AccessRequests:
    """All that are open or remembered; bounded for each person and in all.

    Args:
        wall_ns: Returns the wall clock that never goes back.
    """

    def __init__(self, wall_ns: Callable[[], int], entropy: Entropy) -> None:
        self._wall_ns = wall_ns
        self._entropy = entropy
        self._known: dict[str, AccessRequest] = {}

    # ---- state ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. What cannot be read is forgotten: it gives nobody anything."""
        self._known.pop(fact.key, None)
        if not fact.body:
            return
        try:
            self._known[fact.key] = _decode(fact.body)
        except msgspec.MsgspecError:
            log.warning("a petition cannot be read; whoever asked has to ask again")

    # ---- asking ----

    def ask(
        self, principal: PrincipalId, want: WantedRight, digest: bytes
    ) -> tuple[AccessRequest, tuple[Record, ...]]:
        """Return a new access request, and the records that open it.

        Args:
            principal: Who asks.
            want: For what.
            digest: Of what that would give now.

        Raises:
            OutOfBounds: For no time, or for longer than anything is given on request.
            TooManyRequests: The same is open or was denied lately, or they ask too often. Nothing
                changed.
        """
        if not SHORTEST_S <= want.lasts_s <= LONGEST_S:
            raise OutOfBounds(words.no_such_time())
        now_ns = self._wall_ns()
        mine = [p for p in self._known.values() if p.principal == principal]
        self._check_new(mine, want, now_ns)
        self._check_often(mine, now_ns)
        access_request = AccessRequest(
            id=f"a{self._entropy.token(REQUEST_ID_BYTES).hex()}",
            principal=principal,
            want=want,
            asked_ns=now_ns,
            digest=digest,
        )
        return access_request, self._records(access_request, "ask", principal)

    def _check_new(self, mine: Iterable[AccessRequest], want: WantedRight, now_ns: int) -> None:
        for access_request in mine:
            if not access_request.want.same(want):
                continue
            if access_request.state is RequestState.OPEN and now_ns < access_request.lapses_ns:
                raise _wait(words.asked_already, access_request.lapses_ns - now_ns)
            if access_request.state is RequestState.DENIED and now_ns < access_request.forgotten_ns:
                raise _wait(words.denied_lately, access_request.forgotten_ns - now_ns)

    def _check_often(self, mine: list[AccessRequest], now_ns: int) -> None:
        still = [p for p in mine if p.state is RequestState.OPEN and now_ns < p.lapses_ns]
        if len(still) >= MOST_OPEN:
            raise _wait(words.too_many_open, min(p.lapses_ns for p in still) - now_ns)
        hour_ns = REMEMBERED_S * SECOND_NS
        lately = [p.asked_ns + hour_ns for p in mine if now_ns < p.asked_ns + hour_ns]
        if len(lately) >= MOST_AN_HOUR:
            raise _wait(words.too_often, min(lately) - now_ns)
        if len(self._known) >= MOST_OF_ALL:
            raise _wait(words.too_many_here, hour_ns)

    # ---- answering ----

    def allow(self, access_request: AccessRequest, by: PrincipalId) -> tuple[Record, ...]:
        """Return the records of a yes; what is given is the grants's business.

        Raises:
            Expired: It is settled, or waited too long.
        """
        return self._settled(access_request, RequestState.ALLOWED, by)

    def deny(self, access_request: AccessRequest, by: PrincipalId) -> tuple[Record, ...]:
        """Return the records of a no.

        Raises:
            Expired: It is settled, or waited too long.
        """
        return self._settled(access_request, RequestState.DENIED, by)

    def _settled(
        self, access_request: AccessRequest, state: RequestState, by: PrincipalId
    ) -> tuple[Record, ...]:
        now_ns = self._wall_ns()
        known = self._known.get(access_request.id)
        if known is None or known.state is not RequestState.OPEN or now_ns >= known.lapses_ns:
            raise Expired(words.settled())
        settled = msgspec.structs.replace(known, state=state, by=by, settled_ns=now_ns)
        return self._records(settled, state.value, by)

    def _records(
        self, access_request: AccessRequest, act: str, by: PrincipalId
    ) -> tuple[Record, ...]:
        now_ns = self._wall_ns()
        decided = Decided(
            act=f"petition-{act}",
            by=by,
            about=access_request.principal,
            at_ns=now_ns,
            digest=access_request.id.encode(),
        )
        return decided, Fact(
            kind=ACCESS_REQUEST, key=access_request.id, body=_encode(access_request)
        )

    # ---- time ----

    def late(self) -> tuple[AccessRequest, ...]:
        """Return every open access request that nobody answered in time."""
        now_ns = self._wall_ns()
        return tuple(
            p
            for p in self._known.values()
            if p.state is RequestState.OPEN and now_ns >= p.lapses_ns
        )

    def lapse(self, access_request: AccessRequest) -> Fact:
        """Return what settles an access request that nobody answered."""
        now_ns = self._wall_ns()
        lapsed = msgspec.structs.replace(
            access_request, state=RequestState.LAPSED, settled_ns=now_ns
        )
        return Fact(kind=ACCESS_REQUEST, key=access_request.id, body=_encode(lapsed))

    def lapse_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what settles whatever somebody has asked for, and nobody has answered."""
        return tuple(self.lapse(one) for one in self.open() if one.principal == principal)

    def stale(self) -> tuple[Fact, ...]:
        """Return what is to be written so that old access requests take no room any more."""
        now_ns = self._wall_ns()
        return tuple(
            Fact(kind=ACCESS_REQUEST, key=access_request.id, body=b"")
            for access_request in self._known.values()
            if access_request.state is not RequestState.OPEN
            and now_ns >= access_request.forgotten_ns
        )

    # ---- looking ----

    def get(self, access_request: str) -> AccessRequest | None:
        """Return an access request, open or remembered."""
        return self._known.get(access_request)

    def open(self) -> tuple[AccessRequest, ...]:
        """Return every access request that can still be answered, the oldest first."""
        now_ns = self._wall_ns()
        return tuple(
            p for p in self._known.values() if p.state is RequestState.OPEN and now_ns < p.lapses_ns
        )


def _wait(sentence: words.Pause, wait_ns: int) -> TooManyRequests:
    wait_s = max(1.0, wait_ns / SECOND_NS)
    return TooManyRequests(sentence(wait_s), retry_after_s=wait_s)
