"""One line, read with a vocabulary, for one person."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.language.ast import (
    CommandLine,
    Do,
    Halt,
    Help,
    Line,
    LineContext,
    Misunderstood,
    Resume,
    Robots,
    Start,
    Status,
    Use,
)
from rosic.core.language.command import help_named
from rosic.core.language.compiled import CompiledRobot, CompiledSkill, NameTarget, merge
from rosic.core.language.keywords import (
    ALONG_ELSEWHERE,
    ARTICLES,
    BEFORE_NAMES,
    EVERYTHING,
    EVERYTHING_ELSEWHERE,
    IS_WORDS,
    NOTHING,
    POLITE,
    STATUS_WORDS,
)
from rosic.core.language.line_words import MOST_MENDED, past_excepting, past_fillers
from rosic.core.language.skill_values import fits
from rosic.core.language.stop_detection import hears_stop
from rosic.core.language.syntax_errors import SyntaxErrorBuilder
from rosic.core.language.values import AmbiguousNumber, ValueReader
from rosic.core.order import SpokenValue

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId


HELP_WORDS: Final = frozenset({"?", "help", "hilfe"})


# ---- reading one line ----

MOST_WORDS = 32
LONGEST_PAYLOAD = 64
CONTINUE = "continue"
ONE_CHOSEN: Final = said("One robot or one group is chosen at a time. Which one?")
NOBODY_LEFT: Final = Misunderstood(said("That leaves no robot. Nothing was done."), ("robots",))


class LineReader:
    """Reads one line; used once.

    Args:
        line: The line.
        words: Its words as typed, and in small letters.
        vocabulary: What can be said.
        context: Whom this person may see, and chose.
        mends: Whether to look for what may have been meant. Not in a line that is only tried
            because it may have been.

    Attributes:
        unsure: It read a command, and some of its values may not be what that takes.
    """

    __slots__ = (
        "_context",
        "_line",
        "_low",
        "_mends",
        "_raw",
        "_selected",
        "_visible",
        "_vocabulary",
        "unsure",
    )

    def __init__(
        self,
        line: str,
        words: tuple[list[str], list[str]],
        vocabulary: Vocabulary,
        context: LineContext,
        *,
        mends: bool,
    ) -> None:
        self._line = line
        self._raw, self._low = words
        self._vocabulary = vocabulary
        self._context = context
        self._mends = mends and len(self._low) <= MOST_MENDED
        self._visible = context.visible
        self._selected = context.selected
        self.unsure = False

    def read(self, *, slash: bool = False) -> Line:
        """Return what the line means.

        Args:
            slash: It began with a slash; never a text to speak to a robot.
        """
        line = self._meaning(slash=slash)
        if isinstance(line, Misunderstood):
            return self._halt() or line
        return line

    def _halt(self) -> Halt | None:
        names = hears_stop(self._line, self._vocabulary.known)
        return None if names is None else Halt(names)

    def _meaning(self, *, slash: bool) -> Line:
        at = self._past_fillers(0)
        if at == len(self._low):
            return self._trouble().nothing_said()
        callee, after = self._callee(at)
        if callee is not None:
            return self._addressed(callee, after)
        word, commands = self._low[at], self._vocabulary.commands
        ours = slash or word not in self._vocabulary.longest_skill
        if ours:
            word = commands.aliases.get(word, word)
        verb = LineReader.resume_all if self._everybody_resumes(at) else _VERBS.get(word)
        if verb is not None:
            return verb(self, None, at + 1)
        two = commands.pairs.get(tuple(self._low[at:])) if len(self._low) == at + 2 else None
        if two is not None:
            return CommandLine(two, "")
        if word in commands.words and ours:
            alone = self._asks_how(at + 1) and commands.explains(word)
            return CommandLine(word, "" if alone else self._rest(at + 1))
        status = self._status_asked(at) if ours else None
        return status or self._unaddressed(at, slash=slash)

    def _everybody_resumes(self, at: int) -> bool:
        """Whether it says ``all resume``: in German that is the order of words of the button."""
        word, *rest = self._low[at:]
        if len(rest) != 1 or not (word in EVERYTHING or word in EVERYTHING_ELSEWHERE):
            return False
        return self._vocabulary.commands.aliases.get(rest[0], rest[0]) == "resume"

    def _status_asked(self, at: int) -> Status | None:
        """Return what ``where is omni`` and ``battery omni`` ask; None where no robot is named."""
        if self._low[at] not in STATUS_WORDS:
            return None
        begin = at + 1 + any(word in IS_WORDS for word in self._low[at + 1 : at + 2])
        line = self.status(None, begin) if begin < len(self._low) else None
        return line if isinstance(line, Status) and line.robots else None

    # ---- whom ----

    def _past_fillers(self, at: int) -> int:
        return self._past(at, POLITE)

    def _to_name(self, at: int) -> int:
        return self._past(at, POLITE | BEFORE_NAMES)

    def _past(self, at: int, words: frozenset[str]) -> int:
        at = past_fillers(self._low, at)
        while at < len(self._low) and self._low[at] in words and not self._is_called(at):
            at = past_fillers(self._low, at + 1)
        return at

    def _is_called(self, at: int) -> bool:
        """Whether a robot, a group or a skill is called by the word that stands here."""
        word, vocabulary = self._low[at], self._vocabulary
        return word in vocabulary.longest_callee or word in vocabulary.longest_skill

    def _callee(self, at: int) -> tuple[NameTarget | None, int]:
        """Return the visible robot or group named here, and where its name ends."""
        low = self._low
        if at < len(low):
            longest = self._vocabulary.longest_callee.get(low[at], 0)
            for count in range(min(longest, len(low) - at), 0, -1):
                name = low[at] if count == 1 else " ".join(low[at : at + count])
                callee = self._vocabulary.callees.get(name)
                if callee is not None and (seen := self.seen(callee)) is not None:
                    return seen, at + count
        return None, at

    def seen(self, callee: NameTarget) -> NameTarget | None:
        """Return what the person may see of a robot or group; None for nothing."""
        visible = self._visible
        if not callee.group:
            return callee if callee.robots[0].id in visible else None
        robots = tuple([robot for robot in callee.robots if robot.id in visible])
        return NameTarget(callee.name, robots, group=True) if robots else None

    def chosen(self) -> NameTarget | None:
        """Return who is chosen, as far as this person may see."""
        callee = self._vocabulary.callees.get(self._selected)
        return self.seen(callee) if callee is not None else None

    def _everybody(self) -> tuple[RobotId, ...]:
        return tuple([r for r in self._vocabulary.profiles if r in self._visible])

    def _asks_how(self, at: int) -> bool:
        """Whether the rest of a command is the one word that asks how it is said."""
        last = len(self._low) == at + 1 and self._low[at] in HELP_WORDS
        return last and self._callee(at)[0] is None

    # ---- skills ----

    def _addressed(self, callee: NameTarget, at: int) -> Line:
        """Read what is asked of a robot or group that was named."""
        at = self._past_fillers(at)
        if at == len(self._low):
            return Help(callee.name)
        found = self._skill(callee, at)
        if found is not None:
            return self._do(callee, *found, named=True)
        word = self._vocabulary.commands.aliases.get(self._low[at], self._low[at])
        asked = word in STATUS_WORDS and at + 1 == len(self._low)
        verb = LineReader.status if asked else _VERBS.get(word)
        if verb is not None:
            return verb(self, callee, at + 1)
        if word == CONTINUE:
            return CommandLine(CONTINUE, " ".join((callee.name, self._rest(at + 1))).rstrip())
        if (speech := self._said(callee, at, named=True)) is not None:
            return speech
        return self._trouble().no_such_skill(callee, at)

    def _skill(
        self, callee: NameTarget, at: int
    ) -> tuple[tuple[CompiledRobot, ...], tuple[CompiledSkill, ...], int] | None:
        """Return who of a callee has the skill named here, their skills, and where it ends."""
        low = self._low
        robots = callee.robots
        word = low[at]
        if len(robots) == 1 and robots[0].longest.get(word) == 1:
            return robots, (robots[0].phrases[word],), at + 1
        for count in range(max([robot.longest.get(word, 0) for robot in robots]), 0, -1):
            phrase = word if count == 1 else " ".join(low[at : at + count])
            able = tuple([robot for robot in robots if phrase in robot.phrases])
            if able:
                return able, tuple([robot.phrases[phrase] for robot in able]), at + count
        return None

    def _do(
        self,
        callee: NameTarget,
        robots: tuple[CompiledRobot, ...],
        skills: tuple[CompiledSkill, ...],
        at: int,
        *,
        named: bool = False,
    ) -> Line:
        alone = len(skills) == 1
        skill = skills[0] if alone else merge(skills)
        if skill.text is not None:
            rest = self._rest(at)
            spoken: tuple[SpokenValue, ...] = (
                (SpokenValue(skill.text.name, None, rest),) if rest else ()
            )
        elif len(self._low) > MOST_WORDS:
            return self._trouble().too_many_words(MOST_WORDS)
        else:
            reader = ValueReader(self._raw, self._low, at, skill, self._vocabulary.units)
            try:
                spoken = reader.read()
                self.unsure = reader.unsure or self._low[0] in ARTICLES
            except AmbiguousNumber as doubt:
                return self._trouble().two_readings(callee, doubt.at, doubt.readings)
        return Do(
            robots=(robots[0].id,) if alone else tuple([robot.id for robot in robots]),
            skills=(skill.skill,) if alone else tuple([s.skill for s in skills]),
            spoken=spoken,
            text=self._line,
            group=callee.name if callee.group else "",
            named=named,
        )

    def _rest(self, at: int) -> str:
        """Return the line after its first ``at`` words, as it was typed."""
        parts = self._line.split(None, at)
        return parts[at] if at < len(parts) else ""

    def _said(self, callee: NameTarget, at: int, *, named: bool = False) -> Line | None:
        """Return the line as words to a robot, if it is one that can be spoken to."""
        robot = callee.robots[0]
        if callee.group or not robot.profile.link.dialogue:
            return None
        skill = robot.skills["say"]
        if skill.text is None:
            return None
        halt = self._halt()
        if halt is not None:
            return halt
        return Do(
            robots=(robot.id,),
            skills=(skill.skill,),
            spoken=(SpokenValue(skill.text.name, None, self._rest(at)),),
            text=self._line,
            named=named,
            speech=True,
        )

    def _unaddressed(self, at: int, *, slash: bool) -> Line:
        """Read a line that begins with no name: the skill first, or the name left out."""
        longest = self._vocabulary.longest_skill.get(self._low[at], 0)
        phrases = [
            (" ".join(self._low[at : at + count]), at + count) for count in range(longest, 0, -1)
        ]
        for phrase, after in phrases:
            callee, end = self._callee(self._past_fillers(after))
            if callee is not None:
                line = self._skill_first(callee, phrase, end)
                if line is not None:
                    return line
        chosen = self.chosen()
        line = self._to_chosen(chosen, at, slash=slash) if chosen is not None else None
        if line is not None:
            return line
        for phrase, after in phrases:
            line = self._unnamed(chosen, phrase, at, after)
            if line is not None:
                return line
        trouble = self._trouble()
        if chosen is not None:
            return trouble.no_such_skill(chosen, at, chosen=True)
        return trouble.nothing_known(at)

    def _skill_first(self, callee: NameTarget, phrase: str, end: int) -> Line | None:
        able = tuple([robot for robot in callee.robots if phrase in robot.phrases])
        if not able:
            return None
        skills = tuple([robot.phrases[phrase] for robot in able])
        line = self._do(callee, able, skills, end, named=True)
        # follow cf1 with cf2: who follows whom?
        names = self._vocabulary.callees
        self.unsure = self.unsure or any(word in names for word in self._low[end:])
        return line

    def _to_chosen(self, chosen: NameTarget, at: int, *, slash: bool) -> Line | None:
        found = self._skill(chosen, at)
        if found is not None:
            return self._do(chosen, *found)
        return None if slash else self._said(chosen, at)

    def _unnamed(self, chosen: NameTarget | None, phrase: str, at: int, after: int) -> Line | None:
        """Read a line without a name, for the only visible robot that can do it.

        If another robot is chosen, this one is offered only: it is not the one the person has in
        mind.
        """
        few, many = self._visible, self._vocabulary.having.get(phrase, frozenset())
        if len(few) > len(many):
            few, many = many, few
        able = [robot for robot in few if robot in many]
        if not able:
            return None
        if len(able) > 1 or chosen is not None:
            return self._trouble().which_robot(chosen, phrase, at, sorted(able))
        robot = self._vocabulary.robots[able[0]]
        return self._do(NameTarget(robot.id, (robot,)), (robot,), (robot.phrases[phrase],), after)

    # ---- verbs ----

    def status(self, callee: NameTarget | None, at: int) -> Line:
        """Read ``status`` and the names after it."""
        return self._several(callee, at, lambda robots, _, __: Status(robots))

    def resume(self, callee: NameTarget | None, at: int) -> Line:
        """Read ``resume`` and the names after it."""
        return self._several(callee, at, Resume)

    def resume_all(self, _: NameTarget | None, __: int) -> Line:
        """Read ``alle freigeben``."""
        return Resume(self._everybody(), False)

    def _several(
        self,
        callee: NameTarget | None,
        at: int,
        make: Callable[[tuple[RobotId, ...], bool, tuple[RobotId, ...]], Line],
    ) -> Line:
        """Read names to the end of the line: no word of it is left out, or it means nothing.

        ``all`` before a name belongs to it (``all crazyflies``); behind what leaves some out
        (``all but omni``) stand names only.
        """
        if len(self._low) > MOST_WORDS:
            return self._trouble().too_many_words(MOST_WORDS)
        before = (callee,) if callee is not None else ()
        meant, everybody, at = self._names(before, at, all_too=True)
        spared: dict[RobotId, None] = {}
        if (everybody or meant) and (end := past_excepting(self._low, at)):
            spared, _, after = self._names((), end, all_too=False)
            at = after if spared else at
        if at < len(self._low):
            return self._trouble().no_such_robot(at)
        named_one = bool(meant) and not everybody
        if everybody:
            meant = dict.fromkeys(self._everybody())
        elif not meant and (chosen := self.chosen()) is not None:
            meant = dict.fromkeys(robot.id for robot in chosen.robots)
        left = tuple([robot for robot in meant if robot not in spared])
        return make(left, named_one, tuple(spared)) if left or not spared else NOBODY_LEFT

    def _names(
        self, before: tuple[NameTarget, ...], at: int, *, all_too: bool
    ) -> tuple[dict[RobotId, None], bool, int]:
        """Return whom the words from here on name, whether that is all, and where names end."""
        meant = dict.fromkeys(robot.id for callee in before for robot in callee.robots)
        everybody = False
        while (at := self._to_name(at)) < len(self._low):
            word = self._low[at]
            named, after = self._callee(at)
            if named is not None:
                everybody = False
                meant.update(dict.fromkeys(robot.id for robot in named.robots))
            elif all_too and (word in EVERYTHING or word in EVERYTHING_ELSEWHERE):
                everybody, after = True, at + 1
            elif word in ALONG_ELSEWHERE:
                after = at + 1
            else:
                break
            at = after
        return meant, everybody, at

    def help(self, callee: NameTarget | None, at: int) -> Line:
        """Read ``help`` and the name after it."""
        at = self._to_name(at)
        if callee is not None or at == len(self._low):
            return Help(callee.name if callee is not None else "")
        named, _ = self._callee(at)
        if named is not None:
            return Help(named.name)
        found = help_named(self._low[at], self._vocabulary.commands)
        return found or self._trouble().no_such_robot(at)

    def robots(self, _: NameTarget | None, __: int) -> Line:
        """Read ``robots``."""
        return Robots()

    def use(self, callee: NameTarget | None, at: int) -> Line:
        """Read ``use`` and the name after it."""
        at = self._to_name(at)
        if callee is None and (at == len(self._low) or self._low[at] in NOTHING):
            return Use()
        named, at = (callee, at) if callee is not None else self._callee(at)
        if named is None:
            return self._trouble().no_such_robot(at)
        at = self._past_fillers(at)
        while at < len(self._low) and self._low[at] in ALONG_ELSEWHERE:
            at = self._past_fillers(at + 1)
        if at == len(self._low):
            return Use(named.name)
        other, _ = self._callee(at)
        if other is None:
            return self._trouble().no_such_robot(at)
        return Misunderstood(ONE_CHOSEN, (f"use {named.name}", f"use {other.name}"))

    def start(self, callee: NameTarget | None, at: int) -> Line:
        """Read ``start`` and the payload of an invitation; behind a robot's name stands none."""
        return Start("" if callee or at >= len(self._raw) else self._raw[at][:LONGEST_PAYLOAD])

    def _trouble(self) -> SyntaxErrorBuilder:
        words = (self._raw, self._low)
        reads = self._reads if self._mends else None
        return SyntaxErrorBuilder(words, self._vocabulary, self._visible, reads)

    def _reads(self, other: str) -> bool:
        """Whether another line, offered instead, would be read to its end."""
        raw = other.replace("=", " = ").split()
        low = [word.casefold() for word in raw]
        line = LineReader(other, (raw, low), self._vocabulary, self._context, mends=False).read()
        if not isinstance(line, Do):
            return not isinstance(line, Misunderstood)
        units = self._vocabulary.units
        for robot, skill in zip(line.robots, line.skills, strict=True):
            compiled = self._vocabulary.compiled_skill(robot, skill.id)
            if compiled is None or not fits(compiled, line.spoken, units):
                return False
        return True


_VERBS: dict[str, Callable[[LineReader, NameTarget | None, int], Line]] = {
    "help": LineReader.help,
    "resume": LineReader.resume,
    "robots": LineReader.robots,
    "start": LineReader.start,
    "status": LineReader.status,
    "use": LineReader.use,
}
