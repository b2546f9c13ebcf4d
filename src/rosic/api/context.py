"""What the routes work with: the rooms, the messengers of the API, and orders as they happen."""

from __future__ import annotations

from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.api.schemas import (
    CheckOut,
    IdentityOut,
    OrderOut,
    PoseOut,
    PresenceOut,
    RobotOut,
    SkillOut,
    StageOut,
    moment,
)
from rosic.core.i18n import in_language, said
from rosic.core.identity import PAGE
from rosic.core.language.common_names import shown_name
from rosic.core.messages import parameter_label
from rosic.core.robot.skill_schema import schema_of
from rosic.core.robot.view import ViewKind
from rosic.errors import NotFound, NotPermitted, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.api.callers import ApiCaller, CallerDirectory
    from rosic.api.order_feed import OrderEntry, OrderFeed
    from rosic.api.page_messenger import PageMessenger
    from rosic.api.settings import ApiSettings
    from rosic.contracts.programs import OfferedSkill
    from rosic.core.message import Inbound
    from rosic.core.records import Fact
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.secret import Secret
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.feature import Kernel
    from rosic.gateway.programs import ProgramService
    from rosic.messengers.program.calls import ToolCall
    from rosic.messengers.program.messenger import ProgramMessenger

CALLS_AT_MOST: Final = 64
"""Of one caller at a time, waiting for an answer. A stop is not counted."""
LATE_AT_LEAST_S, LATE_SHARE = 1.2, 0.4
"""A robot is late after that share of its heartbeat: so a page says within 2 s that a link is cut,
though its robot counts as there for 3 s, as robots do by default."""
BUSY: Final = said("Too many calls at once. Wait for an answer first. Nothing was done.")
UNKNOWN_ROBOT: Final = said("There is no such robot here, as far as you may see.")
UNKNOWN_SKILL: Final = said("There is no such skill there that you may ask for.")
UNKNOWN_ORDER: Final = said("There is no such order here, or none any more.")


class ApiContext(NamedTuple):
    """What the routes work with.

    Attributes:
        program, page: The messengers by which programs and people speak.
        programs: What a caller may see and ask for.
        callers: Recognises whoever asks.
        feed: Orders as they happen.
    """

    kernel: Kernel
    settings: ApiSettings
    program: ProgramMessenger
    page: PageMessenger
    programs: ProgramService
    callers: CallerDirectory
    languages: ChatLanguages
    feed: OrderFeed

    # ---- speaking ----

    def messenger(self, caller: ApiCaller) -> ProgramMessenger:
        """Return the messenger by which somebody speaks."""
        return self.page if caller.address.platform == PAGE else self.program

    def begin(self, caller: ApiCaller, inbound: Inbound, robot: str = "") -> ToolCall:
        """Say something for a caller.

        Raises:
            TooManyRequests: They wait for too many answers already. Nothing was said.
            MessengerFault: Nobody listens. Nothing was said.
        """
        messenger = self.messenger(caller)
        if messenger.calls.count(caller.address) >= CALLS_AT_MOST:
            raise TooManyRequests(BUSY, retry_after_s=1.0)
        return messenger.begin(inbound, robot)

    def me(self, caller: ApiCaller) -> IdentityOut:
        """Return who a caller is."""
        person = self.kernel.rooms.authoriser.directory.person(caller.principal)
        kind = "person" if caller.address.platform == PAGE else "program"
        language = self.languages.code(caller.principal)
        named = [] if person is None else list(person.roles)
        organiser = self.kernel.rooms.organiser
        for grant in organiser.rights.grants(caller.principal):  # a key's roles are given to it
            if grant.role and (grant.expires_ns is None or organiser.wall_ns() < grant.expires_ns):
                named.append(grant.role)
        roles = tuple(dict.fromkeys(named))
        return IdentityOut(caller.principal, caller.name, kind, roles, language)

    async def write(self, facts: tuple[Fact, ...]) -> None:
        """Let facts be so, once they are on disk.

        Raises:
            RecordUnavailable: They cannot be written down. Nothing changed.
        """
        async with self.kernel.changes.turn() as turn:
            await turn.write(facts)

    async def begin_session(self, *facts: Fact) -> None:
        """Let a session begin; what is over goes.

        Raises:
            RecordUnavailable: It cannot be written down, so nobody is signed in by it.
        """
        await self.write(facts)
        self.kernel.changes.note(self.kernel.access.page_sessions.due())

    async def end_session(self, token: Secret) -> None:
        """End a session at once."""
        await self.kernel.changes.take_away(self.kernel.access.page_sessions.end(token))

    # ---- rights that are no order's ----

    def is_locked_out(self, caller: ApiCaller) -> bool:
        """Whether somebody is shut out for now: then there is nothing here for them."""
        return caller.principal in self.kernel.rooms.organiser.locked

    def holds(self, caller: ApiCaller, robot: str, right: str) -> bool:
        """Whether somebody has a right now."""
        organiser = self.kernel.rooms.organiser
        return not self.is_locked_out(caller) and organiser.rights.holds(
            caller.principal, robot, right, organiser.wall_ns()
        )

    def check_admin(self, caller: ApiCaller, sentence: str) -> None:
        """See that somebody looks after people here.

        Raises:
            NotPermitted: They do not, or are locked out; with this sentence.
        """
        if caller.principal not in self.kernel.admins() or self.is_locked_out(caller):
            raise NotPermitted(sentence)

    # ---- robots ----

    def visible(self, caller: ApiCaller) -> frozenset[RobotId]:
        """Return the robots that somebody may see; whoever is locked out sees none."""
        if self.is_locked_out(caller):
            return frozenset()
        return self.kernel.rooms.organiser.visible(caller.principal)

    def profile(self, caller: ApiCaller, robot: str) -> Profile:
        """Return a robot that somebody may see.

        Raises:
            NotFound: There is none of that name, as far as they may know.
        """
        profile = self.kernel.rooms.profiles.get(robot)
        if profile is None or robot not in self.visible(caller):
            raise NotFound(UNKNOWN_ROBOT)
        return profile

    def robots(self, caller: ApiCaller) -> list[RobotOut]:
        """Return the robots that somebody may see."""
        visible, profiles = self.visible(caller), self.kernel.rooms.profiles
        return [
            self.robot(profile, self._words(caller, profile))
            for robot, profile in profiles.items()
            if robot in visible
        ]

    def named_robot(self, caller: ApiCaller, robot: str) -> RobotOut:
        """Return a robot that somebody may see, with its words in their language.

        Raises:
            NotFound: There is none of that name, as far as they may know.
        """
        profile = self.profile(caller, robot)
        return self.robot(profile, self._words(caller, profile))

    def _words(self, caller: ApiCaller, profile: Profile) -> dict[str, str]:
        catalogue = self.languages.of(caller.principal)
        named = {name: shown_name(name) for name in profile.telemetry}
        named |= {skill.id: skill.doing for skill in profile.skills.values()}
        return {name: in_language(shown, catalogue) for name, shown in named.items()}

    def robot(self, profile: Profile, words: dict[str, str] | None = None) -> RobotOut:
        """Return a robot as it is shown."""
        robot = profile.id
        stopped, holder = self.held(robot)
        return RobotOut(
            id=robot,
            name=profile.shown,
            groups=profile.groups,
            skills=tuple(profile.skills),
            stopped=stopped,
            holder=holder,
            presence=self.presence(robot),
            views=tuple(kind.value for kind in ViewKind if profile.offers(kind)),
            units={name: value.unit for name, value in profile.telemetry.items()},
            watchdog_s=profile.watchdog_s,
            words=words or {},
        )

    def held(self, robot: RobotId) -> tuple[bool, str]:
        """Return whether a robot is stopped, and the name of who holds it; empty: nobody."""
        rooms = self.kernel.rooms
        holder = rooms.organiser.holder(robot)
        name = "" if holder is None else rooms.authoriser.directory.name(holder)
        return rooms.stops[robot].latched, name

    def presence(self, robot: RobotId) -> PresenceOut:
        """Return what a robot's side last said of itself."""
        linker = self.kernel.rooms.linker
        found, heartbeat_s = linker.presence(robot), linker.profile(robot).link.heartbeat_s
        pose = found.pose
        silent_s = max(LATE_AT_LEAST_S, LATE_SHARE * heartbeat_s)
        return PresenceOut(
            online=found.online,
            age_s=found.age_s,
            doing=found.doing,
            at_rest=found.at_rest,
            values=found.values,
            ages_s=found.ages_s,
            pose=None
            if pose is None
            else PoseOut(pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad, pose.frame),
            late=found.online is True and found.age_s is not None and found.age_s > silent_s,
        )

    def skills(self, caller: ApiCaller, robot: str) -> list[SkillOut]:
        """Return what somebody may ask of a robot.

        Raises:
            NotFound: They may not see it.
        """
        self.profile(caller, robot)
        catalogue = self.languages.of(caller.principal)
        return [
            self._skill(offered, partial(in_language, catalogue=catalogue))
            for offered in self.programs.skills(caller.address)
            if offered.robot == robot
        ]

    @staticmethod
    def _skill(offered: OfferedSkill, read: Callable[[str], str]) -> SkillOut:
        skill = offered.skill
        parameters = skill.parameters
        choices = {word for each in parameters.values() for word in each.choices or ()}
        return SkillOut(
            id=skill.id,
            name=read(skill.shown),
            icon=skill.icon,
            class_=skill.kind.value,
            asks=offered.asks,
            streams=skill.streams,
            arguments=schema_of(skill),
            units={name: each.unit for name, each in parameters.items() if each.unit},
            titles={name: read(parameter_label(name, each)) for name, each in parameters.items()},
            words={word: read(shown_name(word)) for word in sorted(choices)},
        )

    # ---- orders ----

    def line(
        self, caller: ApiCaller, robot: str, skill: str, values: dict[str, float | str]
    ) -> str:
        """Return the line of the grammar that says an order.

        Raises:
            NotFound: No such robot or skill, as far as they may know.
            NotUnderstood: What is wrong with it. Nothing was done.
        """
        profile = self.profile(caller, robot)
        if skill not in profile.skills:
            raise NotFound(UNKNOWN_SKILL)
        return self.programs.line(caller.address, profile.id, skill, values)

    def check(
        self, caller: ApiCaller, robot: str, skill: str, values: dict[str, float | str]
    ) -> CheckOut:
        """Return what an order would come to. Nothing is done, counted or written.

        Raises:
            Refusal: It would be refused, and why.
        """
        text = self.line(caller, robot, skill, values)
        found = self.programs.check(caller.address, text, self.messenger(caller).assurance)
        return CheckOut(
            allowed=not found.needs,
            sent=self.callers.read_by(found.words, caller),
            arguments=found.arguments,
            needs=found.needs,
        )

    def entry(self, caller: ApiCaller, order: str) -> OrderEntry:
        """Return an order of a robot that somebody may see.

        Raises:
            NotFound: There is none.
        """
        found = self.feed[order]
        if found is None or found.robot not in self.visible(caller):
            raise NotFound(UNKNOWN_ORDER)
        return found

    def orders(self, caller: ApiCaller, robot: str, most: int) -> list[OrderOut]:
        """Return the newest orders of robots that somebody may see."""
        return [self.shown(entry, caller) for entry in islice(self._of(caller, robot), most)]

    def _of(self, caller: ApiCaller, robot: str) -> Iterator[OrderEntry]:
        visible = self.visible(caller)
        for entry in self.feed.newest():
            if entry.robot in visible and robot in {"", entry.robot}:
                yield entry

    def oversees(self, caller: ApiCaller, robot: RobotId) -> bool:
        """Whether somebody may read what others ask of a robot."""
        containers = self.kernel.containers
        return containers is not None and containers.may_oversee(caller.principal, robot)

    def read_as(self, entry: OrderEntry, caller: ApiCaller) -> tuple[bool, int]:
        """Return on what it depends how somebody reads an order: all of it, by which catalogue."""
        whole = entry.principal == caller.principal or self.oversees(caller, entry.robot)
        return whole, id(self.languages.of(caller.principal))

    def shown(self, entry: OrderEntry, caller: ApiCaller) -> OrderOut:
        """Return an order as it is shown to somebody.

        What exactly others have asked, and what was said of it, is shown to whoever may read the
        history of that robot; that there is an order, whose, and how far it is, to everybody who
        may see the robot.
        """
        read = partial(in_language, catalogue=self.languages.of(caller.principal))
        whole, _ = self.read_as(entry, caller)
        vocabulary = self.kernel.rooms.vocabulary
        return OrderOut(
            id=entry.id,
            robot=entry.robot,
            skill=entry.skill,
            state=entry.ending or entry.stages[-1].stage,
            over=entry.is_over,
            who=self.kernel.rooms.authoriser.directory.name(entry.principal),
            n=entry.n,
            sent=read(entry.words) if whole else "",
            arguments=vocabulary.declared(entry.robot, entry.skill, entry.arguments)
            if whole
            else {},
            stages=tuple(StageOut(each.stage, moment(each.at_ns)) for each in entry.stages),
            fraction=entry.fraction,
            note=read(entry.note) if whole else "",
            code=entry.code,
            ended=moment(entry.ended_ns) if entry.ended_ns else None,
        )
