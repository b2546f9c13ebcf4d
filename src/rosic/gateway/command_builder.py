"""Putting a command together by tapping: one question, asked anew with every tap.

The question carries its own state: each of its buttons says the whole command as it would be then.
So nothing is remembered here, and nothing can come between what is shown and what is done.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language import CommandLine, Do, Misunderstood, Proposed
from rosic.core.language.arguments import place
from rosic.core.language.formatting import beginning, show, show_choice, show_named, stepped
from rosic.core.language.phrase_reader import MEANT
from rosic.core.language.proposals import MOST_PROPOSED
from rosic.core.message import Button
from rosic.errors import NotUnderstood, Refusal
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import ASK_FIRST, CONFIRMED, DO_IT, LEAVE, LEAVE_IT, PREVIOUS, TRAIL

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from rosic.container.history import CommandHistory
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.language import LanguageReader, Line
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.gateway.agreement import Agreements
    from rosic.gateway.limit_clamping import LimitClamping
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.resume import ResumeHandler

SMALLER, LARGER = "−", "+"  # noqa: RUF001 - a minus sign is as wide as a plus
CHOSEN = "• "
OFTEN = "★"
# More rows than this do not fit beside the keyboard of a phone; such a skill is typed.
ROWS_AT_MOST = 6
# Of these, a row of choices holds as many as can be read.
CHOICES_AT_MOST = 12
STEPS_AT_MOST = 12


TASK = "task"
NOTHING_TO_DO = said("There is nothing to do again here yet.")


UNDO = "undo"


def follows_last(line: Line) -> bool:
    """Whether a line may mean something after the order before it: what is vague, or an undo."""
    if isinstance(line, CommandLine):
        return line.verb == UNDO and not line.rest.strip()
    return isinstance(line, Proposed) and bool(line.follows)


class CommandBuilder:
    """Asks before anything that was tapped moves a robot, and lets its values be changed first."""

    def __init__(
        self,
        reader: LanguageReader,
        command_history: CommandHistory,
        agreements: Agreements,
        clamping: LimitClamping,
        resuming: ResumeHandler,
    ) -> None:
        self._reader = reader
        self._agreements = agreements
        self._clamping = clamping
        self._command_history = command_history
        self._resuming = resuming

    def ask(
        self, caller: Caller, command: str, visible: frozenset[RobotId], selected: str = ""
    ) -> Reply:
        """Return the question whether a command is meant, with its values to step through.

        Args:
            caller: Who is asked: what is proposed stays within their limits.
            command: As typed; after `TRAIL`, from what it was changed, and the menu it came from.
            visible: What the person may see.
            selected: Who is meant where the command names nobody.

        Raises:
            NotUnderstood: The command means nothing any more, or needs a text that is to be typed.
            OutOfBounds: It holds a value that a robot does not allow.
        """
        command, *trail = command.split(TRAIL)
        line = self._reader.lines(command, selected, visible)[0]
        if isinstance(line, Misunderstood):
            raise NotUnderstood(line.sentence, offers=line.offers)
        if isinstance(line, CommandLine) and (several := self._agreements.together(line, caller)):
            return _question(several, command, (), trail)
        if isinstance(line, CommandLine) and line.verb == TASK and line.rest:
            return _question(said("Task: {task}", task=line.rest), command, (), trail)
        if not isinstance(line, Do):
            raise NotUnderstood(NOTHING_TO_DO)
        if line.group:
            said_whole = command if line.group in command.casefold() else f"{line.group} {command}"
            whole = _question(self._agreements.of(line, caller).shown, said_whole, (), trail)
            return self._warned(caller, line.robots, whole)
        vocabulary, robot = self._reader.vocabulary, line.robots[0]
        compiled, given = place(vocabulary, robot, line.skills[0], line.spoken)
        arguments: dict[str, Argument] = {}
        for parameter in compiled.parameters:
            value = given.get(parameter.name, beginning(parameter))
            if value is None:
                raise NotUnderstood(
                    said(
                        "Say what: {example} ...",
                        example=f"{robot} {compiled.spoken}",
                    )
                )
            arguments[parameter.name] = value
        arguments |= self._clamping.within(caller, robot, compiled, arguments, given)[0]
        shown = vocabulary.robots[robot].shown
        title = joined(": ", (shown, show(vocabulary, robot, line.skills[0], arguments)))
        within = partial(self._within, caller, robot, compiled, arguments)
        steppers = _steppers(robot, compiled, arguments, trail, within)
        question = _question(title, _command(robot, compiled, arguments), steppers, trail)
        return self._warned(caller, line.robots, question)

    def _within(
        self,
        caller: Caller,
        robot: RobotId,
        compiled: CompiledSkill,
        arguments: Mapping[str, Argument],
        parameter: CompiledParameter,
        value: float,
    ) -> float:
        """Return a value to step to, or what comes nearest to it within somebody's limits."""
        changed = {**arguments, parameter.name: value}
        return self._clamping.within(caller, robot, compiled, changed, ())[0].get(
            parameter.name, value
        )

    def _warned(self, caller: Caller, robots: Collection[RobotId], question: Reply) -> Reply:
        """Return a question, with who has stopped its robots before it."""
        stopped, resume = self._resuming.warning(caller.principal, robots)
        if not stopped:
            return question
        text = joined("\n", (stopped, question.text))
        return replace(question, text=text, buttons=(*resume, *question.buttons))

    def again(self, caller: Caller, chat: Chat, visible: frozenset[RobotId]) -> Reply:
        """Ask whether the last command of somebody in this chat is to be done again.

        Raises:
            NotUnderstood: There was none since the start.
        """
        last = self._command_history.last(caller.principal, chat)
        if last is None:
            raise NotUnderstood(NOTHING_TO_DO)
        return self.ask(caller, last[1], visible, last[0])

    def last(self, caller: Caller, chat: Chat, visible: frozenset[RobotId]) -> Do | None:
        """Return the last order that somebody gave in a chat; None: there was none."""
        last = self._command_history.last(caller.principal, chat)
        line = self._reader.lines(last[1], last[0], visible)[0] if last is not None else None
        return line if isinstance(line, Do) else None

    def goes_on(
        self, line: Line, message: MessageContext, visible: frozenset[RobotId], chosen: str
    ) -> Line:
        """Return a line with what it means after the last order of its author in a chat.

        Args:
            line: One that `follows_last`.
            message: That says it.
            visible: The robots that its author may see.
            chosen: Who is chosen there; a choice that came after the order is what an undo means.
        """
        undo = isinstance(line, CommandLine)
        offers = line.offers if isinstance(line, Proposed) else ()
        last = self.last(message.caller, message.inbound.chat, visible)
        if last is None or (undo and chosen not in {"", last.name}):
            return line
        found = self._reader.following(UNDO if undo else message.text, last, visible)
        others = [offer for offer in offers if offer not in {"help", *found}]
        return Proposed(MEANT, (*found, *others)[:MOST_PROPOSED]) if found else line

    def favourites(
        self, principal: PrincipalId, robot: RobotId, visible: frozenset[RobotId]
    ) -> list[Button]:
        """Return what somebody often asks of a robot, as buttons that ask whether it is meant."""
        vocabulary = self._reader.vocabulary
        found: dict[str, Button] = {}
        for said_before in self._command_history.favourites(principal, robot):
            line = self._reader.lines(said_before, robot, visible)[0]
            if isinstance(line, Do) and not line.group and line.robots == (robot,):
                try:
                    compiled, given = place(vocabulary, robot, line.skills[0], line.spoken)
                except Refusal:
                    continue  # the profile has changed since
                if not self._clamping.may(principal, robot, line.skills[0].id, given):
                    continue  # their rights have
                command = _command(robot, compiled, given)
                label = joined(" ", (OFTEN, show(vocabulary, robot, line.skills[0], given)))
                found.setdefault(command, Button(label, f"{ASK_FIRST}{command}"))
        return list(found.values())


def _question(
    title: str, command: str, steppers: tuple[tuple[Button, ...], ...], trail: Sequence[str]
) -> Reply:
    back = (Button(PREVIOUS, _backwards(trail)),) if trail else ()
    last = (Button(DO_IT, f"{CONFIRMED}{command}"), *back, Button(LEAVE_IT, LEAVE))
    return asks_first(joined("", (title, "?")), (*steppers, last))


def _backwards(trail: Sequence[str]) -> str:
    """Return what shows the step before: the question as it was, or the menu it came from."""
    return trail[0] if trail[0].startswith("use ") else f"{ASK_FIRST}{TRAIL.join(trail)}"


def _steppers(
    robot: RobotId,
    compiled: CompiledSkill,
    arguments: Mapping[str, Argument],
    trail: Sequence[str],
    within: Callable[[CompiledParameter, float], float],
) -> tuple[tuple[Button, ...], ...]:
    """Return a row for each number and some for each choice; none for what is better typed."""
    now = _command(robot, compiled, arguments)
    way = [now, *trail]
    if len(way) > STEPS_AT_MOST:
        way = [*way[: STEPS_AT_MOST - 1], way[-1]]  # the menu is found in the end all the same

    def becoming(parameter: CompiledParameter, value: Argument) -> str:
        command = _command(robot, compiled, {**arguments, parameter.name: value})
        return f"{ASK_FIRST}{TRAIL.join((command, *(trail if command == now else way)))}"

    steppers: list[tuple[Button, ...]] = []
    for parameter in compiled.parameters:
        value = arguments[parameter.name]
        if parameter.is_number:
            smaller, larger = stepped(parameter, float(value))
            label = show_named(compiled, parameter, value)
            steppers.append(
                (
                    Button(SMALLER, becoming(parameter, within(parameter, smaller))),
                    Button(label, becoming(parameter, value)),
                    Button(LARGER, becoming(parameter, within(parameter, larger))),
                )
            )
        elif parameter.words is not None:
            choices = list(dict.fromkeys(parameter.words.values()))
            if len(choices) in range(2, CHOICES_AT_MOST + 1):
                steppers.extend(
                    rows(
                        [
                            Button(
                                joined("", (CHOSEN * (choice == value), show_choice(choice))),
                                becoming(parameter, choice),
                            )
                            for choice in choices
                        ]
                    )
                )
    return tuple(steppers) if len(steppers) <= ROWS_AT_MOST else ()


def _command(robot: RobotId, compiled: CompiledSkill, arguments: Mapping[str, Argument]) -> str:
    """Return a command as it could be typed, every value by its name and in its declared unit."""
    values = [_value(p, arguments[p.name]) for p in compiled.parameters if p.name in arguments]
    return " ".join([robot, compiled.spoken, *values])


def _value(parameter: CompiledParameter, value: Argument) -> str:
    if not parameter.is_number:
        return f"{parameter.name}={value}"
    number = parameter.unit.from_si(float(value))
    return f"{parameter.name}={number:.10g}"
