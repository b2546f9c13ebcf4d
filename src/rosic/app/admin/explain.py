"""What somebody may with one line, and why: every rule that was asked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.admin.naming import the_one
from rosic.core.identity import OPERATOR, Address, Caller
from rosic.core.language import (
    Do,
    Halt,
    LineContext,
    Misunderstood,
    Resume,
    Status,
    bind,
    clean,
    hears_stop,
    show,
    understand,
)
from rosic.core.policy.explain import PolicyTexts, explain
from rosic.core.policy.query import STOP, Allow, AuthContext
from rosic.core.policy.scope import READ, RESUME
from rosic.errors import NotUnderstood, Refusal
from rosic.gateway.limit_clamping import ArgumentClamping
from rosic.gateway.observed_state import RightsDecision

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.app.admin.api import AdminContext
    from rosic.core.identity import Principal
    from rosic.core.language import Line
    from rosic.core.policy.query import Decision
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument

NO_RULE = (
    "That asks nothing of a robot, so no rule is asked. Write what a robot shall do, for example: "
    "kuka1 home."
)


LOWERED = "What the line leaves open is lowered to their own limits."
MAY_NOT = " may not."


def says_no(text: str) -> bool:
    """Whether an explanation of one robot comes to a no: its verdict stands above the rules."""
    verdict = [line for line in text.splitlines() if not line.startswith(("ok  ", "no  "))]
    return any(MAY_NOT in line for line in verdict)


class Explainer:
    """Decides as if somebody had written a line in a private chat, and does nothing."""

    def __init__(self, books: AdminContext) -> None:
        self._books = books
        self._clamping = ArgumentClamping(books.vocabularies, books.organiser)

    def explained(self, name: str, line: str) -> tuple[RightsDecision, ...]:
        """Return the decision about each robot; see `RightsChecker`."""
        return tuple(RightsDecision(not says_no(text), text) for text in self.explain(name, line))

    def explain(self, name: str, line: str) -> tuple[str, ...]:
        """Return the decision about each robot, with its rules, as the command line shows it.

        Raises:
            NotUnderstood: Nobody of that name, or the line asks nothing of a robot.
        """
        person = the_one(self._books.authoriser.directory, name)
        said, hidden = self._understood(person, line)
        texts: list[str] = []
        if hidden:
            texts.append(f"To {clean(person.name)} there is no such robot; they are told so.")
        name = clean(person.name)
        said, lowered = self._as_admitted(person, said)
        for robot, skill, shown, arguments in self._asked(said, person):
            decision = self._decide(person, robot, skill, arguments)
            verdict = _verdict(decision, name)
            if isinstance(said, Do) and arguments is None:  # whatever the rules say
                verdict = f"{name}{MAY_NOT} The robot's own bounds refuse it, for everybody."
            rules = explain(decision, self._wording())
            texts.append("\n".join((shown, verdict, *lowered, *rules)))
        return tuple(texts)

    def _as_admitted(self, person: Principal, line: Line) -> tuple[Line, tuple[str, ...]]:
        """Return a line as it is admitted: what it leaves open is within their limits then."""
        if not isinstance(line, Do):
            return line, ()
        try:
            lowered, note = self._clamping.of(self._caller(person), line)
        except Refusal:
            return line, ()
        return lowered, (LOWERED,) if note else ()

    def _understood(self, person: Principal, line: str) -> tuple[Line, bool]:
        """Return what a line means to somebody, and whether they may not know of its robot."""
        books = self._books
        stopped = hears_stop(line, books.vocabulary.known)
        if stopped is not None:
            return Halt(stopped), False
        visible = books.organiser.visible(person.id)
        said = self._one(line, visible)
        if not isinstance(said, Misunderstood):
            return said, False
        # What they may not see does not exist for them; whoever looks after the place sees it.
        seen = self._one(line, frozenset(books.profiles))
        if isinstance(seen, Misunderstood):
            raise NotUnderstood(said.sentence)
        return seen, True

    def _one(self, line: str, visible: frozenset[RobotId]) -> Line:
        lines = understand(line, self._books.vocabulary, LineContext("", visible))
        if len(lines) > 1:
            raise NotUnderstood("Ask about one line at a time.")
        return lines[0]

    def _asked(
        self, line: Line, person: Principal
    ) -> Iterator[tuple[RobotId, str, str, Mapping[str, Argument] | None]]:
        books = self._books
        if isinstance(line, Do):
            for robot, skill in zip(line.robots, line.skills, strict=True):
                try:
                    values = bind(books.vocabulary, robot, skill, line.spoken, group=line.group)
                    shown = show(books.vocabulary, robot, skill, values)
                    yield robot, skill.id, f"{books.shown(robot)}: {shown}", values
                except Refusal as refusal:
                    yield robot, skill.id, f"{books.shown(robot)}: {skill.id}\n{refusal}", None
            return
        words = {Halt: STOP, Resume: RESUME, Status: READ}
        word = words.get(type(line))
        if word is None:
            raise NotUnderstood(NO_RULE)
        named = line.robots if isinstance(line, Resume | Status) else self._stopped(line)
        visible = books.organiser.visible(person.id)
        # Without a name it means what they see; who sees nothing is told so of every robot.
        meant = named or tuple(r for r in books.profiles if r in visible) or tuple(books.profiles)
        for robot in meant:
            yield robot, word, f"{books.shown(robot)}: {word}", None

    def _stopped(self, line: Line) -> tuple[RobotId, ...]:
        """Return the robots that a stop names; none if one is not known: that stops everything."""
        found: dict[RobotId, None] = {}
        for name in line.names if isinstance(line, Halt) else ():
            robot = self._books.vocabulary.robot(name)
            members = (robot.id,) if robot is not None else self._books.vocabulary.members(name)
            if not members:
                return ()
            found.update(dict.fromkeys(members))
        return tuple(found)

    def _decide(
        self,
        person: Principal,
        robot: RobotId,
        skill: str,
        arguments: Mapping[str, Argument] | None,
    ) -> Decision:
        books = self._books
        auth_context = AuthContext(channel=books.assurance_of(person))
        return books.organiser.decision(self._caller(person), robot, skill, arguments, auth_context)

    def _caller(self, person: Principal) -> Caller:
        key = self._books.authoriser.directory.key_of(person.id)
        address = person.addresses[0] if person.addresses else Address(OPERATOR, "")
        return Caller(person.id, person.name, address, "" if key is None else key.id, "")

    def _wording(self) -> PolicyTexts:
        books = self._books
        return PolicyTexts(person=books.name, robot=books.shown, time=books.moment)


def _verdict(decision: Decision, name: str) -> str:
    if not isinstance(decision, Allow):
        return f"{name}{MAY_NOT}"
    if decision.needs:
        return f"{name} may, once something has come first."
    return f"{name} may."
