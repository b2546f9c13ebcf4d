"""How somebody wants to be served: initializeOperator of the paper's Algorithm 2.

Language, units, the robot meant when none is chosen, a speed they never want to exceed, their time
zone. What was set is sealed in the person's own container; the record says in the open only that
somebody has settings.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.container import messages as words
from rosic.core.language.keywords import decimals_typed
from rosic.core.policy.limits import parse_limit
from rosic.core.records import Fact, Letter
from rosic.errors import NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.policy.limits import Convert
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Parameter, Skill

KIND: Final = "preference"
METRIC, IMPERIAL = "metric", "imperial"
SPEED: Final = "speed"
ON, OFF, TOLD = "on", "off", "told"
SPEEDS: Final = ("m/s", "rad/s")
SLOW: Final = 0.1  # of a skill's highest speed: while it is not known how slow somebody wants it
LONGEST: Final = 64

NOTHING: Final = frozenset(
    {"", "none", "off", "nothing", "default", "auto", "keiner", "keine", "keins", "aus", "nichts"}
)
UNITS: Final[Mapping[str, frozenset[str]]] = {
    METRIC: frozenset({METRIC, "metrisch", "si", "m", "metre", "metres", "meter", "meters"}),
    IMPERIAL: frozenset({IMPERIAL, "us", "ft", "foot", "feet", "inch", "inches", "fuß", "fuss"}),
}

Languages: TypeAlias = Mapping[str, tuple[str, ...]]
"""Code to the names of a language, the first one as it calls itself."""
ENGLISH: Final[Languages] = {"en": ("English",)}

log = logging.getLogger("rosic.container")


class Preferences(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What one person has set; empty: nothing of that kind.

    Attributes:
        language: A code: ``de``.
        units: ``metric`` or ``imperial``, for showing.
        robot: A robot or group, meant when none is chosen in a chat.
        speed: A limit as in ``core.limits``: ``speed <= 0.2 m/s``.
        zone: An IANA name.
        interpreter: Whether what is not understood may be shown to an interpreter: ``on``, ``off``,
            or ``told``: they were told of it, and have said neither.
    """

    language: str = ""
    units: str = ""
    robot: str = ""
    speed: str = ""
    zone: str = ""
    interpreter: str = ""


class _Since(msgspec.Struct, frozen=True):
    """The body of the fact: all that is said in the open. The key is the principal."""

    at_ns: int


UNSET: Final = Preferences()

_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(Preferences).decode


class SpeedLimits:
    """Turns one speed into the limits that it means for the robots here.

    What is no speed of that kind, an angle a second, is not touched by it: a limit in a unit that
    does not fit would forbid the skill altogether.
    """

    def __init__(self, skills: Mapping[RobotId, Mapping[str, Skill]], convert: Convert) -> None:
        self._skills = skills
        self._convert = convert

    def add_robot(self, robot: RobotId, skills: Mapping[str, Skill]) -> SpeedLimits:
        """Let a speed mean one more robot. Return what it means for that one alone."""
        self._skills = {**self._skills, robot: skills}
        return SpeedLimits({robot: skills}, self._convert)

    def texts(self, said: str) -> tuple[str, ...]:
        """Return the limits, one for each parameter that is such a speed, however it is called."""
        rule, bound = parse_limit(said), said.partition(" ")[2]
        if rule.high is None:
            return ()
        return tuple(
            f"{robot}:{skill} {name} {bound}"
            for robot, skill, name, parameter in self._numbers()
            if self._fits(rule.high, rule.unit, parameter)
        )

    def slowest(self) -> tuple[str, ...]:
        """Return limits that make everything with a speed slow, whatever its unit."""
        return tuple(
            f"{robot}:{skill} {name} <= {max(lowest, highest * SLOW):.12g} {one.unit}".rstrip()
            for robot, skill, name, one in self._numbers()
            if (name == SPEED or any(self._fits(1.0, unit, one) for unit in SPEEDS))
            and (lowest := one.min) is not None
            and (highest := one.max) is not None
        )

    def _numbers(self) -> Iterator[tuple[RobotId, str, str, Parameter]]:
        """Yield robot, skill, name and description of whatever is given as a number."""
        for robot, skills in self._skills.items():
            for skill in skills.values():
                for name, parameter in skill.parameters.items():
                    if parameter.max is not None:
                        yield robot, skill.id, name, parameter

    def _fits(self, number: float, unit: str, parameter: Parameter) -> bool:
        try:
            self._convert(number, unit, parameter)
        except ValueError:
            return False
        return True


class PreferenceBook:
    """Everybody's settings. What decides returns the fact to be written and changes nothing.

    Args:
        clock: Says when something was set.
        caps: Works out what a speed means.
        languages: What is spoken here.

    Attributes:
        usual: The robot or group that somebody means where they chose none; looked up for each
            line, so it is a mapping and no call.
    """

    def __init__(self, clock: Clock, caps: SpeedLimits, languages: Languages = ENGLISH) -> None:
        self.languages = languages
        self._clock = clock
        self._caps = caps
        self._set: dict[PrincipalId, Preferences] = {}
        self.usual: dict[PrincipalId, str] = {}
        self._limits: dict[PrincipalId, tuple[str, ...]] = {}
        self._damaged: set[PrincipalId] = set()

    # ---- asking: a look-up each ----

    def of(self, principal: PrincipalId) -> Preferences:
        """Return somebody's settings."""
        return self._set.get(principal, UNSET)

    def limits(self, principal: PrincipalId) -> tuple[str, ...]:
        """Return the limits that hold for everything somebody commands; texts for a grant."""
        return self._limits.get(principal, ())

    def damaged(self) -> tuple[PrincipalId, ...]:
        """Return whose settings cannot be read: they go slowly until they set a speed."""
        return tuple(self._damaged)

    # ---- deciding ----

    def set_language(self, principal: PrincipalId, said: str) -> tuple[Fact, ...]:
        """Decide on a language, by code or name.

        Raises:
            NotUnderstood: Not spoken here.
        """
        wanted = said.strip().casefold()
        for code, names in self.languages.items():
            if wanted in {code.casefold(), *(name.casefold() for name in names)}:
                return self._change(principal, language=code)
        spoken = [names[0] for names in self.languages.values()]
        offers = tuple(f"/language {code}" for code in self.languages)
        raise NotUnderstood(words.no_language(said, spoken), offers=offers)

    def set_units(self, principal: PrincipalId, said: str) -> tuple[Fact, ...]:
        """Decide on the units in which things are shown.

        Raises:
            NotUnderstood: Neither metric nor imperial.
        """
        for units, names in UNITS.items():
            if said.strip().casefold() in names:
                return self._change(principal, units=units)
        offers = (f"/settings units {METRIC}", f"/settings units {IMPERIAL}")
        raise NotUnderstood(words.WHICH_UNITS, offers=offers)

    def set_robot(
        self, principal: PrincipalId, said: str, choices: Iterable[str]
    ) -> tuple[Fact, ...]:
        """Decide on the robot that is meant when none is chosen; ``none`` undoes it.

        Args:
            principal: Whose setting it is.
            said: What they said.
            choices: Ids of the robots and names of the groups that they see.

        Raises:
            NotUnderstood: They see no such robot.
        """
        wanted = said.strip().casefold()
        if wanted in NOTHING:
            return self._change(principal, robot="")
        known = {name.casefold(): name for name in choices}
        if wanted not in known:
            offers = tuple(f"/settings robot {name}" for name in sorted(known.values())[:3])
            raise NotUnderstood(words.no_such_robot(said), offers=offers)
        return self._change(principal, robot=known[wanted])

    def set_speed(self, principal: PrincipalId, said: str) -> tuple[Fact, ...]:
        """Decide on a speed that nothing they command exceeds: ``0.2 m/s``; ``none`` undoes it.

        Raises:
            NotUnderstood: No speed, or one of no robot here.
            OutOfBounds: Not above 0.
        """
        wanted = said.strip().casefold()
        if wanted in NOTHING:
            return self._change(principal, speed="")
        try:
            rule = parse_limit(f"{SPEED} <= {decimals_typed(wanted)}")
        except ValueError:
            raise NotUnderstood(words.HOW_FAST) from None
        if not rule.unit:
            offered = rule.high is not None and rule.high > 0
            offers = (f"/settings speed {wanted} m/s",) if offered else ()
            raise NotUnderstood(words.HOW_FAST, offers=offers)
        if rule.high is None or rule.high <= 0:
            raise OutOfBounds(words.SPEED_NOT_POSITIVE)
        if not self._caps.texts(rule.said):
            raise NotUnderstood(words.no_robot_so_fast(rule.unit))
        return self._change(principal, speed=rule.said)

    def set_zone(
        self, principal: PrincipalId, said: str, name_of: Callable[[str], str]
    ) -> tuple[Fact, ...]:
        """Decide on a time zone; ``none`` means the place's.

        Args:
            principal: Whose setting it is.
            said: What they said.
            name_of: Returns the proper name of a zone, or raises a refusal.

        Raises:
            NotUnderstood: Nothing was said.
            Refusal: From ``name_of``.
        """
        wanted = said.strip()
        if not wanted:
            raise NotUnderstood(words.WHICH_ZONE)
        if wanted.casefold() in NOTHING:
            return self._change(principal, zone="")
        return self._change(principal, zone=name_of(wanted)[:LONGEST])

    def set_interpreter(self, principal: PrincipalId, state: str) -> tuple[Fact, ...]:
        """Decide whether an interpreter may be shown what is not understood.

        Args:
            principal: Whose setting it is.
            state: ``on``, ``off`` or ``told``.

        Raises:
            NotUnderstood: Their settings cannot be read.
        """
        return self._change(principal, interpreter=state)

    def unset(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes every setting of somebody back."""
        known = principal in self._set or principal in self._damaged
        return (_fact(principal, UNSET, 0),) if known else ()

    def _change(self, principal: PrincipalId, **what: str) -> tuple[Fact, ...]:
        if principal in self._damaged and SPEED not in what:
            offers = (f"/settings {SPEED} 0.2 m/s", f"/settings {SPEED} none")
            raise NotUnderstood(words.SETTINGS_DAMAGED, offers=offers)
        after = msgspec.structs.replace(self.of(principal), **what)
        return (_fact(principal, after, self._clock.wall_ns()),)

    # ---- what is so ----

    def add_robot(self, robot: RobotId, skills: Mapping[str, Skill]) -> tuple[PrincipalId, ...]:
        """Let the speed that people have set hold for one more robot; return for whom it does."""
        new = self._caps.add_robot(robot, skills)
        capped = {who: new.texts(kept.speed) for who, kept in self._set.items() if kept.speed}
        capped |= dict.fromkeys(self._damaged, new.slowest())
        for principal, limits in capped.items():
            if limits:
                self._limits[principal] = (*self.limits(principal), *limits)
        return tuple(principal for principal, limits in capped.items() if limits)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so.

        One that cannot be read may have held a highest speed: its owner goes slowly from now on,
        until they say how fast. Everything else is as if it was not set.
        """
        principal = fact.key
        self._set.pop(principal, None)
        self.usual.pop(principal, None)
        self._limits.pop(principal, None)
        self._damaged.discard(principal)
        if not fact.body:
            return  # taken back
        try:
            kept = _decode(b"" if fact.letter is None else fact.letter.content)
            limits = self._caps.texts(kept.speed) if kept.speed else ()
        except (msgspec.MsgspecError, ValueError):
            log.warning("somebody's settings cannot be read; they go slowly until they set them")
            self._damaged.add(principal)
            self._limits[principal] = self._caps.slowest()
            return
        self._set[principal] = kept
        if kept.robot:
            self.usual[principal] = kept.robot
        if limits:
            self._limits[principal] = limits


def _fact(principal: PrincipalId, kept: Preferences, at_ns: int) -> Fact:
    if kept == UNSET:
        return Fact(kind=KIND, key=principal, body=b"")
    letter = Letter(principal, _encode(kept))
    return Fact(kind=KIND, key=principal, body=_encode(_Since(at_ns)), letter=letter)
