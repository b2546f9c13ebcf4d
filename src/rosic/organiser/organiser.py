"""The paper's organiser: CHECKPERMISSIONS of Algorithm 1.

Everything it needs is in memory; deciding costs the same whatever the number of people.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.authority import READ, RESUME, Policy
from rosic.core.identity import Caller, PrincipalId
from rosic.core.lease import Lease
from rosic.core.order import Order, Permit, Request
from rosic.core.rate import Bucket, RateLimit
from rosic.errors import NotPermitted, RobotStopped, RobotTaken, TooManyRequests

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.robot import Profile, RobotId
    from rosic.core.stopboard import StopBoard

NameOf: TypeAlias = Callable[[PrincipalId], str]


class Organiser:
    """Holds the policy in force, the buckets and the leases.

    Attributes:
        policy: The present snapshot; replacing it is one assignment.
        lease_idle_s: How long a robot stays somebody's after the last order ended.
    """

    def __init__(
        self,
        policy: Policy,
        profiles: Mapping[RobotId, Profile],
        stops: StopBoard,
        clock: Clock,
        *,
        limit: RateLimit,
        lease_idle_s: float,
    ) -> None:
        self.policy = policy
        self.lease_idle_s = lease_idle_s
        self.name_of: NameOf = str
        self._profiles = profiles
        self._stops = stops
        self._clock = clock
        self._limit = limit
        self._idle_ns = int(lease_idle_s * 1e9)
        self._buckets: dict[PrincipalId, Bucket] = {}
        self._warned: set[PrincipalId] = set()
        self._leases = {robot: Lease() for robot in profiles}

    def remember_fences(self, fences: Mapping[RobotId, int]) -> None:
        """Start from the fences of the record (I13)."""
        for robot, fence in fences.items():
            if robot in self._leases:
                self._leases[robot] = Lease(fence)

    def charge(self, caller: Caller) -> None:
        """Take one line's worth from a person's bucket, whatever the line says.

        Raises:
            TooManyRequests: Nothing more was taken. Only the first one is worth an answer.
        """
        now_ns = self._clock.monotonic_ns()
        bucket = self._buckets.get(caller.principal)
        if bucket is None:
            bucket = self._buckets[caller.principal] = Bucket(self._limit, now_ns)
        wait_s = bucket.take(now_ns)
        if wait_s:
            refusal = TooManyRequests(
                f"That is more than one person may ask. Again in {max(1, round(wait_s))} s.",
                retry_after_s=wait_s,
            )
            refusal.silent = caller.principal in self._warned
            self._warned.add(caller.principal)
            raise refusal
        if self._warned:
            self._warned.discard(caller.principal)

    def admit(self, caller: Caller, requests: Sequence[Request]) -> tuple[Permit, ...]:
        """Decide whether a person may do all of this now: all of it or none.

        Raises:
            NotPermitted, RobotStopped, RobotTaken: Why not, who can help, when.
                Nobody's lease has changed.
        """
        now_ns = self._clock.monotonic_ns()
        policy, principal = self.policy, caller.principal
        acting: list[Lease | None] = []
        for request in requests:
            robot, skill = request.robot, request.skill
            if not policy.allows(principal, robot, skill.id):
                raise self._not_permitted(principal, robot, skill.id)
            if skill.actuates:
                acting.append(self._free_lease(principal, robot, now_ns))
            else:
                acting.append(None)
        permits: list[Permit] = []
        for request, lease in zip(requests, acting, strict=True):
            robot = request.robot
            grew = lease is not None and lease.take(principal, now_ns, self._idle_ns)
            permits.append(
                Permit(
                    principal, caller.key, robot, request.skill.id,
                    0 if lease is None else lease.fence, grew,
                    self._stops[robot].generation, policy.epoch,
                )
            )  # fmt: skip
        return tuple(permits)

    def readmit(self, caller: Caller, order: Order) -> Permit:
        """Decide once more for an order that waited while the policy changed (I8).

        It keeps its lease and its stop generation: what a stop voided stays void.

        Raises:
            NotPermitted: The right is gone.
        """
        self._allow(caller, order.robot, order.skill.id)
        old = order.permit
        return Permit(
            old.principal, old.key, old.robot, old.skill, old.fence, False,
            old.stop_generation, self.policy.epoch,
        )  # fmt: skip

    def check_resume(self, caller: Caller, robot: RobotId) -> None:
        """Decide whether a person may undo a stop.

        Raises:
            NotPermitted: Not this person.
        """
        self._allow(caller, robot, RESUME)

    def settle(self, permit: Permit) -> None:
        """One order has ended; when it was the last, the lease begins to idle."""
        if permit.fence:
            self._leases[permit.robot].settle(permit.fence, self._clock.monotonic_ns())

    def abandon(self, permits: Sequence[Permit]) -> None:
        """Nothing became of these: a lease taken for them is given back."""
        for permit in permits:
            self.settle(permit)
            lease = self._leases[permit.robot]
            if permit.new_fence and permit.fence == lease.fence and not lease.active:
                lease.release()

    def visible(self, principal: PrincipalId) -> frozenset[RobotId]:
        """Return the robots that a person may see, and therefore stop."""
        return self.policy.visible(principal)

    def holder(self, robot: RobotId) -> PrincipalId | None:
        """Return who has a robot now."""
        return self._leases[robot].holder_at(self._clock.monotonic_ns(), self._idle_ns)

    def release_all(self, principal: PrincipalId) -> tuple[RobotId, ...]:
        """Take every robot away from somebody; return which."""
        held = tuple(robot for robot in self._leases if self.holder(robot) == principal)
        for robot in held:
            self._leases[robot].release()
        return held

    def _allow(self, caller: Caller, robot: RobotId, skill: str) -> None:
        if not self.policy.allows(caller.principal, robot, skill):
            raise self._not_permitted(caller.principal, robot, skill)

    def _not_permitted(self, principal: PrincipalId, robot: RobotId, skill: str) -> NotPermitted:
        shown = self._profiles[robot].shown
        if not self.policy.allows(principal, robot, READ):
            return NotPermitted(f"I know no robot called {robot}.")
        roles = self.policy.roles_giving(robot, skill)
        role = f'the right "{roles[0]}"' if roles else "a right nobody has yet"
        what = skill.replace("_", " ").capitalize()
        return NotPermitted(f"{what} needs {role} on {shown}. {self._who_grants()}")

    def _who_grants(self) -> str:
        names = [self.name_of(p) for p in self.policy.with_role("admin")[:3]]
        if not names:
            return "The operator of this place can give it."
        return f"{' or '.join(names)} can give it."

    def _free_lease(self, principal: PrincipalId, robot: RobotId, now_ns: int) -> Lease:
        if self._stops[robot].latched:
            raise self._stopped(robot)
        lease = self._leases[robot]
        holder = lease.holder_at(now_ns, self._idle_ns)
        if holder is not None and holder != principal:
            raise self._taken(robot, holder, lease, now_ns)
        return lease

    def _stopped(self, robot: RobotId) -> RobotStopped:
        stopped = self._stops[robot]
        by = f", by {self.name_of(stopped.by)}" if stopped.by else ""
        return RobotStopped(
            f"{self._profiles[robot].shown} is stopped{by}. It stays stopped until someone who "
            "may resumes it. Nothing was done.",
            offers=(f"resume {robot}",),
        )

    def _taken(self, robot: RobotId, holder: PrincipalId, lease: Lease, now_ns: int) -> RobotTaken:
        if lease.active:
            when = "You can have it when that ends and it has been idle for"
            wait_s = self.lease_idle_s
        else:
            when = "You can have it in"
            wait_s = (self._idle_ns - (now_ns - lease.idle_since_ns)) / 1e9
        return RobotTaken(
            f"{self._profiles[robot].shown} is taken by {self.name_of(holder)}. "
            f"{when} {max(1, round(wait_s))} s."
        )
