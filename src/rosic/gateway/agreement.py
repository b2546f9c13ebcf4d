"""What a tap agrees to: an act as it was resolved and shown, not the words on a button (I16).

A button that lets a robot do something carries a digest of what it would do when it was shown:
which robots, which skills, with which values in SI, under which rules. At the tap the words are
read once more; whatever comes out otherwise is not done.
"""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.identity import DIGEST_BYTES
from rosic.core.language import CommandLine, Do, live_words
from rosic.core.messages import NAMED_AT_MOST
from rosic.core.order import Request
from rosic.errors import Expired, Refusal
from rosic.gateway.order_label import label_of
from rosic.gateway.replies import ASK_FIRST, MARKS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.language import LanguageReader, Line
    from rosic.core.message import Button, Chat
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.gateway.components import Components
    from rosic.gateway.limit_clamping import LimitClamping

TOGETHER: Final = frozenset({"together", "broadcast"})
TASKS: Final = frozenset({"task", "mission"})
JOINED: Final = "+"
LIVE: Final = "live"


class ActPart(NamedTuple):
    """What one robot would do.

    Attributes:
        arguments: SI; nobody changes them.
        words: How it reads: ``move, 0.50 m left``.
    """

    robot: RobotId
    skill: str
    arguments: dict[str, Argument]
    words: str


class TaskSteps(NamedTuple):
    """What a task or a mission, as typed, lets robots do for somebody.

    Attributes:
        read: Each step of each robot that was looked at.
        unread: Robots that were not: a task for many is not read for all of them in one step.
    """

    read: Sequence[Do]
    unread: Sequence[RobotId] = ()


class ResolvedAct(NamedTuple):
    """What some words come to, for one person, now.

    Attributes:
        command: The words, with the name of whom they are for.
        shown: Robots and values, for whoever is to agree.
        parts: Of each robot.
        digest: Of all of it, and of the rules under which it was resolved.
        live: Its values are to be steered.
    """

    command: str
    shown: str
    parts: tuple[ActPart, ...]
    digest: bytes
    live: bool = False


class Agreements:
    """Binds buttons to what they would do, and sees at the tap that it is still the same.

    Args:
        rooms: The four of them.
        reader: What a text says.
        clamping: Keeps what nobody said within somebody's limits.
        task_steps: Returns what a task or a mission, as typed, lets robots do for somebody.
    """

    def __init__(
        self,
        rooms: Components,
        reader: LanguageReader,
        clamping: LimitClamping,
        task_steps: Callable[[str, str, PrincipalId], TaskSteps],
    ) -> None:
        self._rooms = rooms
        self._task_steps = task_steps
        self._clamping = clamping
        self._reader = reader

    def of(self, line: Do, caller: Caller, *, live: bool = False) -> ResolvedAct:
        """Return what a line comes to now for somebody.

        Raises:
            NotUnderstood, OutOfBounds: It cannot be carried out as it was said.
        """
        parts = tuple(self._parts(line, caller))
        if live:
            each = zip(parts, line.skills, strict=True)
            parts = tuple(part._replace(words=live_words(skill)) for part, skill in each)
        digest = self._digest(parts, live=live)
        return ResolvedAct(self.named(line), self._shown(line.group, parts), parts, digest, live)

    def together(self, line: CommandLine, caller: Caller) -> str:
        """Return what a command to several robots comes to now; empty: to nothing."""
        parts = self._all((line,), caller) if line.verb in TOGETHER else ()
        name = line.rest.strip().partition(" ")[0]
        return self._shown("" if JOINED in name else name, parts) if parts else ""

    def bind(self, button: Button, caller: Caller, chat: Chat) -> Button:
        """Return a button bound to what it lets robots do for somebody in a chat, if anything.

        What it says names its robot from now on: that must not hang on what is chosen when it is
        tapped.
        """
        if button.act or button.command.startswith(ASK_FIRST):
            return button
        mark = button.command[:1] if button.command.startswith(MARKS) else ""
        command = button.command.removeprefix(mark)
        rooms = self._rooms
        lines = self._reader.lines(
            command,
            rooms.container.selected(caller.principal, chat),
            rooms.organiser.visible(caller.principal),
        )
        parts = self._all(lines, caller)
        if not parts:
            return button
        first = lines[0]
        named = self.named(first) if len(lines) == 1 and isinstance(first, Do) else command
        plain = button.label == command
        label = label_of(named, rooms.vocabulary) if plain else button.label
        return replace(button, label=label, command=f"{mark}{named}", act=self._digest(parts))

    def check(
        self, caller: Caller, lines: Sequence[Line], act: bytes, *, live: bool = False
    ) -> None:
        """See that what a tap says lets robots do exactly what it agreed to.

        What was agreed to be done with certain values is not steered, nor the other way round.

        Raises:
            Expired: It would be something else, or it was agreed to under other rules.
        """
        parts = self._all(lines, caller)
        if not parts:
            return  # no robot does anything because of it, or it is refused for what it says
        now = self._digest(parts, live=live)
        if now == act:
            return
        shown = self._shown("", parts)
        if now[:DIGEST_BYTES] == act[:DIGEST_BYTES]:
            raise Expired(
                said(
                    "The rules here have changed since you were asked: {act}. Nothing was done. "
                    "Say it again.",
                    act=shown,
                )
            )
        raise Expired(
            said(
                "This is not what was shown any more: now it would be {act}. Nothing was done. "
                "Say it again.",
                act=shown,
            )
        )

    def is_current(self, act: ResolvedAct, line: Do, caller: Caller) -> bool:
        """Whether a line comes to the same as before, under the same rules."""
        try:
            return self.of(line, caller, live=act.live).digest == act.digest
        except Refusal:
            return False

    def named(self, line: Do) -> str:
        """Return what was said with the name of whom it is for, if that was left out."""
        return self.named_for(line.name, line.text)

    def named_for(self, name: str, text: str) -> str:
        """Return what was said to a robot or a group with its name, if that was left out."""
        everybody = frozenset(self._rooms.profiles)
        found = self._reader.lines(text, "", everybody)
        whole = len(found) == 1 and (_is_for(found[0], name) or isinstance(found[0], CommandLine))
        return text if whole else f"{name} {text.lstrip('/')}"

    def make_good(self, refusal: Refusal, line: Line, caller: Caller, chat: Chat) -> None:
        """Let what a refusal offers be possible when it is tapped.

        It names whom it was for, whatever is chosen by then, and lies within somebody's limits.
        """
        offers = refusal.offers
        if not offers:
            return
        if isinstance(line, Do):
            named = self.named(line)
            offers = tuple(named if o == line.text else o for o in offers)
        selected = self._rooms.container.selected(caller.principal, chat)
        visible = self._rooms.organiser.visible(caller.principal)
        possible = self._clamping.offered(
            caller, offers, lambda offer: self._reader.lines(offer, selected, visible)
        )
        refusal.offering(possible)

    # ---- what it comes to ----

    def _all(self, lines: Sequence[Line], caller: Caller) -> tuple[ActPart, ...]:
        """Return what lines let robots do; nothing of one that is refused for what it says."""
        return tuple(part for line in lines for part in self._possible(line, caller))

    def _possible(self, line: Line, caller: Caller) -> tuple[ActPart, ...]:
        try:
            return tuple(self._parts(line, caller))
        except Refusal:
            return ()

    def _parts(self, line: Line, caller: Caller) -> Iterator[ActPart]:
        if isinstance(line, CommandLine) and line.verb in TOGETHER:
            yield from self._together(line, caller)
        elif isinstance(line, CommandLine) and line.verb in TASKS:
            steps = self._task_steps(line.verb, line.rest, caller.principal)
            for step in steps.read:
                yield from self._possible(step, caller)
            for robot in steps.unread:
                yield ActPart(robot, "", {}, "")
        elif isinstance(line, Do):
            line, _ = self._clamping.of(caller, line)
            for robot, skill in zip(line.robots, line.skills, strict=True):
                asked = Request(b"", robot, skill, line.spoken, line.text, 0, 0, 0, 0, line.group)
                values = self._rooms.container.complete(asked)
                yield ActPart(robot, skill.id, values.arguments, values.words)

    def _together(self, line: CommandLine, caller: Caller) -> Iterator[ActPart]:
        """Yield what a command to several robots lets each of them do."""
        name, _, what = line.rest.strip().partition(" ")
        vocabulary = self._rooms.vocabulary
        for one in name.casefold().split(JOINED):
            members = (one,) if one in self._rooms.profiles else vocabulary.members(one)
            for robot in members:
                for step in self._reader.lines(what, robot, frozenset({robot})):
                    yield from self._possible(step, caller)

    def _digest(self, parts: Sequence[ActPart], *, live: bool = False) -> bytes:
        """Return what stands for an act: what is done, and the number of the rules."""
        profiles = self._rooms.profiles
        acts: list[object] = [LIVE] if live else []
        for part in parts:
            profile = profiles[part.robot]
            skill, values = profile.skills.get(part.skill), sorted(part.arguments.items())
            acts.append((part.robot, profile.shown, profile.link, skill, values))
        policy = self._rooms.organiser.rights.policy
        done = blake2b(repr(acts).encode("utf-8", "replace"), digest_size=DIGEST_BYTES).digest()
        return done + policy.to_bytes(8, "big")

    def _shown(self, group: str, parts: Sequence[ActPart]) -> str:
        """Return robots and values as people read them; of a robot that was not read, nothing."""
        parts = [part for part in parts if part.words] or parts
        names = [self._rooms.profiles[part.robot].shown for part in parts]
        if len({part.words for part in parts}) == 1 and len(parts) > 1:
            listed = ", ".join(names[:NAMED_AT_MOST]) + ", ..." * (len(names) > NAMED_AT_MOST)
            whom = f"{group} ({listed})" if group else listed
            return joined(": ", (whom, parts[0].words))
        each = [joined(": ", (name, part.words)) for name, part in zip(names, parts, strict=True)]
        left_out = ["..."] if len(each) > NAMED_AT_MOST else []
        return joined("; ", [*each[:NAMED_AT_MOST], *left_out])


def _is_for(line: Line, name: str) -> bool:
    """Whether a line says by itself whom it is for."""
    return isinstance(line, Do) and name == line.name
