"""What people read where many robots raise an alarm at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said, said_n
from rosic.core.robot.alert_config import Severity
from rosic.features.alerts.messages import what

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from rosic.core.alerts.rule import AlertRule
    from rosic.features.alerts.recipients import AlertNews

SEEN_ALL: Final = said("Seen, all of them")
SHOW_ALL: Final = said("Show all")
LINES_AT_MOST: Final = 8
NAMED: Final = 5
_RANK: Final = {Severity.CRITICAL: 0, Severity.WARNING: 1, Severity.INFO: 2}


def worst_first(rules: Iterable[AlertRule]) -> list[AlertRule]:
    """Return rules by how much they matter, otherwise as they came."""
    return sorted(rules, key=lambda rule: _RANK[rule.alert.severity])


def alarms(rules: Sequence[AlertRule], shown: Callable[[AlertRule], str]) -> str:
    """Return many alarms in one message."""
    head = said_n(
        "Alarms of one robot, the worst first:",
        "Alarms of {n} robots, the worst first:",
        _robots(rules),
    )
    return joined("\n", [head, *lines(rules, shown)])


def over(rules: Sequence[AlertRule], shown: Callable[[AlertRule], str]) -> str:
    """Return that many alarms are over."""
    head = said_n("Over at one robot:", "Over at {n} robots:", _robots(rules))
    return joined("\n", [head, *lines(rules, shown)])


def seen(name: str, rules: Sequence[AlertRule], shown: Callable[[AlertRule], str]) -> str:
    """Return what the others read when somebody has seen many."""
    head = said_n(
        "{name} has seen alarms of one robot:",
        "{name} has seen alarms of {n} robots:",
        _robots(rules),
        name=name,
    )
    return joined("\n", [head, *lines(rules, shown)])


def you_saw(rules: Sequence[AlertRule], shown: Callable[[AlertRule], str]) -> str:
    """Return what whoever has seen many reads."""
    head = said_n(
        "Noted, for one robot. I tell you when it is over:",
        "Noted, for {n} robots. I tell you when it is over:",
        _robots(rules),
    )
    return joined("\n", [head, *lines(rules, shown)])


def notes(news: Sequence[AlertNews], shown: Callable[[AlertRule], str]) -> str:
    """Return what came of many rules: some in full, the others by their robots' names."""
    first, rest = news[:LINES_AT_MOST], news[LINES_AT_MOST:]
    texts = [one.text for one in first]
    if rest:
        names = ", ".join(shown(one.rule) for one in rest)
        texts.append(said("The same, or the like, of: {robots}", robots=names))
    return joined("\n", texts)


def lines(
    rules: Iterable[AlertRule],
    shown: Callable[[AlertRule], str],
    *,
    named: int = NAMED,
    most: int = LINES_AT_MOST,
) -> list[str]:
    """Return one line for each thing that is wrong, with whom it is wrong with; the worst first."""
    groups: dict[tuple[Severity, str], list[str]] = {}
    for rule in worst_first(rules):
        groups.setdefault((rule.alert.severity, what(rule)), []).append(shown(rule))
    found = [_line(*about, robots, named) for about, robots in groups.items()]
    if len(found) > most:
        found[most:] = [said_n("and one more thing", "and {n} more things", len(found) - most)]
    return found


def _line(severity: Severity, text: str, robots: Sequence[str], named: int) -> str:
    names = ", ".join(robots[:named])
    left = len(robots) - named
    listed: str = names
    if left > 0:
        listed = said_n("{names} and one more", "{names} and {n} more", left, names=names)
    if severity is Severity.CRITICAL:
        return said("ALARM · {what}: {robots}", what=text, robots=listed)
    return said("{what}: {robots}", what=text, robots=listed)


def forgotten() -> str:
    """Return that a message of many alarms is not known any more."""
    return said("I do not know any more which alarms those were. Say /seen for all that are open.")


def _robots(rules: Iterable[AlertRule]) -> int:
    return len({rule.robot for rule in rules})
