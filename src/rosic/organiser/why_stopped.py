"""Who stopped robots, who can resume them, and what somebody is offered who may or may not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

from rosic.core.i18n import joined, said
from rosic.core.language.suggestions import AND, OR
from rosic.core.messages import by_whom
from rosic.core.policy.scope import RESUME
from rosic.errors import RobotStopped

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order
    from rosic.core.policy.permissions import Permissions
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.stop_registry import StopRegistry
    from rosic.errors import NotPermitted, Refusal
    from rosic.organiser.calendar import Calendar

NOTHING_DONE: Final = said("Nothing was done.")
NAMED_AT_MOST: Final = 8
"""As many as a line may name to resume them."""


class PolicyInformation(Protocol):
    """What refusals are made of; the organiser answers.

    Attributes:
        locked: Who is locked.
        calendar: Whose time it is.
    """

    locked: Collection[PrincipalId]
    calendar: Calendar

    @property
    def rights(self) -> Permissions:
        """The present snapshot."""
        ...

    @property
    def wall_ns(self) -> Callable[[], int]:
        """The time by which rights and slots end."""
        ...

    @property
    def name_of(self) -> Callable[[PrincipalId], str]:
        """Returns how somebody is called."""
        ...

    @property
    def moment(self) -> Callable[[PrincipalId, int], str]:
        """Returns when something is, as somebody reads it."""
        ...

    @property
    def own_limits(self) -> Callable[[PrincipalId], tuple[str, ...]]:
        """Returns what somebody has set for themselves, as the texts of limits."""
        ...

    def allows(self, principal: PrincipalId, robot: RobotId, skill: str) -> bool:
        """Whether somebody has a right at all now."""
        ...

    def free_in(self, robot: RobotId) -> tuple[bool, float]:
        """Return whether a robot that is taken is at work, and the seconds that it has to idle."""
        ...

    def why_not_move(self, principal: PrincipalId, robot: RobotId) -> NotPermitted | None:
        """Return why somebody may not move a robot at all; None if they may."""
        ...

    def outside_slot(self, principal: PrincipalId, robot: RobotId) -> Refusal | None:
        """Return why a robot is not somebody's now, by slots alone; None if it may be."""
        ...


class WhyStopped:
    """Says it of one robot, or of several in one sentence."""

    def __init__(
        self, organiser: PolicyInformation, profiles: Mapping[RobotId, Profile], stops: StopRegistry
    ) -> None:
        self._organiser = organiser
        self._profiles = profiles
        self._stops = stops

    def refusal(self, principal: PrincipalId, robots: Sequence[RobotId]) -> RobotStopped:
        """Return why none of some stopped robots moves, and what helps: at least one of them."""
        barred = self._stops.barred(robots[0])
        if barred is not None:
            return RobotStopped(joined(" ", (barred.sentence, NOTHING_DONE)))
        sentence = self.since(principal, robots)
        may = self.resumable(principal, robots)
        offers = (f"resume {' '.join(may[:NAMED_AT_MOST])}",) if may else ()
        left = [robot for robot in robots if robot not in may]
        if not left:
            return RobotStopped(joined(" ", (sentence, _until_you(robots))), offers=offers)
        who = self.who_resumes(principal, left, several=len(robots) > 1)
        return RobotStopped(
            joined(" ", (sentence, who, NOTHING_DONE)),
            offers=offers,
            access_request=self.access_request(principal, left[0]),
        )

    def resumable(self, principal: PrincipalId, robots: Sequence[RobotId]) -> list[RobotId]:
        """Return those of some stopped robots that somebody may resume."""
        organiser, stops = self._organiser, self._stops
        return [
            robot
            for robot in robots
            if stops.barred(robot) is None and may_resume(organiser, stops, principal, robot)
        ]

    def access_request(self, principal: PrincipalId, robot: RobotId) -> str:
        """Return how to ask for the right to resume; nothing when there is nobody to ask."""
        now_ns = self._organiser.wall_ns()
        givers = self._organiser.rights.givers(robot, now_ns, besides=principal)
        return f"/ask {robot} {RESUME}" if givers else ""

    def who_resumes(
        self, principal: PrincipalId, robots: Sequence[RobotId], *, several: bool = False
    ) -> str:
        """Say who else can resume some robots: "it" where there is only one, unless of several."""
        if len(robots) == 1 and not several:
            names = self._resumers(principal, robots[0])
            if not names:
                return said("The operator of this place can resume it.")
            return said("{names} can resume it.", names=joined(OR, names))
        whose: dict[tuple[str, ...], list[RobotId]] = {}
        for robot in robots[:NAMED_AT_MOST]:
            whose.setdefault(self._resumers(principal, robot), []).append(robot)
        more = ", ..." if len(robots) > NAMED_AT_MOST else ""
        sentences: list[str] = []
        for names, theirs in whose.items():
            shown = joined("", (self._names(theirs), more))
            if names:
                sentences.append(
                    said("{names} can resume {robots}.", names=joined(OR, names), robots=shown)
                )
            else:
                sentences.append(
                    said("The operator of this place can resume {robots}.", robots=shown)
                )
        return joined(" ", sentences)

    def _resumers(self, principal: PrincipalId, robot: RobotId) -> tuple[str, ...]:
        organiser = self._organiser
        found = organiser.rights.resumers(robot, organiser.wall_ns(), besides=principal)
        return tuple(organiser.name_of(who) for who in found if who not in organiser.locked)

    def by_another(self, order: Order) -> str:
        """Return who stopped an order's robot since it was given; empty: nobody, or its author."""
        stop = self._stops[order.robot]
        later = stop.latched and stop.generation > order.permit.stop_generation
        if not later or stop.by in {"", order.permit.principal}:
            return ""
        return said("a stop by {name}", name=self._organiser.name_of(stop.by))

    def since(self, principal: PrincipalId, robots: Sequence[RobotId]) -> str:
        """Return that some robots are stopped, by whom and since when if that is so of them all."""
        moments = {(self._stoppers(r), self._when(principal, r)) for r in robots}
        by, when = moments.pop()
        one = len(robots) == 1
        shown = self._names(robots)
        if not by or moments:
            return (
                said("{shown} is stopped.", shown=shown)
                if one
                else said("{robots} are stopped.", robots=shown)
            )
        *others, last = (
            by_whom(who, principal, self._organiser.name_of) for who in by[-NAMED_AT_MOST:]
        )
        name = joined(AND, filter(None, (joined(", ", others), last)))
        if one:
            return said(
                "{shown} is stopped, by {name}, since {when}.", shown=shown, name=name, when=when
            )
        return said(
            "{robots} are stopped, by {name}, since {when}.", robots=shown, name=name, when=when
        )

    def _stoppers(self, robot: RobotId) -> tuple[PrincipalId, ...]:
        """Return who has stopped a robot since it was free, the last of them last; mostly one."""
        stop = self._stops[robot]
        if not stop.by:
            return ()
        return (*(who for who in stop.stoppers if who not in {"", stop.by}), stop.by)

    def _when(self, principal: PrincipalId, robot: RobotId) -> str:
        stop = self._stops[robot]
        first_ns = min(filter(None, stop.stoppers.values()), default=stop.since_ns)
        return self._organiser.moment(principal, first_ns)

    def _names(self, robots: Sequence[RobotId]) -> str:
        *others, last = (self._profiles[robot].shown for robot in robots)
        return joined(AND, filter(None, (joined(", ", others), last)))


def _until_you(robots: Sequence[RobotId]) -> str:
    if len(robots) == 1:
        return said("It stays stopped until you resume it. Nothing was done.")
    return said("They stay stopped until you resume them. Nothing was done.")


def may_resume(
    organiser: PolicyInformation, stops: StopRegistry, principal: PrincipalId, robot: RobotId
) -> bool:
    """Whether a stop is somebody's to undo: by right, or as they stopped their own order."""
    by_right = organiser.allows(principal, robot, RESUME)
    return by_right or stopped_own(organiser, stops, principal, robot)


def stopped_own(
    organiser: PolicyInformation, stops: StopRegistry, principal: PrincipalId, robot: RobotId
) -> bool:
    """Whether a robot is stopped as somebody stopped their own order, and may move it."""
    own = stops[robot].own == principal
    return own and organiser.why_not_move(principal, robot) is None
