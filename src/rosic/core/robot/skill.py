"""Skills: a robot's predefined movement functions, with typed and bounded parameters."""

from __future__ import annotations

import enum
import re
import unicodedata
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import msgspec

from rosic.core.i18n import titled
from rosic.core.robot.benchmark import Benchmark
from rosic.core.time_units import HOUR_S

if TYPE_CHECKING:
    from collections.abc import Mapping

Argument: TypeAlias = float | int | str
Meaning: TypeAlias = bool | float | str | tuple[float, ...]


class SkillClass(enum.Enum):
    """Decides lifetime, lease and limits."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    OBSERVE = "observe"
    TASK = "task"
    MOTION = "motion"
    CONFIG = "config"
    ADMIN = "admin"
    STOP = "stop"


# To look a member up in its class costs as much as three calls, and orders ask several times each.
MOTION = SkillClass.MOTION
STOP_SIGNS = frozenset("🛑✋⛔⏹🤚🖐🚫")
JOINER = "\u200d"
ICON_MOST = 8
LANGUAGE_CODE = re.compile(r"[a-z]{2,3}")
TITLE_MOST = 64
ACTUATING = frozenset((MOTION, SkillClass.TASK, SkillClass.CONFIG))

# The parameter that says how long a velocity is sent, in s.
DURATION = "duration"

# How long an order of a class may wait between being sent by the person and reaching the robot.
# docs/safety.md gives the reasons; a skill may set its own.
MOTION_LIFETIME_S = 5.0
LIFETIME_S = 30.0
LIFETIME_MAX_S = float(HOUR_S)
COST_MAX = 1_000.0
MOTION_LIFETIME_NS = int(MOTION_LIFETIME_S * 1e9)
LIFETIME_NS = int(LIFETIME_S * 1e9)


class Parameter(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One parameter of a skill: a bounded number, a choice, or (dialogue only) a text.

    Attributes:
        unit: How people give it when they name no unit, and how it is shown; any unit the units
            table knows. The value itself travels in SI. Empty for a plain number.
        min, max: Bounds in ``unit``, inclusive.
        integer: Only whole numbers.
        choices: Word to its other spellings. A parameter with choices is not a number.
        means: Choice to what it stands for, by name: numbers in SI (a place on the map, a pose of
            an arm), yes or no, a word of the robot's. A binding takes one as ``$place.x``.
        text: Takes the rest of the line as it is.
        default: In ``unit``, or one of the choices; None means it must be given.
        say: Choice to what else is said for it in a language, by its code:
            ``{ left: { de: [backbord] } }``.
        titles: Its title in other languages, by their code: ``{ de: Ausrichtung }``.
    """

    title: str = ""
    unit: str = ""
    min: float | None = None
    max: float | None = None
    integer: bool = False
    choices: dict[str, tuple[str, ...]] | None = None
    means: dict[str, dict[str, Meaning]] = {}
    text: bool = False
    default: float | str | None = None
    say: dict[str, dict[str, tuple[str, ...]]] = {}
    titles: dict[str, str] = {}

    def __post_init__(self) -> None:
        _check_titles(self.titles)
        _check_said(self.say, self.choices or {})
        if self.means:
            _check_meanings(self.means, self.choices or {})
        if self.choices is not None or self.text:
            if self.min is not None or self.max is not None or self.unit:
                raise ValueError("a choice or a text has no unit and no bounds")
            if self.choices is not None and self.default not in (None, *self.choices):
                raise ValueError("the default is not one of the choices")
            return
        if self.min is None or self.max is None:
            raise ValueError("a number needs min and max")
        if not (isfinite(self.min) and isfinite(self.max) and self.min <= self.max):
            raise ValueError("min and max must be finite, and min not above max")
        if self.default is not None and (
            isinstance(self.default, str) or not self.min <= self.default <= self.max
        ):
            raise ValueError("the default is not a number between min and max")


def _check_titles(titles: dict[str, str]) -> None:
    """See that titles are of languages.

    Raises:
        ValueError: They are not.
    """
    for code, title in titles.items():
        if not LANGUAGE_CODE.fullmatch(code) or not 1 <= len(title.strip()) <= TITLE_MOST:
            raise ValueError("titles has a language's code, as de, and a short title for each")


def _check_said(
    say: dict[str, dict[str, tuple[str, ...]]], choices: dict[str, tuple[str, ...]]
) -> None:
    """See that what is said in a language is said for a choice that there is.

    Raises:
        ValueError: It is not.
    """
    if not set(say) <= set(choices):
        raise ValueError("say must have the same words as choices")


def _check_meanings(
    means: dict[str, dict[str, Meaning]], choices: dict[str, tuple[str, ...]]
) -> None:
    """See that every choice stands for the same: finite numbers, words, yes or no.

    Raises:
        ValueError: One does not.
    """
    if set(means) != set(choices):
        raise ValueError("means and choices must have the same words")
    names = [set(meaning) for meaning in means.values()]
    if any(other != names[0] for other in names):
        raise ValueError("means must give the same numbers for every choice")
    for name in names[0] if names else ():
        if len({type(meaning[name]) for meaning in means.values()}) > 1:
            raise ValueError(f"means must give the same kind of {name!r} for every choice")
    for meaning in means.values():
        for value in meaning.values():
            numbers = value if isinstance(value, tuple) else (value,)
            if not all(isinstance(one, str) or isfinite(one) for one in numbers):
                raise ValueError("means must be finite numbers")


class Sent(NamedTuple):
    """What a binding sends.

    Attributes:
        place: Below the skill in its profile; empty: the profile does not say how it is carried
            out.
        values: By field: ``$name`` takes an argument, ``$name.x`` what a choice means; else it is
            literal.
        besides: Parameters that it heeds in another way.
        into: What takes it, in the words of people who write profiles.
        topic, type: What it is published to, and as what; empty where it is no topic.
        endpoint: The service or the action that it is sent to, by its name; ``type`` is of that
            then. Empty where it is neither.
    """

    place: tuple[str, ...] = ()
    values: Mapping[str, float | int | str | bool] = {}
    besides: tuple[str, ...] = ()
    into: str = ""
    topic: str = ""
    type: str = ""
    endpoint: str = ""


class Skill(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, dict=True):
    """One thing a robot can do, as its profile says. At most one binding.

    An adapter derives its own from it, with what carries a skill out: the binding.

    Attributes:
        id: Filled from the key in the profile.
        titles: Its title in other languages, by their code: ``{ de: Abheben }``.
        icon: One sign before its name on a button.
        kind: The class, ``class`` in the file.
        words: Other names people use for it.
        lifetime_s: Instead of the class's.
        to_safety: It brings the robot to safety, as landing does: accepted while the robot is busy,
            in place of what runs and of what waits.
        cost: How much of a rate limit it takes: of the person's, the robot's, the role's.
        benchmark: How long it should take, with how much of the battery, how exactly.
        say: What else is said for it in a language, by its code: ``{ de: [mähe] }``.
        reverse: What undoes it: another skill, or by parameter the choice that undoes each choice,
            ``{ direction: { left: right, right: left } }``. Proposed, never done by itself.
    """

    id: str = ""
    title: str = ""
    titles: dict[str, str] = {}
    icon: str = ""
    kind: SkillClass = msgspec.field(name="class", default=SkillClass.MOTION)
    words: tuple[str, ...] = ()
    parameters: dict[str, Parameter] = {}
    lifetime_s: float | None = None
    to_safety: bool = False
    cost: float = 1.0
    benchmark: Benchmark | None = None
    say: dict[str, tuple[str, ...]] = {}
    reverse: str | dict[str, dict[str, str]] = {}

    def __post_init__(self) -> None:
        if self.lifetime_s is not None and not 0 < self.lifetime_s <= LIFETIME_MAX_S:
            raise ValueError(f"lifetime_s must be above 0 and at most {LIFETIME_MAX_S:.0f}")
        if not 1 <= self.cost <= COST_MAX:
            raise ValueError(f"cost must be between 1 and {COST_MAX:g}")
        if self.icon and not is_icon(self.icon):
            raise ValueError("icon must be one sign, no letter or digit, and none that means stop")
        if self.kind is SkillClass.STOP:
            raise ValueError("stop is not a skill: every robot has one")
        _check_titles(self.titles)

    @property
    def shown(self) -> str:
        """What people read: its title, in their language where it has one."""
        return titled(self.title or self.id.replace("_", " "), self.titles)

    @property
    def doing(self) -> str:
        """What a robot at work is said to do."""
        return titled((self.title or self.id.replace("_", " ")).lower(), self.titles)

    def filled(
        self, value: Argument | bool, arguments: Mapping[str, Argument]
    ) -> Argument | Meaning | bool:
        """Return what a value of the binding stands for, whatever carries it out.

        Args:
            value: ``$name`` is the argument, ``$name.x`` what a choice means; else it is literal.
            arguments: Of an order, SI.
        """
        if not isinstance(value, str) or value[:1] != "$":
            return value
        name, dot, part = value[1:].partition(".")
        argument = arguments[name]
        return self.parameters[name].means[str(argument)][part] if dot else argument

    @property
    def sent(self) -> Sent:
        """What its binding sends to the robot; by itself a skill has none."""
        return Sent()

    @property
    def streams(self) -> bool:
        """Whether a velocity is sent again and again, for so long as `DURATION` says."""
        return False

    @property
    def unbound(self) -> Skill:
        """The same skill without what carries it out."""
        if type(self) is Skill:
            return self
        return Skill(**{name: getattr(self, name) for name in Skill.__struct_fields__})

    def sets(self, arguments: Mapping[str, Argument]) -> dict[str, float | int | str | bool]:
        """Return what is set on the robot once this is done: that it was done, with what.

        Args:
            arguments: Of an order, SI.
        """
        given = {f"{self.id}.{name}": value for name, value in arguments.items()}
        return {**given} or {self.id: True}

    @cached_property
    def order_lifetime_ns(self) -> int:
        """Nanoseconds from the person's sending to the robot's receiving."""
        if self.lifetime_s is not None:
            return int(self.lifetime_s * 1e9)
        return MOTION_LIFETIME_NS if self.kind is MOTION else LIFETIME_NS

    @cached_property
    def actuates(self) -> bool:
        """Whether it can change the world, so that it needs the robot for oneself."""
        return self.kind in ACTUATING


def is_icon(text: str) -> bool:
    """Whether a text is one sign that stands well on a button, and stops nothing."""
    signs = text.split(JOINER)
    return (
        len(text) <= ICON_MOST
        and STOP_SIGNS.isdisjoint(text)
        and all(unicodedata.category(sign[:1] or " ") == "So" for sign in signs)
        and all(unicodedata.category(rest) in {"Mn", "Sk"} for sign in signs for rest in sign[1:])
    )


# ---- strategy ----

# Strategies: named ways to do the same work, as a robot's profile declares them.


class Strategy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A named strategy.

    Attributes:
        parameters: What can be said of it: a speed cap, a spacing. What is left out takes its
            default; one without a default must be said.
    """

    title: str = ""
    parameters: dict[str, Parameter] = {}
