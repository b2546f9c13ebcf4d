"""What people read about alarms."""

from __future__ import annotations

from math import floor
from typing import TYPE_CHECKING

from rosic.core.alerts.rule import OFF_BENCHMARK, PAUSE, REALLOCATE
from rosic.core.i18n import capital, joined, said
from rosic.core.language import clean, inert_text
from rosic.core.language.common_names import shown_name
from rosic.core.message import Button
from rosic.core.robot.alert_config import Severity
from rosic.core.robot.benchmark import DEVIATION, BenchmarkKind
from rosic.core.units import measured
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.alerts.condition import Condition
    from rosic.core.alerts.rule import AlertRule

SEEN = said("Seen")
MUTE = said("Mute 1 h")
STATUS = said("Status")
OFF = said("Off its benchmark")


def what(rule: AlertRule) -> str:
    """Return what a rule says when it is raised; the profile's own words, inert."""
    if rule.alert is OFF_BENCHMARK:
        return OFF
    value = rule.condition.name
    if not rule.alert.say and rule.alert.name == f"{value}_low":
        return capital(said("{value} low", value=shown_name(value)))
    return clean(rule.alert.say) or rule.alert.name.replace("_", " ").capitalize()


def value(condition: Condition, found: float | str | None) -> str:
    """Return a value as people read it: ``battery 18 %``; empty where there is none."""
    if found is None or not condition.name:
        return ""
    if condition.name == DEVIATION:
        return deviation(str(found))
    if isinstance(found, str):
        return joined(" ", (shown_name(condition.name), inert_text(found)[:80]))
    # Rounded down: what is below a fifth is never shown as a fifth.
    number = f"{floor(found * 10) / 10:g}" if condition.unit == "%" else f"{found:.2f}"
    text = f"{number} {condition.unit}".rstrip()
    return joined(" ", (shown_name(condition.name), measured(text, found, condition.unit)))


def deviation(kind: str) -> str:
    """Return in which way a robot is not as expected."""
    return {
        BenchmarkKind.LATE.value: said("it takes too long"),
        BenchmarkKind.ENERGY.value: said("it took more of the battery than expected"),
        BenchmarkKind.ERROR.value: said("it was less exact than expected"),
    }.get(kind, said("as expected"))


def raised(rule: AlertRule, shown: str, now: str, *, again: bool) -> str:
    """Return the first line of an alarm, and what is measured."""
    if rule.alert.severity is Severity.CRITICAL:
        first = said("ALARM · {robot}: {what}.", robot=shown, what=what(rule))
    else:
        first = said("{robot}: {what}.", robot=shown, what=what(rule))
    lines = [first]
    if again:
        lines.append(said("It is still so."))
    if now:
        lines.append(said("Now: {value}.", value=now))
    return joined("\n", lines)


def escalated(text: str, minutes: str) -> str:
    """Return an alarm that nobody has seen for so long."""
    return joined("\n", [text, said("Nobody has said in {time} that they saw it.", time=minutes)])


def cleared(rule: AlertRule, shown: str, now: str) -> str:
    """Return that an alarm is over."""
    over = said("{robot}: over: {what}.", robot=shown, what=what(rule))
    return joined("\n", [over, said("Now: {value}.", value=now)]) if now else over


def seen_by(rule: AlertRule, shown: str, name: str) -> str:
    """Return what the others read when somebody has seen it."""
    return said("{robot}: {what}: {name} has seen it.", robot=shown, what=what(rule), name=name)


def you_saw(lines: Sequence[str]) -> str:
    """Return what whoever has seen alarms reads."""
    return joined("\n", [said("Noted. I tell you when it is over:"), *lines])


def seen_before(shown: str, name: str) -> str:
    """Return that somebody else was faster."""
    return said("{robot}: {name} has seen it already.", robot=shown, name=name)


def none_open() -> str:
    """Return that all is well."""
    return said("No alarm is open.")


def nothing_to_see() -> str:
    """Return that no open alarm is meant."""
    return said("No alarm that nobody has seen is open.")


def one(rule: AlertRule, shown: str, now: str, seen: str) -> str:
    """Return one open alarm in the list."""
    line = said("{robot}: {what}", robot=shown, what=what(rule))
    rest = [part for part in (now, said("seen by {name}", name=seen) if seen else "") if part]
    return joined(" · ", [line, *rest])


def muted_line(rule: AlertRule, shown: str, name: str, until: str) -> str:
    """Return one muted rule in the list."""
    return said(
        "{robot}: {rule} is muted until {time}, by {name}.",
        robot=shown,
        rule=rule.alert.name,
        time=until,
        name=name,
    )


def muted(shown: str, rules: Sequence[AlertRule], until: str) -> str:
    """Return what whoever mutes reads."""
    names = ", ".join(rule.alert.name for rule in rules)
    return said(
        "{robot}: {rules} muted until {time}. Nobody is told of it, and it runs nothing.",
        robot=shown,
        rules=names,
        time=until,
    )


def was_muted(shown: str, rules: Sequence[AlertRule], name: str, until: str) -> str:
    """Return what the others read."""
    names = ", ".join(rule.alert.name for rule in rules)
    return said(
        "{robot}: {name} has muted {rules} until {time}.",
        robot=shown,
        name=name,
        rules=names,
        time=until,
    )


def unmuted(shown: str, rules: Sequence[AlertRule]) -> str:
    """Return that rules tell again."""
    names = ", ".join(rule.alert.name for rule in rules)
    return said("{robot}: {rules} tells again.", robot=shown, rules=names)


def how_to_mute() -> str:
    """Return how a mute is written."""
    return said("Write for example: /mute omni battery_low 1h")


def no_such_rule(named: str, names: Sequence[str]) -> str:
    """Return that a rule is not known."""
    return said(
        "There is no rule called {name}. There are: {names}.", name=named, names=", ".join(names)
    )


def no_rules(shown: str) -> str:
    """Return that a robot has none."""
    return said("{robot} has no rules about alarms.", robot=shown)


def may_not(shown: str) -> str:
    """Return that only who may operate a robot answers its alarms."""
    return said("Only who may operate {robot} answers its alarms, for all are told.", robot=shown)


def too_long(longest_s: int) -> str:
    """Return the bounds of a mute."""
    return said(
        "A rule is muted for a minute at least, and {most} at most.", most=length(longest_s)
    )


# ---- what a rule runs ----


def order_title(words: str, rule: AlertRule) -> str:
    """Return how an order of a rule reads: it names the rule."""
    return said("{order} · rule {rule}", order=words, rule=rule.alert.name)


def with_run(text: str, run: str, name: str) -> str:
    """Return an alarm, and what the robot is asked because of it."""
    asks = said("The rule asks it now, for {name}: {run}.", name=clean(name), run=clean(run))
    return joined("\n", [text, asks])


def fault() -> str:
    """Return that something broke here."""
    return said("Something went wrong here. It is not known what was done; please look.")


def not_run(rule: AlertRule, shown: str, why: str) -> str:
    """Return that a rule's order came to nothing."""
    return said(
        "{robot} was not asked to {run} by the rule {rule}: {why}",
        robot=shown,
        run=clean(rule.alert.run),
        rule=rule.alert.name,
        why=why,
    )


def acted(rule: AlertRule, shown: str) -> str:
    """Return what a rule has done that is no skill of its robot."""
    if rule.act == PAUSE:
        return said("{robot} was paused by the rule {rule}.", robot=shown, rule=rule.alert.name)
    if rule.act == REALLOCATE:
        return said(
            "The rule {rule} gave the task of {robot} to another.",
            robot=shown,
            rule=rule.alert.name,
        )
    return said("{robot} was stopped by the rule {rule}.", robot=shown, rule=rule.alert.name)


def reason(rule: AlertRule) -> str:
    """Return why somebody's time with a robot ends, as it stands in the outcome."""
    return said("the rule {rule} took it over", rule=rule.alert.name)


def paused(rule: AlertRule) -> str:
    """Return why what a robot did was cut short, as it stands in the outcome."""
    return said("the rule {rule} paused it", rule=rule.alert.name)


def not_at_rest(shown: str) -> str:
    """Return that a robot did not come to rest for a rule."""
    return said(
        "{robot} has not come to rest. It is stopped; look before you resume it.", robot=shown
    )


def stop_button(robot: str) -> tuple[tuple[Button, ...], ...]:
    """Return the row under an order of a rule; a stop is never bound to anybody."""
    return ((Button("STOP", f"stop {robot}", f"stop {robot}"),),)


def no_author(name: str) -> str:
    """Return that nobody stands for a rule."""
    return said(
        "{name}, in whose name it runs, has no access here now. An admin can change that.",
        name=name,
    )


def no_chat(name: str) -> str:
    """Return that the author of a rule could not be told what came of it."""
    return said("{name}, in whose name it runs, cannot be reached here.", name=name)


def too_soon(every: str) -> str:
    """Return that it ran just now."""
    return said("it runs at most once in {time}.", time=every)


def took_over(shown: str, name: str, rule: AlertRule) -> str:
    """Return what whoever has the robot reads before a rule takes it over."""
    return said(
        "{robot} is taken over now, by {name}'s rule {rule}.",
        robot=shown,
        name=name,
        rule=rule.alert.name,
    )
