"""One rule as it is followed, and what it says of now."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.alerts.state import AlertWatch
from rosic.features.alerts import messages as words

if TYPE_CHECKING:
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.robot.profile import Presence
    from rosic.features.alerts.book import Alarm


class ActiveRule:
    """A rule, where it is, and the alarm it has raised.

    Attributes:
        alarm: What is open now; None: nobody was told of anything.
    """

    __slots__ = ("alarm", "rule", "watch")

    def __init__(self, rule: AlertRule) -> None:
        self.rule = rule
        self.watch = AlertWatch(rule.pace)
        self.alarm: Alarm | None = None

    def now(self, presence: Presence) -> str:
        """Return what is measured, as people read it."""
        return words.value(self.rule.condition, self.rule.condition.value(presence))

    @property
    def unseen(self) -> bool:
        """Whether it is open, and nobody has said that they saw it."""
        return self.watch.announced and self.alarm is not None and not self.alarm.by

    def called(self, named: str) -> bool:
        """Whether somebody means it: by its name, its beginning, or what it measures."""
        rule = self.rule
        return rule.alert.name.startswith(named) or rule.condition.name == named
