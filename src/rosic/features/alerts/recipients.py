"""What one person is told at once about alarms, and what is gathered for them.

A thousand robots that lose their network are one piece of news. The first few are told at once,
as nobody knows yet that more will come; what comes beyond them waits for the end of the window.
"""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.robot.alert_config import CIRCLES, RecipientCircle
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.authoriser.authoriser import Authoriser
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.alerts.active_alerts import ActiveAlert
    from rosic.organiser.organiser import Organiser


# ---- what one person is told ----

WINDOW_NS: Final = 5 * SECOND_NS
ALONE: Final = 3
"""So many are told one by one before the others of their window are gathered."""


class NewsKind(enum.Enum):
    """What kind of news it is; each is gathered into a message of its own, in this order."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    ALARM = "alarm"
    SEEN = "seen"
    OVER = "over"
    NOTE = "note"
    """What a rule let its robot do, or could not."""


class AlertNews(NamedTuple):
    """One piece of news about one rule.

    Attributes:
        text: As it is told alone.
        occurrence: Which alarm; None: not to be acknowledged.
        by: Who has seen it, for news of that.
    """

    sort: NewsKind
    rule: AlertRule
    text: str
    occurrence: ActiveAlert | None = None
    by: str = ""


class _Window:
    """The news that one person is to be told together.

    Attributes:
        kept: The newest of each sort and rule, in the order in which they came.
    """

    __slots__ = ("ends_ns", "kept", "left")

    def __init__(self, ends_ns: int, left: int) -> None:
        self.ends_ns = ends_ns
        self.left = left
        self.kept: dict[tuple[NewsKind, str], AlertNews] = {}


class AlertGrouping:
    """Bounded by people and rules. Nothing is dropped: only the newest of a rule is kept."""

    def __init__(self) -> None:
        self._windows: dict[PrincipalId, _Window] = {}

    def alone(self, who: PrincipalId, news: AlertNews, now_ns: int) -> bool:
        """Whether it is to be told at once; else it is kept until the window ends.

        Once something is kept nothing is told alone before it, so all is told in order.
        """
        window = self._windows.get(who)
        if window is None:
            window = self._windows[who] = _Window(now_ns + WINDOW_NS, ALONE)
        if window.left > 0:
            window.left -= 1
            return True
        key = news.sort, news.rule.key
        window.kept.pop(key, None)
        window.kept[key] = news
        return False

    def due(self, now_ns: int) -> Iterator[tuple[PrincipalId, list[AlertNews]]]:
        """Yield what was gathered in windows that have ended; each once.

        A window in which something was gathered is followed by another, in which nothing is told
        alone: a storm goes on as one message a window.
        """
        if not self._windows:
            return
        for who, window in list(self._windows.items()):
            if now_ns < window.ends_ns:
                continue
            del self._windows[who]
            if window.kept:
                self._windows[who] = _Window(now_ns + WINDOW_NS, 0)
                yield who, list(window.kept.values())

    def rest(self) -> Iterator[tuple[PrincipalId, list[AlertNews]]]:
        """Yield what is kept, whether its window has ended or not: nothing is told later."""
        windows, self._windows = self._windows, {}
        for who, window in windows.items():
            if window.kept:
                yield who, list(window.kept.values())


# ---- who is told ----


class Recipients:
    """Finds people around a robot. Walks everybody: an alarm is rare, and its circle is not kept.

    Only those are found who may see the robot now, whose key is good and who are not locked.
    """

    def __init__(self, authoriser: Authoriser, organiser: Organiser) -> None:
        self._authoriser = authoriser
        self._organiser = organiser
        self._belongs: dict[RecipientCircle, Callable[[PrincipalId, RobotId], bool]] = {
            RecipientCircle.HOLDER: lambda who, robot: organiser.whose(robot) == who,
            RecipientCircle.OPERATORS: self.may_acknowledge,
            RecipientCircle.ADMINS: self._gives,
        }

    def of(self, robot: RobotId, first: RecipientCircle, level: int) -> tuple[PrincipalId, ...]:
        """Return whom to tell after so many escalations; where nobody is, the next circle."""
        start = CIRCLES.index(first) + level
        for circle in CIRCLES[min(start, len(CIRCLES) - 1) :]:
            found = tuple(self._within(robot, circle))
            if found:
                return found
        return ()

    def _within(self, robot: RobotId, circle: RecipientCircle) -> Iterator[PrincipalId]:
        belongs = self._belongs[circle]
        for person in self._authoriser.directory.people():
            if person.is_robot or person.is_program:
                continue
            if self.may_hear(person.id, robot) and belongs(person.id, robot):
                yield person.id

    def may_hear(self, who: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody may be told of a robot at all."""
        return (
            self._authoriser.has_access(who)
            and who not in self._organiser.locked
            and robot in self._organiser.visible(who)
        )

    def may_acknowledge(self, who: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody may say for everybody that an alarm was seen: who may operate it."""
        return self._organiser.why_not_move(who, robot) is None

    def _gives(self, who: PrincipalId, robot: RobotId) -> bool:
        rights, now_ns = self._organiser.rights, self._organiser.wall_ns()
        return rights.holds(who, FLEET, GRANT, now_ns) or rights.holds(who, robot, GRANT, now_ns)
