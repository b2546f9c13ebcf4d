"""What programs may see and ask for, and the lines of the grammar that say it."""

from __future__ import annotations

from decimal import Decimal
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

from rosic.contracts.programs import OfferedSkill
from rosic.core.i18n import joined, said
from rosic.core.language import Do, LanguageReader
from rosic.core.language.common_names import shown_name
from rosic.core.language.sanitise import clean, quote
from rosic.core.order import FOREVER_NS, Request
from rosic.core.policy.query import AuthContext
from rosic.core.policy.roles import ASSURANCES, Assurance, StepRequired
from rosic.errors import NotUnderstood, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.authoriser.program_keys import ProgramKeys
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.order import SpokenValue
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.core.secret import Secret
    from rosic.gateway.components import Components

LETTERS_AT_MOST = 500
ASKING = frozenset((StepRequired.CONFIRMATION, StepRequired.SECOND_PERSON))


class CheckedOrder(NamedTuple):
    """What an order would come to.

    Attributes:
        words: How it reads: ``move, 0.50 m left``.
        arguments: In their declared units, with what was left out.
        needs: What would have to come first.
    """

    words: str
    arguments: dict[str, Argument]
    needs: tuple[str, ...]


class ProgramService:
    """Answers a messenger by which programs speak; see `contracts.programs.Programs`."""

    def __init__(self, rooms: Components, keys: ProgramKeys) -> None:
        self._rooms, self._keys = rooms, keys
        self._reader = LanguageReader(rooms.vocabularies)

    def identify(self, secret: Secret) -> Address:
        """Return the address of whoever shows a secret.

        Raises:
            Unrecognised: It is no secret of a good key.
        """
        return self._keys.identify(secret)

    def who(self, address: Address) -> tuple[PrincipalId, str]:
        """Return who speaks from an address.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        principal = self._who(address)
        return principal, self._rooms.authoriser.directory.name(principal)

    def robots(self, address: Address) -> Mapping[RobotId, str]:
        """Return what a program may see.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        visible = self._rooms.organiser.visible(self._who(address))
        profiles = self._rooms.profiles
        return {robot: profiles[robot].shown for robot in profiles if robot in visible}

    def skills(self, address: Address) -> Sequence[OfferedSkill]:
        """Return what a program may ask for.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        who, organiser = self._who(address), self._rooms.organiser
        found = []
        for robot, shown in self.robots(address).items():
            for skill, compiled in self._rooms.vocabulary.robots[robot].skills.items():
                if organiser.allows(who, robot, skill):
                    needs = organiser.rights.caution(robot, skill).needs
                    asks = not ASKING.isdisjoint(needs)
                    found.append(OfferedSkill(robot, shown, compiled.skill, asks))
        return found

    def line(
        self, address: Address, robot: RobotId, skill: str, values: Mapping[str, object]
    ) -> str:
        """Return the line that says an order, read once to see that it says just that.

        Raises:
            Unrecognised: Nobody is there any more.
            NotUnderstood: What is wrong with it.
        """
        visible = self._rooms.organiser.visible(self._who(address))
        vocabulary = self._rooms.vocabulary
        compiled = vocabulary.compiled_skill(robot, skill) if robot in visible else None
        if compiled is None:
            raise NotUnderstood(said("There is no such robot or skill here. Nothing was done."))
        given = _given(compiled, values)
        line = " ".join([robot, compiled.spoken, *(_word(p, v) for p, v in given)])
        read = self._reader.lines(line, "", visible)
        if len(read) != 1 or not _says(read[0], robot, skill, given):
            raise NotUnderstood(
                said("These values cannot be said in one line: {line}.", line=quote(line))
            )
        return line

    def check(self, address: Address, line: str, assurance: str) -> CheckedOrder:
        """Return what an order would come to, as `line` says it. Nothing is done or counted.

        Args:
            address: Of whoever would give it.
            line: As `line` returns it.
            assurance: What their conversation is worth.

        Raises:
            Refusal: It would be refused, and why.
        """
        rooms, who = self._rooms, self._who(address)
        caller = rooms.authoriser.stand_for(who)
        [read] = self._reader.lines(line, "", rooms.organiser.visible(who))
        assert isinstance(read, Do)  # noqa: S101 - it was read so when the line was made
        request = Request(
            b"",
            read.robots[0],
            read.skills[0],
            read.spoken,
            read.text,
            0,
            0,
            FOREVER_NS,
            FOREVER_NS,
        )
        found = rooms.container.complete(request)
        worth = ASSURANCES.get(assurance, Assurance.PROVIDER_READABLE)
        context = AuthContext(channel=worth)
        allowed = rooms.organiser.check(caller, request, found.arguments, context)
        rooms.linker.check_free(request.robot)
        needs = tuple(sorted(need.value for need in allowed.needs))
        skill = request.skill.id
        arguments = rooms.vocabulary.declared(request.robot, skill, found.arguments)
        return CheckedOrder(found.words, arguments, needs)

    def _who(self, address: Address) -> PrincipalId:
        found = self._rooms.authoriser.directory.at(address)
        if found is None:
            raise Unrecognised(said("Nobody is known here by that key."))
        return found[0].id


def _given(
    compiled: CompiledSkill, values: Mapping[str, object]
) -> list[tuple[CompiledParameter, float | str]]:
    """Return every value that was given, of its parameter's kind.

    Raises:
        NotUnderstood: One is unknown, missing, or of another kind.
    """
    names = {parameter.name for parameter in compiled.parameters}
    for name in values:
        if name not in names:
            known = joined(", ", map(shown_name, sorted(names))) or "-"
            raise NotUnderstood(
                said(
                    "There is no parameter {name} there. There are: {known}.",
                    name=quote(name),
                    known=known,
                )
            )
    given: list[tuple[CompiledParameter, float | str]] = []
    for parameter in compiled.parameters:
        value = values.get(parameter.name)
        if value is not None:
            given.append((parameter, _checked(parameter, value)))
        elif parameter.default is None:
            name = shown_name(parameter.name)
            raise NotUnderstood(said("{name} has to be said, too.", name=name))
    return given


def _checked(parameter: CompiledParameter, value: object) -> float | str:
    name, shown = shown_name(parameter.name), quote(str(value)[:LETTERS_AT_MOST])
    if parameter.is_number:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not isfinite(float(value)):  # type: ignore[arg-type]  # a number by then
            raise NotUnderstood(said("{name}: {value} is no such number.", name=name, value=shown))
        return float(value)  # type: ignore[arg-type]  # likewise
    if parameter.words is not None:
        choices = dict.fromkeys(parameter.words.values())
        if value not in choices:
            raise NotUnderstood(
                said(
                    "{name} is one of {choices}.",
                    name=name,
                    choices=joined(", ", map(shown_name, choices)),
                )
            )
        return str(value)
    text = clean(value).strip() if isinstance(value, str) else ""
    if not text or text != value or len(text) > LETTERS_AT_MOST:
        raise NotUnderstood(
            said(
                "{name} is one line of text, of at most {most} letters.",
                name=name,
                most=LETTERS_AT_MOST,
            )
        )
    return text


def _word(parameter: CompiledParameter, value: float | str) -> str:
    if isinstance(value, float):
        return f"{parameter.name}={Decimal(repr(value)):f}"
    return value if parameter.text else f"{parameter.name}={value}"


def _says(
    line: object,
    robot: RobotId,
    skill: str,
    given: Sequence[tuple[CompiledParameter, float | str]],
) -> bool:
    """Whether a line was read as an order of one robot, with just these values."""
    if not isinstance(line, Do) or line.robots != (robot,) or line.skills[0].id != skill:
        return False
    return len(line.spoken) == len(given) and all(
        _is(spoken, parameter, value)
        for spoken, (parameter, value) in zip(line.spoken, given, strict=True)
    )


def _is(spoken: SpokenValue, parameter: CompiledParameter, value: float | str) -> bool:
    if spoken.name != parameter.name:
        return False
    if isinstance(value, float):
        return spoken.number == value and not spoken.word
    read = spoken.word if parameter.words is None else parameter.words.get(spoken.word)
    return spoken.number is None and read == value
