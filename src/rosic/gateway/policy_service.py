"""Who may do what, kept in step: what is written down, what is in force, what still moves."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions, PolicyInForce, fleet_of
from rosic.core.policy.query import PolicyKey
from rosic.core.policy.scope import Scope
from rosic.core.signal import Signal
from rosic.organiser.grants import GRANT, ROLE, CustomRoles, Grants

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.clock import Clock
    from rosic.core.identity import KeyId, PrincipalId
    from rosic.core.language import UnitTable
    from rosic.core.policy.roles import RoleRules
    from rosic.core.policy.scope import Fleet
    from rosic.core.records import Enrolled, Fact, Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.stop import StopLane
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.grants import OwnLimits


class PolicyPreview(NamedTuple):
    """What the rights would be with other robots.

    Attributes:
        epoch: Of the rights from which it was worked out.
    """

    epoch: int
    fleet: Fleet
    rights: Permissions


class PolicyService:
    """The rights in force, drawn up from the grants; replaced whole whenever it changes.

    Attributes:
        grants_book: Everybody's roles and grants.
        rolebook: What the roles are.
        in_force: What whoever decides by the rights holds.
        when_changed: Tells when what ends by the clock has changed: grants, keys, the clock.

    Args:
        own_limits: Returns what somebody has set for themselves, as the texts of limits.
    """

    def __init__(
        self,
        rulebook: RoleRules,
        profiles: Iterable[Profile],
        units: UnitTable,
        clock: Clock,
        own_limits: OwnLimits,
    ) -> None:
        self.grants_book = Grants(clock, own_limits)
        self.when_changed: Signal[[]] = Signal()
        self.rolebook = CustomRoles(rulebook)
        self._fleet = fleet_of(profiles)
        self._convert = unit_converter(units)
        self.in_force = PolicyInForce(self._drawn_up(1))

    @property
    def rights(self) -> Permissions:
        """Return the present snapshot."""
        return self.in_force.rights

    def _drawn_up(self, epoch: int) -> Permissions:
        everybody = self.grants_book.everybody()
        rules = self.rolebook.rulebook
        return Permissions.draw_up(epoch, rules, self._fleet, everybody, self._convert)

    def restore(self, memory: Memory, roles: Mapping[PrincipalId, tuple[str, ...]]) -> None:
        """Take over what earlier runs wrote; `draw_up` is for afterwards."""
        for principal, names in roles.items():
            self.grants_book.set_roles(principal, names)
        self.grants_book.restore(memory.facts.get(GRANT, ()))
        self.rolebook.restore(memory.facts.get(ROLE, ()))

    def draw_up(self) -> Permissions:
        """Work everything out anew, after the grants was filled."""
        self.in_force.replace(self._drawn_up(self.rights.epoch + 1))
        return self.rights

    # ---- what was written down becomes so ----

    def granted(self, fact: Fact) -> None:
        """A grant was given or has ended."""
        principal = self.grants_book.apply(fact)
        if principal is not None:
            self.renew(principal)
        self.when_changed.emit()

    def ruled(self, fact: Fact) -> None:
        """A role was made, replaced or taken back: every table is drawn up anew."""
        self.rolebook.apply(fact)
        self.draw_up()

    async def foresee(self, profiles: Sequence[Profile]) -> PolicyPreview:
        """Work out the rights if these were the robots, beside the event loop; changes nothing."""
        epoch, rules = self.rights.epoch, self.rolebook.rulebook
        everybody, convert = self.grants_book.everybody(), self._convert

        def work() -> PolicyPreview:
            fleet = fleet_of(profiles)
            return PolicyPreview(
                epoch, fleet, Permissions.draw_up(epoch + 1, rules, fleet, everybody, convert)
            )

        return await asyncio.to_thread(work)

    def add_robot(self, outlook: PolicyPreview) -> None:
        """Let it be so: rights by wildcard and by group reach new robots from now on."""
        self._fleet = outlook.fleet
        if outlook.epoch == self.rights.epoch:
            self.in_force.replace(outlook.rights)
        else:  # somebody's rights have changed since: that must not be undone
            self.draw_up()

    def enrolled(self, record: Enrolled) -> None:
        """Somebody has other roles of their own."""
        self.grants_book.set_roles(record.principal, record.roles)
        self.renew(record.principal)

    def revoked(self, principal: PrincipalId) -> None:
        """Somebody has no key any more: nothing is theirs."""
        self.grants_book.forget(principal)
        self.renew(principal)

    def renew(self, principal: PrincipalId) -> None:
        """Replace the snapshot by one in which a person's rights are those of the grants."""
        grants = self.grants_book.grants_of(principal)
        self.in_force.replace(self.rights.with_grants(self.rights.epoch + 1, principal, grants))

    def moved(self) -> None:
        """Something besides rights has changed: what has not begun yet is admitted once more."""
        self.in_force.replace(self.rights.later())


class PolicyEnforcer:
    """Takes robots from whoever may not have them any more, after every change.

    Attributes:
        policy: What it enforces.

    Args:
        changes: After each of which it looks.
    """

    def __init__(
        self, policy: PolicyService, rooms: Components, stop_lane: StopLane, changes: Transactions
    ) -> None:
        self.policy = policy
        self._rooms, self._stop_lane = rooms, stop_lane
        changes.after(self.enforce)

    def enforce(self) -> tuple[RobotId, ...]:
        """Bring to rest what somebody has who may not have it any more; return which robots.

        Looks at robots, not at people. What is at rest, with nothing under way, is only taken
        from them: a stop would have to be undone by somebody who does not know of it.
        """
        organiser, linker = self._rooms.organiser, self._rooms.linker
        authoriser = self._rooms.authoriser
        ended: list[RobotId] = []
        for robot in self._rooms.profiles:
            holder = organiser.holder(robot)
            if holder is None:
                continue
            order = linker.current(robot)
            skill = None if order is None else order.skill.id
            locked = holder in organiser.locked or not authoriser.has_access(holder)
            gone = robot not in organiser.visible(holder)
            lost = skill is not None and not organiser.allows(holder, robot, skill)
            if locked or gone or lost:
                ended.append(robot)
        moving = tuple(
            r for r in ended if organiser.lease(r).active or not linker.presence(r).at_rest
        )
        if moving:
            self._stop_lane.stop_robots(moving, "")
        for robot in ended:
            organiser.release(robot)
        return tuple(ended)


def key_of(authoriser: Authoriser, key_id: KeyId) -> PolicyKey | None:
    """Return a key as deciding sees it: with the end of its grace, if it was replaced."""
    key = authoriser.directory.key(key_id)
    if key is None:
        return None
    return PolicyKey(
        id=key.id,
        principal=key.principal,
        expires_ns=authoriser.keys.ends_ns(key),
        revoked=key.revoked_ns is not None,
        scopes=tuple(map(Scope.parse, key.scopes)),
    )
