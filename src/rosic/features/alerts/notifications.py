"""Tells people of alarms: one by one while there are few, many of them in one message."""

from __future__ import annotations

from collections import OrderedDict
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.core.message import Button
from rosic.core.robot.alert_config import Severity
from rosic.core.time_units import DAY_S
from rosic.features.alerts import grouped_messages
from rosic.features.alerts import messages as words
from rosic.features.alerts.active_alerts import AlertMessageIndex, packed
from rosic.features.alerts.recipients import AlertGrouping, AlertNews, NewsKind
from rosic.gateway.delivery.notifier import Notification

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Record
    from rosic.features.alerts.active_alerts import ActiveAlert
    from rosic.features.alerts.recipients import Recipients
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier

    Write: TypeAlias = Callable[[Iterable[Record]], None]

BUTTONS_LIVE_S: Final = float(DAY_S)
LISTS_AT_MOST: Final = 256
MANY: Final = "many-"


class AlertNotifications:
    """Says it in private, to those who may see the robot when it is said.

    Attributes:
        placed: Which messages tell of which alarms.
    """

    def __init__(
        self, rooms: Components, reach: Notifier, clock: Clock, circles: Recipients, write: Write
    ) -> None:
        self.placed = AlertMessageIndex()
        self._write = write
        self._rooms = rooms
        self._reach = reach
        self._clock = clock
        self._circles = circles
        self._grouping = AlertGrouping()
        self._lists: OrderedDict[str, tuple[ActiveAlert, ...]] = OrderedDict()
        self._number = 0

    def tell(self, people: Iterable[PrincipalId], news: AlertNews) -> None:
        """Tell those of them who may see the robot: at once, or with what else there is."""
        now_ns = self._clock.monotonic_ns()
        hearing = [who for who in people if self._circles.may_hear(who, news.rule.robot)]
        at_once = [who for who in hearing if self._grouping.alone(who, news, now_ns)]
        if not at_once:
            return
        if news.occurrence is None:
            self._reach.tell(at_once, news.text, urgent=is_urgent(news.rule))
        else:
            self._alarm(at_once, news, news.occurrence)

    def look(self) -> None:
        """Tell what was gathered for everybody whose window has ended."""
        for who, gathered in self._grouping.due(self._clock.monotonic_ns()):
            self._gathered(who, gathered)

    def close(self) -> None:
        """Tell what was gathered, now."""
        for who, gathered in self._grouping.rest():
            self._gathered(who, gathered)

    def list_of(self, key: str) -> tuple[ActiveAlert, ...]:
        """Return which alarms a message of many told of; none if that is not known any more."""
        return self._lists.get(key, ())

    def buttons(self, rule: AlertRule) -> tuple[Button, ...]:
        """Return what whoever may operate the robot taps."""
        target = f"{rule.robot} {rule.alert.name}"
        return (Button(words.SEEN, f"/seen {target}"), Button(words.MUTE, f"/mute {target} 1h"))

    def shown(self, rule: AlertRule) -> str:
        """Return how people read the robot of a rule."""
        return self._rooms.profiles[rule.robot].shown

    # ---- one ----

    def _alarm(
        self, people: Sequence[PrincipalId], news: AlertNews, occurrence: ActiveAlert
    ) -> None:
        """Tell them of an alarm, and remember which messages say so: a reaction answers them."""
        robot = news.rule.robot
        for acts in (True, False):
            some = [w for w in people if self._circles.may_acknowledge(w, robot) is acts]
            buttons = self._row(news.rule, acts=acts)
            self._reach.give(some, self._notice(news.text, [news.rule], (occurrence,), buttons))

    def _row(self, rule: AlertRule, *, acts: bool) -> tuple[Button, ...]:
        """Return what is under an alarm for somebody who may act on it, or not."""
        status = Button(words.STATUS, f"/status {rule.robot}")
        return (*self.buttons(rule), status) if acts else (status,)

    def _notice(
        self,
        text: str,
        rules: Iterable[AlertRule],
        told: tuple[ActiveAlert, ...],
        buttons: tuple[Button, ...],
    ) -> Notification:
        return Notification(
            text=text,
            buttons=(buttons,),
            urgent=any(map(is_urgent, rules)),
            lifetime_s=BUTTONS_LIVE_S,
            still=True,
            landed=partial(self._landed, told),
            matter=packed(told),
        )

    def again(
        self, who: PrincipalId, meant: Sequence[tuple[AlertRule, ActiveAlert]]
    ) -> Notification:
        """Return what goes under alarms that a later run says again: those that are open still."""
        rules, told = [rule for rule, _ in meant], tuple(of for _, of in meant)
        if len(rules) > 1:
            return self._notice("", rules, told, self._row_of_many(who, rules, told))
        acts = self._circles.may_acknowledge(who, rules[0].robot)
        return self._notice("", rules, told, self._row(rules[0], acts=acts))

    # ---- many ----

    def _gathered(self, who: PrincipalId, gathered: Iterable[AlertNews]) -> None:
        sorts: dict[NewsKind, list[AlertNews]] = {}
        for news in gathered:
            if self._circles.may_hear(who, news.rule.robot):
                sorts.setdefault(news.sort, []).append(news)
        for sort in NewsKind:
            some = sorts.get(sort, [])
            if sort is NewsKind.ALARM and some:
                self._alarms(who, some)
            elif some:
                self._others(who, sort, some)

    def _alarms(self, who: PrincipalId, some: Sequence[AlertNews]) -> None:
        if len(some) == 1 and some[0].occurrence is not None:
            self._alarm((who,), some[0], some[0].occurrence)
            return
        rules = [news.rule for news in some]
        told = tuple(news.occurrence for news in some if news.occurrence is not None)
        text, row = grouped_messages.alarms(rules, self.shown), self._row_of_many(who, rules, told)
        self._reach.give((who,), self._notice(text, rules, told, row))

    def _row_of_many(
        self, who: PrincipalId, rules: Sequence[AlertRule], told: tuple[ActiveAlert, ...]
    ) -> tuple[Button, ...]:
        show = Button(grouped_messages.SHOW_ALL, "/alerts all")
        if any(self._circles.may_acknowledge(who, rule.robot) for rule in rules):
            return Button(grouped_messages.SEEN_ALL, f"/seen {self._listed(told)}"), show
        return (show,)

    def _landed(
        self, told: tuple[ActiveAlert, ...], messenger: Messenger, chat: Chat, message: str
    ) -> None:
        self._write(self.placed.note(told, messenger, chat, message))

    def _others(self, who: PrincipalId, sort: NewsKind, some: Sequence[AlertNews]) -> None:
        rules = [news.rule for news in some]
        text = some[0].text
        if len(some) > 1 and sort is NewsKind.SEEN:
            for name in dict.fromkeys(news.by for news in some):
                theirs = [news.rule for news in some if news.by == name]
                self._reach.tell((who,), grouped_messages.seen(name, theirs, self.shown))
            return
        if len(some) > 1:
            over = sort is NewsKind.OVER
            text = (
                grouped_messages.over(rules, self.shown)
                if over
                else grouped_messages.notes(some, self.shown)
            )
        self._reach.tell((who,), text, urgent=any(map(is_urgent, rules)))

    def _listed(self, told: tuple[ActiveAlert, ...]) -> str:
        """Remember which alarms a message tells of; return what its button calls them."""
        self._number += 1
        key = f"{MANY}{self._number}"
        self._lists[key] = told
        if len(self._lists) > LISTS_AT_MOST:
            self._lists.popitem(last=False)
        return key


def is_urgent(rule: AlertRule) -> bool:
    """Whether what a rule says overtakes what is not urgent."""
    return rule.alert.severity is Severity.CRITICAL
