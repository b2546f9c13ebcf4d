"""The paper's organiser: CHECKPERMISSIONS of Algorithm 1.

Everything it needs is in memory; deciding costs the same whatever the number of people, roles,
robots and slots. What is simply allowed is looked up; everything else goes through
``rosic.core.policy.evaluate``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

from msgspec.structs import replace as renewed

from rosic.contracts.clock import Clock
from rosic.core.lease import Lease, Leases
from rosic.core.order import FOREVER_NS, Order, Permit, Request
from rosic.core.policy.evaluate import decide
from rosic.core.policy.query import NOTHING, AuthContext, Deny, PolicyState, Query
from rosic.core.policy.roles import StepRequired
from rosic.core.robot.skill import Argument
from rosic.errors import NotPermitted, RobotStopped, TimeInDoubt
from rosic.organiser.calendar_messages import moment
from rosic.organiser.rate_limits import person_full
from rosic.organiser.refusals import CLOCK_SET_BACK, LOCKED, RefusalBuilder

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.core.identity import Caller, KeyId, PrincipalId
    from rosic.core.policy.permissions import Permissions, PolicyInForce
    from rosic.core.policy.query import Allow, Decision, PolicyKey
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.signal import Signal
    from rosic.core.slot import SlotRule
    from rosic.core.stop_registry import StopRegistry
    from rosic.errors import Refusal
    from rosic.organiser.calendar import Calendar
    from rosic.organiser.rate_limits import RateLimits


class CheckedClock(Clock, Protocol):
    """A clock that knows when the machine's was set back.

    Attributes:
        behind: It was, and nobody has said yet that it is right: nothing new moves.
        when_ahead: Tells the nanoseconds that it was set forward by: what idles is older.
    """

    behind: bool
    when_ahead: Signal[[int]]


class AccessState(NamedTuple):
    """What the authoriser keeps and the organiser decides by: live views, never copies.

    Attributes:
        clock: By which rights, slots and leases end.
        calendar: Whose time it is, by that clock.
        key_of: Returns a key as deciding sees it; None: there is none.
        narrow: Keys that reach less than their principal's rights.
        locked: Who is locked.
        own_limits: Returns what somebody has set for themselves, as the texts of limits.
        locked_out: Hears of whoever was turned away because they are locked.
        released: Hears of a robot that was taken from whoever had it: what has not begun yet is to
            be admitted once more.
    """

    clock: CheckedClock
    calendar: Calendar
    key_of: Callable[[KeyId], PolicyKey | None]
    narrow: Collection[KeyId]
    locked: Collection[PrincipalId]
    own_limits: Callable[[PrincipalId], tuple[str, ...]]
    locked_out: Callable[[PrincipalId], object]
    released: Callable[[RobotId], object]


# ---- CHECKPERMISSIONS of Algorithm 1 ----

ArgumentsOf: TypeAlias = Callable[[Request], Mapping[str, Argument]]
AuthContextOf: TypeAlias = Callable[[], AuthContext]


class Organiser:
    """Holds the rights in force, the calendar, the buckets and the leases.

    Attributes:
        locked, narrow, key_of, own_limits: As in `AccessState`.
        calendar: Whose time it is.
        name_of: How somebody is called in sentences.
        leases: Who has each robot.
        lease_idle_s: How long a robot stays somebody's after the last order ended.
        rates: How much may be asked of and by whom.
        why_stopped: Says who stopped robots, and who can resume them.
    """

    def __init__(
        self,
        policy: PolicyInForce,
        profiles: Mapping[RobotId, Profile],
        stops: StopRegistry,
        access: AccessState,
        *,
        rates: RateLimits,
        lease_idle_s: float,
    ) -> None:
        clock = access.clock
        self._policy, self.calendar = policy, access.calendar
        self.key_of, self.narrow, self.locked = access.key_of, access.narrow, access.locked
        self.own_limits = access.own_limits
        self._locked_out, self._released = access.locked_out, access.released
        self.lease_idle_s, self.wall_ns = lease_idle_s, clock.wall_ns
        self.name_of = access.calendar.name_of
        self._slots: dict[RobotId, SlotRule] = {}  # of every robot
        self._stops, self._clock = stops, clock
        self.rates, self._idle_ns = rates, int(lease_idle_s * 1e9)
        self._warned: set[PrincipalId] = set()
        self.leases = Leases()
        clock.when_ahead.connect(self.leases.age)
        for profile in profiles.values():
            self.add_robot(profile, fence=0)  # until `remember_fences`
        self._refusing = RefusalBuilder(self, profiles, stops)
        self.why_stopped = self._refusing.stopped

    @property
    def rights(self) -> Permissions:
        """Return the present snapshot of the policy in force."""
        return self._policy.rights

    def moment(self, who: PrincipalId, at_ns: int) -> str:
        """Return a time as it is said to somebody today, in their zone."""
        return moment(at_ns, self.wall_ns(), self.calendar.zone(who))

    @property
    def in_doubt(self) -> bool:
        """Whether the computer's clock was set back: nothing new moves."""
        return self._clock.behind

    def remember_fences(self, fences: Mapping[RobotId, int]) -> None:
        """Start from the fences of the record (I13)."""
        self.leases.update({r: Lease(fence) for r, fence in fences.items() if r in self.leases})

    def charge(self, caller: Caller) -> None:
        """Take one line's worth from a person's bucket, whatever the line says.

        Raises:
            TooManyRequests: Nothing more was taken. Only the first one is worth an answer.
        """
        now_ns = self._clock.monotonic_ns()
        who = caller.counted_as or caller.principal
        wait_s = self.rates.enter(who, now_ns)
        if wait_s:
            refusal = person_full(wait_s)
            refusal.silent = who in self._warned
            self._warned.add(who)
            raise refusal
        if self._warned:
            self._warned.discard(who)

    def charge_work(self, caller: Caller, lines: float) -> None:
        """Take what a line costs besides itself, as it keeps the gateway busy for long.

        Args:
            caller: One was taken from them already.
            lines: As much as so many more; at most what a full bucket has left.

        Raises:
            TooManyRequests: Nothing was taken.
        """
        who = caller.counted_as or caller.principal
        if refusal := self.rates.spend(who, 1 + lines, (), {}):
            raise refusal

    def admit(
        self,
        caller: Caller,
        requests: Sequence[Request],
        arguments_of: ArgumentsOf,
        auth_context_of: AuthContextOf,
    ) -> tuple[Permit, ...]:
        """Decide whether a person may do all of this now: all of it or none.

        Args:
            caller: Who asks.
            requests: What, of which robots.
            arguments_of: Returns a request's arguments in SI; asked only where a limit counts.
            auth_context_of: Returns what the person has shown and confirmed besides; asked
                likewise.

        Raises:
            NotPermitted, OutOfBounds, RobotStopped, RobotTaken: Why not, who can help, when.
            FirstNeeded: They may, once something else has happened.
            TakeOver: They may, and somebody else has to give way first.
            TooManyRequests: They may, but not so often; says whose limit it is.
            TimeInDoubt: Not before the owner has looked at the computer's clock.
                Nobody's lease has changed.
        """
        now_ns = self._clock.monotonic_ns()
        rights, principal = self._policy.rights, caller.principal
        if principal in self.locked:  # since the message was taken: its lines may wait for a disk
            self.check_unlocked(caller)
        acting: list[tuple[Lease | None, int]] = []
        cost = 0.0
        for request in requests:
            robot, skill = request.robot, request.skill
            right = rights.may(principal, robot, skill.id)
            lease = self.leases[robot] if skill.actuates else None
            plain = right is not None and right.plain
            until_ns = self._open(caller, robot, lease, now_ns) if plain else 0
            if not until_ns:
                try:
                    until_ns = self._decide(
                        caller, request, arguments_of(request), auth_context_of()
                    )
                except RobotStopped as why:
                    stopped = [r.robot for r in requests if self._stops[r.robot].latched]
                    raise self.why_stopped.refusal(principal, stopped or [robot]) from why
            if self._clock.behind and lease is not None:
                raise TimeInDoubt(CLOCK_SET_BACK)
            acting.append((lease, until_ns))
            cost += skill.cost
        if cost != len(requests) or rights.rates or self.rates.robots:
            self._spend(caller, requests)
        permits: list[Permit] = []
        for request, (lease, until_ns) in zip(requests, acting, strict=True):
            robot = request.robot
            grew = lease is not None and lease.take(principal, now_ns, self._idle_ns)
            permits.append(
                Permit(
                    principal,
                    caller.key,
                    robot,
                    request.skill.id,
                    0 if lease is None else lease.fence,
                    grew,
                    self._stops[robot].generation,
                    rights.epoch,
                    until_ns,
                    self._stops.cancelled(principal, robot) if self._stops.cancels else 0,
                )
            )
        return tuple(permits)

    def _spend(self, caller: Caller, requests: Sequence[Request]) -> None:
        """Take what permitted requests cost: all of it or nothing.

        Raises:
            TooManyRequests: Of a robot, of a role, or of their own; nothing was taken.
        """
        rights, wall_ns, principal = self._policy.rights, self.wall_ns(), caller.principal
        limited = requests if rights.rates else ()
        rated = (rights.rated(principal, r.robot, r.skill.id, wall_ns) for r in limited)
        roles = {role: rights.rates[role] for found in rated for role in found}
        robots = [(request.robot, request.skill.cost) for request in requests]
        who, cost = caller.counted_as or principal, max(cost for _, cost in robots)
        refusal = self.rates.spend(who, cost, robots, roles)
        if refusal is not None:
            raise refusal

    def _open(self, caller: Caller, robot: RobotId, lease: Lease | None, now_ns: int) -> int:
        """Until when nothing but the right itself has to be asked; 0: there is more already."""
        if caller.key in self.narrow:
            return 0
        if lease is None:
            return FOREVER_NS
        holder = lease.holder_at(now_ns, self._idle_ns)
        if self._stops[robot].latched or not (holder is None or holder == caller.principal):
            return 0
        rule = self._slots[robot]
        if rule == "none" or not (rule == "required" or self.calendar.has_slots(robot)):
            return FOREVER_NS
        wall_ns = self.wall_ns()
        slot = self.calendar.present(robot, wall_ns)
        if not (rule == "respected" if slot is None else slot.principal == caller.principal):
            return 0
        return self.calendar.answer_ends_ns(robot, wall_ns)

    def _decide(
        self,
        caller: Caller,
        request: Request,
        arguments: Mapping[str, Argument],
        auth_context: AuthContext,
    ) -> int:
        decision = self.decision(caller, request.robot, request.skill.id, arguments, auth_context)
        if isinstance(decision, Deny):
            raise self._refusing.denial(decision)
        if decision.needs:
            raise self._refusing.needs(decision, request.text)
        if decision.preempts and self.holder(request.robot) != caller.principal:
            raise self._refusing.take_over(decision)
        return self._until_ns(decision)

    def check(
        self,
        caller: Caller,
        request: Request,
        arguments: Mapping[str, Argument],
        auth_context: AuthContext,
    ) -> Allow:
        """Return how an order would be allowed now. Nothing is taken, counted or written.

        Raises:
            Refusal: It would be refused, as `admit` would; but for rates, which are not asked.
        """
        self.check_unlocked(caller)
        decision = self.decision(caller, request.robot, request.skill.id, arguments, auth_context)
        if isinstance(decision, Deny):
            raise self._refusing.denial(decision)
        if self._clock.behind and request.skill.actuates:
            raise TimeInDoubt(CLOCK_SET_BACK)
        return decision

    def _until_ns(self, allowed: Allow) -> int:
        """Return until when a decision holds if nobody changes anything, wall clock."""
        robot, key = allowed.ask.robot, self.key_of(allowed.ask.key)
        booked = self._rule(robot) != "none"
        slot_ns = self.calendar.answer_ends_ns(robot, self.wall_ns()) if booked else FOREVER_NS
        ends = (allowed.until_ns, None if key is None else key.expires_ns, slot_ns)
        return min(ns for ns in ends if ns is not None)

    def decision(
        self,
        caller: Caller,
        robot: RobotId,
        skill: str,
        arguments: Mapping[str, Argument] | None = None,
        auth_context: AuthContext = NOTHING,
    ) -> Decision:
        """Decide by every rule, and say why: for what is not simply allowed, and for explaining."""
        ask = Query(
            principal=caller.principal,
            key=caller.key,
            robot=robot,
            skill=skill,
            arguments=arguments,
            channel=auth_context.channel,
        )
        return decide(self._state(caller, robot, auth_context), ask)

    def _state(self, caller: Caller, robot: RobotId, auth_context: AuthContext) -> PolicyState:
        wall_ns, now_ns = self._clock.wall_ns(), self._clock.monotonic_ns()
        lease = self.leases.get(robot)
        rule = self._rule(robot)
        slot = None if rule == "none" else self.calendar.present(robot, wall_ns)
        free_ns: int | None = None
        # Told only by a refusal about slots, and looking for it is the dearest part of asking.
        if rule == "required" if slot is None else slot.principal != caller.principal:
            free_ns = self.calendar.next_free(robot, wall_ns, 60)
        return PolicyState(
            rights=self._policy.rights,
            key=self.key_of(caller.key),
            now_ns=wall_ns,
            locked=self.locked,
            stopped=lease is not None and self._stops[robot].latched,
            holder=None if lease is None else lease.holder_at(now_ns, self._idle_ns),
            slots=rule,
            slot=slot,
            next_free_ns=free_ns,
            stepped_up=auth_context.stepped_up,
            confirmed=auth_context.confirmed,
            second=auth_context.second,
        )

    def readmit(self, caller: Caller, order: Order, auth_context: AuthContext) -> Permit:
        """Decide once more for an order that waited while the policy changed (I8, I16).

        It keeps its lease and its stop generation: what a stop voided stays void.

        Raises:
            OrderVoid: It was agreed to under other rules; it has to be said again.
            NotPermitted: The right is gone.
            OutsideSlot, SlotTaken, RobotTaken, TimeInDoubt: The robot is not theirs any more.
        """
        self.check_unlocked(caller)
        decision = self.decision(caller, order.robot, order.skill.id, order.arguments, auth_context)
        if isinstance(decision, Deny):
            raise self._refusing.denial(decision)
        self._refusing.check_agreed_since(self.rights.policy, order.permit.epoch, decision)
        fence, until_ns = order.permit.fence, self._until_ns(decision)
        doubt = self._clock.behind
        if fence and (doubt or not self.leases[order.robot].runs(fence)):
            raise TimeInDoubt(CLOCK_SET_BACK) if doubt else self._refusing.over(order.robot)
        return renewed(order.permit, new_fence=False, epoch=self.rights.epoch, until_ns=until_ns)

    def check_word(
        self, caller: Caller, robot: RobotId, word: str, auth_context: AuthContext = NOTHING
    ) -> None:
        """Decide whether somebody, a person or a robot, has a right that is no skill.

        Raises:
            NotPermitted, Unrecognised: Not they.
        """
        decision = self.decision(caller, robot, word, auth_context=auth_context)
        if isinstance(decision, Deny):
            raise self._refusing.denial(decision)

    def check_unlocked(self, caller: Caller) -> None:
        """See that somebody is not locked; only a stop is left to whoever is.

        Raises:
            NotPermitted: They are.
        """
        if caller.principal in self.locked:
            self._locked_out(caller.principal)
            raise NotPermitted(LOCKED)

    def allows(self, principal: PrincipalId, robot: RobotId, skill: str) -> bool:
        """Whether somebody has a right at all now, under whatever limits; for menus."""
        return self.rights.holds(principal, robot, skill, self._clock.wall_ns())

    def wants_proof(self, request: Request) -> bool:
        """Whether a request is let pass only after a second factor was shown."""
        return StepRequired.STEP_UP in self.rights.caution(request.robot, request.skill.id).needs

    def settle(self, permit: Permit) -> None:
        """One order has ended; when it was the last, the lease begins to idle."""
        if permit.fence:
            self.leases[permit.robot].settle(permit.fence, self._clock.monotonic_ns())

    def abandon(self, permits: Sequence[Permit]) -> None:
        """Nothing became of these: a lease taken for them is given back."""
        for permit in permits:
            self.settle(permit)
            lease = self.leases[permit.robot]
            if permit.new_fence and permit.fence == lease.fence and not lease.active:
                lease.release()

    def visible(self, principal: PrincipalId) -> frozenset[RobotId]:
        """Return the robots that a person may see, and therefore stop."""
        return self._policy.rights.visible(principal, self._clock.wall_ns())

    def holder(self, robot: RobotId) -> PrincipalId | None:
        """Return who has a robot now."""
        self.wall_ns()  # a clock that was set forward ends what idles
        return self.leases[robot].holder_at(self._clock.monotonic_ns(), self._idle_ns)

    def whose(self, robot: RobotId) -> PrincipalId | None:
        """Return who has a robot now, or whose time with it is now."""
        rule = self._rule(robot)
        slot = None if rule == "none" else self.calendar.present(robot, self.wall_ns())
        return self.holder(robot) or (slot.principal if slot is not None else None)

    def free_in(self, robot: RobotId) -> tuple[bool, float]:
        """Return whether a robot that is taken is at work, and the seconds that it has to idle."""
        lease, now_ns = self.leases[robot], self._clock.monotonic_ns()
        if lease.active:
            return True, self.lease_idle_s
        return False, (self._idle_ns - (now_ns - lease.idle_since_ns)) / 1e9

    def lease(self, robot: RobotId) -> Lease:
        """Return a robot's lease; only looked at."""
        return self.leases[robot]

    def why_not_move(self, principal: PrincipalId, robot: RobotId) -> NotPermitted | None:
        """Return why somebody may not move a robot at all, whatever the time; None if they may."""
        if principal in self.locked:
            return NotPermitted(LOCKED)
        return self._refusing.never_moves(principal, robot)

    def not_now(self, principal: PrincipalId, robot: RobotId) -> Refusal | None:
        """Return why somebody may not move a robot now, by right and by slot; None if they may."""
        return self.why_not_move(principal, robot) or self.outside_slot(principal, robot)

    def outside_slot(self, principal: PrincipalId, robot: RobotId) -> Refusal | None:
        """Return why a robot is not somebody's now, by slots alone; None if it may be."""
        return self.calendar.outside(principal, robot, self.wall_ns(), self._rule(robot))

    def release(self, robot: RobotId) -> None:
        """Take a robot from whoever has it; orders still under way become void."""
        self.leases[robot].release()
        self._released(robot)

    def yielded(self, robot: RobotId, principal: PrincipalId) -> None:
        """Let somebody have a robot that was given up for them, until they use it or it idles."""
        now_ns, idle_ns = self._clock.monotonic_ns(), self._idle_ns
        self.leases[robot].keep(principal, now_ns + idle_ns, now_ns, idle_ns)

    def held_by(self, principal: PrincipalId) -> tuple[RobotId, ...]:
        """Return every robot that somebody has now."""
        return tuple(robot for robot in self.leases if self.holder(robot) == principal)

    def release_all(self, principal: PrincipalId) -> tuple[RobotId, ...]:
        """Take every robot away from somebody; return which."""
        held = self.held_by(principal)
        for robot in held:
            self.release(robot)
        return held

    def add_robot(self, profile: Profile, fence: int) -> None:
        """Know one more robot, from the highest fence it has seen (I13)."""
        self.leases[profile.id] = Lease(fence)
        self._slots[profile.id] = profile.slots.value

    def _rule(self, robot: RobotId) -> SlotRule:
        """Return what slots mean for a robot; what is no robot, like the fleet, has none."""
        return self._slots[robot] if robot in self.leases else "none"
