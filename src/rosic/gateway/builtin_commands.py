"""Questions that move nothing: status, help, robots, use. And the menu they are answered with."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core import messages
from rosic.core.i18n import joined, said
from rosic.core.language import Answered, Help, Line, Start, Status, Use
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage, MenuEntry
from rosic.core.message import Button, Chat
from rosic.errors import RobotTaken
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply
from rosic.gateway.help_menu import HelpMenu
from rosic.gateway.replies import ASK_FIRST, PREVIOUS, TRAIL

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.command_builder import CommandBuilder
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.hooks import PipelineHooks
    from rosic.gateway.resume import ResumeHandler

COMMANDS: Final = (
    Command(
        name="undo",
        aliases=(
            "zurücknehmen",
            "rückgängig",
        ),
        typed=said("/undo"),
        summary=said("Take back the last choice of a robot"),
        help=HelpEntry(HelpPage.MOVE, 30, HelpNeed.MOTION),
        menu=MenuEntry(40),
    ),
    Command(
        name="again",
        aliases=("nochmal",),
        pairs=(("noch", "einmal"),),
        typed=said("/again"),
        summary=said("Do the last thing once more"),
        help=HelpEntry(HelpPage.MOVE, 10, HelpNeed.MOTION),
        menu=MenuEntry(80),
    ),
    Command(
        name="information",
        observes=True,
        summary="what a robot has said of itself (the paper's Algorithm 7)",
        pairs=(("request", "information"),),
    ),
    Command(
        name="cancel",
        aliases=("abbrechen",),
        typed=said("/cancel"),
        summary=said("End what you have under way"),
        help=HelpEntry(HelpPage.MOVE, 50, HelpNeed.MOTION),
        menu=MenuEntry(60, groups=True),
        hint="end what you have under way",
        of_robots=True,
    ),
    Command(
        name="abort",
        summary="the same as cancel",
    ),
    Command(
        name="take",
        summary="take a robot over, where the rules allow it: take over kuka1",
    ),
    Command(name="take over", phrase=lambda what: said("Take over {what}", what=what)),
    Command(
        name="end",
        summary="end one's own session with a robot",
    ),
)


# ---- earlier choices ----

PLACES_AT_MOST: Final = 10_000
STEPS_AT_MOST: Final = 8


class SelectionHistory:
    """Each person's way to their present choice. In memory: of an earlier run only the end is kept.

    Bounded: places where nobody has chosen for longest are forgotten first, and of each the oldest.
    """

    def __init__(self, at_most: int = PLACES_AT_MOST) -> None:
        self._at_most = at_most
        self._steps: OrderedDict[tuple[PrincipalId, str, str, str], tuple[str, ...]] = OrderedDict()

    def note(self, principal: PrincipalId, chat: Chat, name: str) -> None:
        """Somebody has just chosen anew where this was chosen; empty: nothing was."""
        key = _key(principal, chat)
        steps = (*self._steps.pop(key, ()), name)
        self._steps[key] = steps[-STEPS_AT_MOST:]
        if len(self._steps) > self._at_most:
            self._steps.popitem(last=False)

    def has(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether there is a choice to take back."""
        return _key(principal, chat) in self._steps

    def take(self, principal: PrincipalId, chat: Chat) -> str | None:
        """Return what was chosen before the last choice, and forget it; None if that is unknown."""
        key = _key(principal, chat)
        steps = self._steps.pop(key, ())
        if len(steps) > 1:
            self._steps[key] = steps[:-1]
        return steps[-1] if steps else None


def _key(principal: PrincipalId, chat: Chat) -> tuple[PrincipalId, str, str, str]:
    return principal, chat.platform, chat.id, chat.topic


# What stands between a robot and a skill in a link; platforms allow no dot there.
LINKED = "__"
WHICH = said("Which robot?")
NONE_CHOSEN = said("No robot is chosen now. Say its name with each command.")
NOT_THE_LAST = said("Something else was chosen here since. Nothing was changed.")
NOTHING_TO_UNDO = said(
    "There is no choice to take back here. What a robot has done is not undone by this."
)
NONE = "nothing"


POLITE: Final = {
    "hello": said("Hello."),
    "thanks": said("You are welcome."),
    "self": said(
        "I am ROSIC, a program: I pass on to robots what people may ask of them, and tell what the "
        "robots answer."
    ),
    "bye": said("Goodbye."),
    "never_mind": said("All right. Nothing was done."),
}


class BuiltinCommands:
    """Answers from memory; reads only what its asker may see (I11)."""

    def __init__(
        self,
        rooms: Components,
        choosing: CommandBuilder,
        hooks: PipelineHooks,
        resuming: ResumeHandler,
    ) -> None:
        self._hooks = hooks
        self._resuming = resuming
        self._organiser = rooms.organiser
        self._container = rooms.container
        self._linker = rooms.linker
        self._vocabularies = rooms.vocabularies
        self._stops = rooms.stops
        self._profiles = rooms.profiles
        self._choosing = choosing
        self._help_menu = HelpMenu(rooms, hooks.commands)
        self._earlier = SelectionHistory()
        hooks.commands.register("undo", self.undo)
        hooks.commands.register("again", self.again)
        hooks.commands.register("information", self.information)

    def answer(self, caller: Caller, chat: Chat, line: Line) -> Reply:
        """Answer a line that moves nothing."""
        visible = self._organiser.visible(caller.principal)
        if isinstance(line, Answered):
            return self._polite(caller.principal, line)
        if isinstance(line, Start):
            return self._linked(caller, chat, line, visible) or self._start(caller, visible)
        return (
            self._look(caller, chat, line, visible) if visible else Reply(messages.NOTHING_VISIBLE)
        )

    def _polite(self, principal: PrincipalId, line: Answered) -> Reply:
        """Answer what people say to each other; whoever greets is shown what to begin with."""
        text = POLITE.get(line.what, POLITE["never_mind"])
        if line.what not in {"hello", "self"}:
            return Reply(text)
        menu = self.menu(principal)
        return Reply(joined(" ", filter(None, (text, menu.text))), menu.buttons)

    def _look(self, caller: Caller, chat: Chat, line: Line, visible: frozenset[RobotId]) -> Reply:
        if isinstance(line, Status):
            return Reply(self._states(caller.principal, line.robots or sorted(visible)))
        if isinstance(line, Use):
            return self._use(caller, chat, line)
        if isinstance(line, Help):
            return self._help(caller, line.topic, visible)
        listed = [
            self._listed(caller.principal, robot)
            for robot in sorted(visible)[: messages.NAMED_AT_MOST]
        ]
        return Reply(joined("\n", (*listed, _which(visible))), self._robots(visible))

    def _help(self, caller: Caller, topic: str, visible: frozenset[RobotId]) -> Reply:
        principal = caller.principal
        members = [robot for robot in self.members(topic) if robot in visible]
        if not members:
            text, sections = self._help_menu.overview(principal, visible)
            page = self._help_menu.section(topic, principal, visible)
            return Reply(page or text, (*rows(sections), *self._robots(visible)))
        if members == [topic]:
            profile = self._profiles[topic]
            text = self._help_menu.of_robots(principal, (profile,))
            return Reply(text, self._skills(principal, profile), about=topic)
        text = self._help_menu.of_robots(principal, map(self._profiles.__getitem__, members))
        return Reply(text, self._robots(members), about=topic)

    def _linked(
        self, caller: Caller, chat: Chat, line: Start, visible: frozenset[RobotId]
    ) -> Reply | None:
        """Follow a link to a robot or to one of its skills: ``?start=omni``, ``omni__wave``.

        A link only asks; what it does not name well is no link.
        """
        robot, _, skill = line.payload.partition(LINKED)
        if robot not in visible:
            return None
        if not skill:
            return self._use(caller, chat, Use(robot))
        return self._choosing.ask(caller, f"{robot} {skill}", visible)

    def _start(self, caller: Caller, visible: frozenset[RobotId]) -> Reply:
        """Say whether somebody may command anything now, and with what they may begin."""
        organiser = self._organiser
        hindered = [organiser.not_now(caller.principal, robot) for robot in sorted(visible)]
        if visible and None in hindered:
            menu = self.menu(caller.principal)
            return Reply(joined(" ", (messages.MAY_COMMAND, menu.text)), menu.buttons)
        for refusal in hindered:
            if isinstance(refusal, RobotTaken):
                text = joined(" ", (messages.MAY_COMMAND_LATER, refusal.sentence))
                return Reply(text, self._robots(visible))
        why = next((refusal.sentence for refusal in hindered if refusal is not None), "")
        text = joined(" ", (messages.MAY_NOT_COMMAND, why or messages.NOTHING_VISIBLE))
        return Reply(text, self._robots(visible))

    async def information(self, asked: CommandContext) -> Reply:
        """Tell what there is to know, to whoever may read anything (Algorithm 7)."""
        principal = asked.caller.principal
        visible = self._organiser.visible(principal)
        if not visible:
            return Reply(messages.NO_INFORMATION)
        return Reply(joined("\n", (messages.INFORMATION, self._states(principal, sorted(visible)))))

    async def again(self, asked: CommandContext) -> Reply:
        """Ask whether the last command of somebody in this chat is to be done once more."""
        visible = self._organiser.visible(asked.caller.principal)
        return self._choosing.again(asked.caller, asked.inbound.chat, visible)

    def menu(self, principal: PrincipalId) -> Reply:
        """Return what somebody may begin with: robots; where there is only one, what it can do."""
        visible = self._organiser.visible(principal)
        if len(visible) != 1:
            return Reply(_which(visible), self._robots(visible)) if visible else Reply("")
        [robot] = visible
        skills = self._skills(principal, self._profiles[robot])
        what = said("What should {robot} do?", robot=self._profiles[robot].shown)
        return Reply(what if len(skills) > 1 else self._status(principal, robot), skills)

    def members(self, name: str) -> tuple[RobotId, ...]:
        """Return the robots that a choice means: one, a group's, or none."""
        return (name,) if name in self._profiles else self._vocabularies.current.members(name)

    def _states(self, reader: PrincipalId, robots: Sequence[RobotId]) -> str:
        lines = [self._status(reader, robot) for robot in robots[: messages.NAMED_AT_MOST]]
        if len(robots) > len(lines):
            more = len(robots) - len(lines)
            lines.append(said("and {count} more: say status and their names", count=more))
        return joined("\n", lines)

    def _status(self, reader: PrincipalId, robot: RobotId) -> str:
        holder, stopped_by = self._by(reader, robot)
        return messages.status_line(
            self._profiles[robot],
            self._linker.presence(robot),
            holder=holder,
            stopped_by=stopped_by,
            waiting=self._linker.waiting(robot),
        )

    def _listed(self, reader: PrincipalId, robot: RobotId) -> str:
        return messages.robot_line(
            self._profiles[robot], self._linker.presence(robot), *self._by(reader, robot)
        )

    def _by(self, reader: PrincipalId, robot: RobotId) -> tuple[str, str | None]:
        """Return by whom a robot is taken, and by whom it is stopped, as one of them may read."""
        holder, stopped, name_of = (
            self._organiser.whose(robot),
            self._stops[robot],
            self._organiser.name_of,
        )
        by = messages.by_whom(stopped.by, reader, name_of) if stopped.latched else None
        return messages.by_whom(holder or "", reader, name_of), by

    def _use(self, caller: Caller, chat: Chat, line: Use) -> Reply:
        before = self._chosen(caller.principal, chat)
        self._container.select(caller.principal, chat, line.name)
        if line.name != before:
            self._earlier.note(caller.principal, chat, before)
        return self._shown(caller, chat, line.name)

    def _chosen(self, principal: PrincipalId, chat: Chat) -> str:
        """Return what somebody chose here themselves; empty where only a usual one is meant."""
        container = self._container
        chosen = container.selected(principal, chat)
        here = container.here(chat) if chat.topic else ""
        meant_anyhow = here or container.usual.get(principal, "")
        return "" if chosen == meant_anyhow else chosen

    def _shown(self, caller: Caller, chat: Chat, name: str) -> Reply:
        """Return what is chosen now, what it can do, and the way back."""
        principal = caller.principal
        several = len(self._organiser.visible(principal)) > 1
        some = several and self._earlier.has(principal, chat)
        back = (Button(PREVIOUS, f"undo {name or NONE}"),) if some else ()
        if not name:
            return Reply(NONE_CHOSEN, (back,) if back else ())
        profile = self._profiles.get(name)
        if profile is None:
            text = said("{name}: chosen. Its name may be left out now.", name=name)
            return Reply(text, (back,) if back else ())
        text = said(
            "{status}\nIts name may be left out now.", status=self._status(principal, profile.id)
        )
        *above, last = self._skills(principal, profile)
        return Reply(text, (*above, (*last, *back)), about=profile.id)

    async def undo(self, asked: CommandContext) -> Reply:
        """Take the last choice of a robot in this chat back; nothing moves, nor is moved back.

        A button says which choice it takes back: if that is not the last one any more, it does
        nothing.
        """
        principal, chat = asked.caller.principal, asked.inbound.chat
        meant = asked.rest.strip()
        if meant and meant != (self._chosen(principal, chat) or NONE):
            return Reply(NOT_THE_LAST)
        visible = self._organiser.visible(principal)
        before = self._earlier.take(principal, chat)
        while before and visible.isdisjoint(self.members(before)):
            before = self._earlier.take(principal, chat)  # they may not see that one any more
        if before is None:
            return Reply(NOTHING_TO_UNDO, self._robots(visible))
        self._container.select(principal, chat, before)
        shown = self._shown(asked.caller, chat, before)
        # Nothing chosen: a step further back is the menu of robots.
        return shown if before else replace(shown, buttons=(*self._robots(visible), *shown.buttons))

    def _skills(self, principal: PrincipalId, profile: Profile) -> tuple[tuple[Button, ...], ...]:
        """Return what somebody may let a robot do, a button each, and a stop."""
        here = f"{TRAIL}use {profile.id}"
        buttons = [
            Button(messages.button_label(s), f"{ASK_FIRST}{profile.id} {messages.spoken(s)}{here}")
            for s in profile.skills.values()
            if self._organiser.allows(principal, profile.id, s.id)
            and not any(p.text for p in s.parameters.values())
        ]
        visible = self._organiser.visible(principal)
        favourites = self._choosing.favourites(principal, profile.id, visible)
        often = [Button(one.label, f"{one.command}{here}") for one in favourites]
        seen = self._hooks.view_buttons(profile.id)
        last = [Button("STOP", f"stop {profile.id}")]
        if len(visible) > 1:
            last.append(Button(said("Another robot"), "robots"))
        stopped = [profile.id] if self._resuming.may(principal, profile.id) else []
        resume = self._resuming.buttons(stopped)
        return (*resume, *((button,) for button in often), *rows(buttons), *rows(seen), tuple(last))

    def _robots(self, visible: Iterable[RobotId]) -> tuple[tuple[Button, ...], ...]:
        some = sorted(visible)[: messages.NAMED_AT_MOST]
        return rows([Button(self._profiles[r].shown, f"use {r}") for r in some])


def _which(visible: frozenset[RobotId]) -> str:
    if len(visible) <= messages.NAMED_AT_MOST:
        return WHICH
    return said(
        "Which robot? Say its name: these are {some} of {all}.",
        some=messages.NAMED_AT_MOST,
        all=len(visible),
    )
