"""Whether a robot is free, for whom, and until when."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.robot.profile import RobotId, Slots

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.organiser.wait_queue import TurnOffer

SHORTEST_TURN_S = 300
"""A gap shorter than the first warning before its end is nobody's turn."""
SECOND_NS = 1_000_000_000


class Availability:
    """Looks at slots and leases together.

    Attributes:
        barred: Robots that come to rest, or have not confirmed it: nobody's, whatever slots say.
    """

    def __init__(self, times: BookingContext) -> None:
        self.barred: set[RobotId] = set()
        self._times = times
        self._idle_ns = int(times.lease_idle_s * SECOND_NS)

    def booked(self, robot: RobotId) -> bool:
        """Whether slots mean anything for a robot."""
        profile = self._times.vocabulary.profiles.get(robot)
        return profile is not None and profile.slots is not Slots.NONE

    def holder(self, robot: RobotId) -> PrincipalId | None:
        """Return who has a robot by its lease."""
        now_ns = self._times.clock.monotonic_ns()
        return self._times.sides.lease(robot).holder_at(now_ns, self._idle_ns)

    def lapses_ns(self, robot: RobotId) -> int | None:
        """Return when a lease lapses by itself, monotonic clock; None while it is used, or not."""
        lease = self._times.sides.lease(robot)
        if self.holder(robot) is None or lease.active:
            return None
        return lease.idle_since_ns + self._idle_ns

    def slot(self, robot: RobotId) -> BookedSlot | None:
        """Return the slot that is now, if slots mean anything for the robot."""
        if not self.booked(robot):
            return None
        return self._times.calendar.present(robot, self._times.clock.wall_ns())

    def has(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Whether a robot is somebody's now, by slot or lease."""
        slot = self.slot(robot)
        if slot is not None:
            return slot.principal == principal
        return self.holder(robot) == principal

    def keep(self, offer: TurnOffer) -> None:
        """Let nobody else have a robot while it is offered to somebody."""
        now_ns = self._times.clock.monotonic_ns()
        lease = self._times.sides.lease(offer.robot)
        lease.keep(offer.principal, offer.expires_ns, now_ns, self._idle_ns)

    def give(self, robot: RobotId, principal: PrincipalId) -> None:
        """Let somebody have a robot as if they had just used it."""
        now_ns = self._times.clock.monotonic_ns()
        lease = self._times.sides.lease(robot)
        if not lease.active:
            lease.keep(principal, now_ns + self._idle_ns, now_ns, self._idle_ns)

    def give_up(self, offer: TurnOffer) -> None:
        """Keep it no longer; whoever uses it goes on."""
        if self.is_only_kept(offer):
            self._times.sides.lease(offer.robot).release()

    def is_only_kept(self, offer: TurnOffer) -> bool:
        """Whether somebody has a robot only because it is offered to them."""
        lease = self._times.sides.lease(offer.robot)
        kept = lease.is_kept(offer.expires_ns, self._idle_ns)
        return kept and self.slot(offer.robot) is None and self.holder(offer.robot) is not None

    def free_for(self, robot: RobotId, principal: PrincipalId) -> bool:
        """Whether somebody could have a robot now, for a while."""
        times = self._times
        if robot in self.barred or not times.sides.ready(robot):
            return False
        if self.holder(robot) not in {None, principal}:
            return False
        if not self.booked(robot):
            return True
        now_ns = times.clock.wall_ns()
        return times.calendar.next_free(robot, now_ns, SHORTEST_TURN_S, principal) <= now_ns

    def turn(self, robot: RobotId) -> tuple[int, int]:
        """Return the start (wall clock) and the length in seconds of a turn from now on.

        It ends where the next slot begins, whosever that is; before one, it begins up to a second
        later, so that nothing lies between them.
        """
        times = self._times
        now_ns, usual_s = times.clock.wall_ns(), times.waiting.limits.usual_s
        following = times.calendar.next_of(robot, now_ns)
        if following is None or following.start_ns >= now_ns + usual_s * SECOND_NS:
            return now_ns, usual_s
        length_s = (following.start_ns - now_ns) // SECOND_NS
        return following.start_ns - length_s * SECOND_NS, length_s
