"""Why not, in the words of the person who is told: what is missing, who can help, and when."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import capital, joined, said
from rosic.core.language.suggestions import AND, OR
from rosic.core.messages import named_of, no_robot
from rosic.core.policy.limits import broken_limit, limit_in_words
from rosic.core.policy.query import PolicyCode
from rosic.core.policy.roles import Assurance, StepRequired
from rosic.core.policy.scope import RESUME
from rosic.core.role_names import role_shown
from rosic.errors import (
    FirstNeeded,
    NotPermitted,
    OrderVoid,
    OutOfBounds,
    Refusal,
    RobotTaken,
    TakeOver,
    Unrecognised,
)
from rosic.organiser.why_stopped import WhyStopped

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.policy.query import Allow, Deny, Query
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Argument, Parameter, Skill
    from rosic.core.stop_registry import StopRegistry
    from rosic.organiser.why_stopped import PolicyInformation

_SI = frozenset({"", "m", "m/s", "m/s^2", "s", "N", "Nm", "rad", "rad/s", "kg"})
AGREED = frozenset({StepRequired.CONFIRMATION, StepRequired.SECOND_PERSON})
LOCKED = said("Your access is locked. The admin of this place can unlock it. Stop still works.")
ENDED = said("Your access here has ended. The admin of this place can renew it.")
CLOCK_SET_BACK = said(
    "The clock of this computer was set back, so nothing new moves until its owner has said that "
    "it is right, or it has caught up. Stop still works."
)
ANY_CHANNEL = {
    Assurance.E2EE_UNVERIFIED: said("a chat that is encrypted from end to end"),
    Assurance.E2EE_VERIFIED: said("a chat that only the two of us can read, with keys compared"),
    Assurance.LOCAL: said("somebody at the machine itself"),
}


class RefusalBuilder:
    """Turns decisions into refusals.

    Attributes:
        stopped: Says it of robots that are stopped.
    """

    def __init__(
        self, organiser: PolicyInformation, profiles: Mapping[RobotId, Profile], stops: StopRegistry
    ) -> None:
        self._organiser = organiser
        self._profiles = profiles
        self.stopped = WhyStopped(organiser, profiles, stops)
        self._denials: dict[PolicyCode, Callable[[Deny], Refusal]] = {
            PolicyCode.KEY_UNKNOWN: lambda _: Unrecognised(ENDED),
            PolicyCode.KEY_REVOKED: lambda _: Unrecognised(ENDED),
            PolicyCode.KEY_EXPIRED: lambda _: Unrecognised(ENDED),
            PolicyCode.LOCKED: lambda _: NotPermitted(LOCKED),
            PolicyCode.NO_SUCH_ROBOT: lambda d: NotPermitted(no_robot(d.ask.robot)),
            PolicyCode.KEY_TOO_NARROW: self._too_narrow,
            PolicyCode.NOT_GRANTED: self._not_granted,
            PolicyCode.RIGHT_ENDED: self._right_ended,
            PolicyCode.CHANNEL_TOO_WEAK: self._too_weak,
            PolicyCode.OVER_LIMIT: self._over_limit,
            PolicyCode.ROBOT_STOPPED: lambda d: self.stopped.refusal(
                d.ask.principal, (d.ask.robot,)
            ),
            PolicyCode.SLOT_NEEDED: self._slot,
            PolicyCode.SLOT_TAKEN: self._slot,
            PolicyCode.ROBOT_TAKEN: self._taken,
        }

    def denial(self, denied: Deny) -> Refusal:
        """Return a denial as what the person is told."""
        return self._denials[denied.code](denied)

    def never_moves(self, principal: PrincipalId, robot: RobotId) -> NotPermitted | None:
        """Return why nothing that a robot can do is somebody's; None if something is."""
        profile, organiser = self._profiles[robot], self._organiser
        skills = [skill.id for skill in profile.skills.values() if skill.actuates]
        if any(organiser.allows(principal, robot, skill) for skill in skills):
            return None
        who = organiser.rights.givers(robot, organiser.wall_ns(), besides=principal)
        return NotPermitted(
            said(
                "Moving {shown} needs a right you do not have. {who_grants}",
                shown=profile.shown,
                who_grants=self._who_grants(who),
            ),
            access_request=f"/ask {robot}" if who else "",
        )

    def needs(self, allowed: Allow, text: str) -> FirstNeeded:
        """Return what has to come first, with the command that is asked again then."""
        first = allowed.needs[0]
        shown = self._shown(allowed.ask.robot)
        what = self._named(allowed.ask)
        if first is StepRequired.CONFIRMATION:
            # As it was said: with its values, and of a group all that move.
            sentence = said("{text}? It moves only if you confirm it.", text=text)
        elif first is StepRequired.STEP_UP:
            sentence = said(
                "{what} on {shown} needs your second factor first. Send: code, and the "
                "six digits your authenticator app shows.",
                what=capital(what),
                shown=shown,
            )
        else:
            sentence = said(
                "{what} on {shown} needs a second person who agrees.",
                what=capital(what),
                shown=shown,
            )
        return FirstNeeded(
            sentence,
            need=first.value,
            robot=allowed.ask.robot,
            text=text,
            arguments=allowed.ask.arguments,
        )

    def take_over(self, allowed: Allow) -> TakeOver:
        """Return whom the person may take the robot over from."""
        robot = allowed.ask.robot
        names = joined(AND, map(self._organiser.name_of, allowed.preempts))
        return TakeOver(
            said(
                "{shown} is {names}'s now. You may take it over; they are told.",
                shown=self._shown(robot),
                names=names,
            ),
            offers=(f"take over {robot}",),
            robot=robot,
            others=allowed.preempts,
        )

    def over(self, robot: RobotId) -> OrderVoid:
        """Return that a robot was taken from somebody before what they asked for could begin."""
        return OrderVoid(
            said(
                "Your turn with {shown} was over before this could begin. Nothing was done.",
                shown=self._shown(robot),
            )
        )

    def check_agreed_since(self, policy: int, epoch: int, allowed: Allow) -> None:
        """See that what somebody has to agree to was agreed to under the rules of now.

        Raises:
            OrderVoid: They changed after it was admitted.
        """
        if policy <= epoch or AGREED.isdisjoint(allowed.care):
            return
        raise OrderVoid(
            said(
                "The rules here changed before {shown} could begin, so what was agreed to counts "
                "no more. Nothing was done. Say it again.",
                shown=self._shown(allowed.ask.robot),
            )
        )

    def _named(self, ask: Query) -> str:
        """Return what was asked for, as a sentence names it."""
        return named_of(self._profiles[ask.robot], ask.skill)

    def _shown(self, robot: RobotId) -> str:
        return self._profiles[robot].shown

    def _who_grants(self, who: tuple[PrincipalId, ...]) -> str:
        names = [self._organiser.name_of(principal) for principal in who]
        if not names:
            return said("The operator of this place can give it.")
        return said("{names} can give it. It counts at once.", names=joined(OR, names))

    def _who_allows_more(self, who: tuple[PrincipalId, ...]) -> str:
        names = [self._organiser.name_of(principal) for principal in who]
        if not names:
            return said("The operator of this place can allow more.")
        return said("{names} can allow more. It counts at once.", names=joined(OR, names))

    def _not_granted(self, denied: Deny) -> Refusal:
        role = (
            said('the right "{roles}"', roles=role_shown(denied.roles[0]))
            if denied.roles
            else said("a right nobody has yet")
        )
        what = capital(self._named(denied.ask))
        shown, resumes = self._shown(denied.ask.robot), denied.ask.skill == RESUME
        sentence = said(
            "{what} needs {role} on {shown}. {who_grants}",
            what=what,
            role=role,
            shown=shown,
            who_grants=self._who_grants(denied.who),
        )
        robots = (denied.ask.robot,) if resumes else ()
        more = [self.stopped.who_resumes(denied.ask.principal, robots)] if robots else []
        return NotPermitted(
            joined(" ", (sentence, *more)),
            access_request=_access_request(denied),
        )

    def _right_ended(self, denied: Deny) -> Refusal:
        what = capital(self._named(denied.ask))
        when = self._organiser.moment(denied.ask.principal, denied.when_ns or 0)
        shown = self._shown(denied.ask.robot)
        return NotPermitted(
            said(
                "{what} on {shown}: your right ended {when}. {who_grants}",
                what=what,
                shown=shown,
                when=when,
                who_grants=self._who_grants(denied.who),
            ),
            access_request=_access_request(denied),
        )

    def _too_narrow(self, denied: Deny) -> Refusal:
        what, shown = capital(self._named(denied.ask)), self._shown(denied.ask.robot)
        return NotPermitted(
            said(
                "{what} on {robot} is outside what your key is for. The operator of this place "
                "can give you another one, and it counts at once.",
                what=what,
                robot=shown,
            )
        )

    def _too_weak(self, denied: Deny) -> Refusal:
        what, shown = capital(self._named(denied.ask)), self._shown(denied.ask.robot)
        unverified = denied.ask.channel is Assurance.E2EE_UNVERIFIED
        if unverified and denied.channel is Assurance.E2EE_VERIFIED:
            return NotPermitted(
                said(
                    "{what} on {robot} needs a device whose keys were compared. Verify me in your "
                    "client, or say /verify; then this chat is enough.",
                    what=what,
                    robot=shown,
                )
            )
        wanted = ANY_CHANNEL.get(denied.channel or Assurance.LOCAL, said("a better protected chat"))
        return NotPermitted(
            said(
                "{what} on {robot} needs {wanted}. This chat is not enough. Say it there, and you "
                "may.",
                what=what,
                robot=shown,
                wanted=wanted,
            )
        )

    def _over_limit(self, denied: Deny) -> Refusal:
        limit = denied.limit
        within = limit_in_words(bound_of(limit.said)) if limit is not None else said("a limit")
        what, shown = self._named(denied.ask), self._shown(denied.ask.robot)
        own = self._organiser.own_limits(denied.ask.principal)
        if limit is not None and any(each in limit.said for each in own):
            return OutOfBounds(
                said(
                    "{shown}: {what} is allowed with {within} by your own settings. Nothing was "
                    "done. To change that: /settings speed",
                    shown=shown,
                    what=what,
                    within=within,
                ),
                offers=within_limits(denied, self._profiles[denied.ask.robot].skills),
            )
        return OutOfBounds(
            said(
                "{shown}: for you, {what} is allowed with {within}. Nothing was done. {who}",
                shown=shown,
                what=what,
                within=within,
                who=self._who_allows_more(denied.who),
            ),
            offers=within_limits(denied, self._profiles[denied.ask.robot].skills),
            access_request=_access_request(denied),
        )

    def _slot(self, denied: Deny) -> Refusal:
        robot = denied.ask.robot
        outside = self._organiser.outside_slot(denied.ask.principal, robot)
        if outside is not None:
            return outside
        return RobotTaken(said("{shown} is somebody else's now.", shown=self._shown(robot)))

    def _taken(self, denied: Deny) -> Refusal:
        robot = denied.ask.robot
        at_work, wait_s = self._organiser.free_in(robot)
        shown, name = self._shown(robot), self._organiser.name_of(denied.holder or "")
        seconds = max(1, round(wait_s))
        if at_work:
            sentence = said(
                "{shown} is taken by {name}. You can have it when that ends and it has been idle "
                "for {seconds} s.",
                shown=shown,
                name=name,
                seconds=seconds,
            )
        else:
            sentence = said(
                "{shown} is taken by {name}. You can have it in {seconds} s.",
                shown=shown,
                name=name,
                seconds=seconds,
            )
        return RobotTaken(sentence, offers=(f"wait {robot}",))


def _access_request(denied: Deny) -> str:
    """Return how to ask for what is missing; nothing when there is nobody to ask."""
    return f"/ask {denied.ask.robot} {_spoken(denied.ask.skill)}" if denied.who else ""


def within_limits(denied: Deny, skills: Mapping[str, Skill]) -> tuple[str, ...]:
    """Return the same command with as much as their limits allow, if that can be typed."""
    skill, way, arguments = skills.get(denied.ask.skill), denied.way, denied.ask.arguments
    if skill is None or way is None or arguments is None:
        return ()
    allowed = dict(arguments)
    for limit in way.limits:
        value = allowed.get(limit.parameter)
        if isinstance(value, int | float):
            allowed[limit.parameter] = float(f"{min(max(value, limit.min), limit.max):g}")
    values = [
        _typed(name, allowed[name], parameter)
        for name, parameter in skill.parameters.items()
        if allowed[name] != parameter.default or allowed[name] != arguments[name]
    ]
    if not all(values) or broken_limit(way.limits, allowed) is not None:
        return ()
    return (f"{denied.ask.robot} {_spoken(skill.id)} {' '.join(values)}",)


def _typed(name: str, value: Argument, parameter: Parameter) -> str:
    """Return a value as somebody types it; nothing where what is typed is not in SI."""
    if isinstance(value, str):
        return f"{name}={value}"
    return f"{name}={value:g} {parameter.unit}".rstrip() if parameter.unit in _SI else ""


def bound_of(limit: str) -> str:
    """Return a limit without the skills it is for: whoever reads it has just named one."""
    head, _, bound = limit.partition(" ")
    return bound if ":" in head else limit


def _spoken(skill: str) -> str:
    return skill.replace("_", " ")
