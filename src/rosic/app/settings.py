"""What a gateway is made with: what its place has set, and its adapters."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from rosic.app.people import ConfiguredPerson
from rosic.config.gateway_file import Keep
from rosic.container.files import FileQuota
from rosic.contracts.adapter import RobotFactory
from rosic.contracts.clock import Clock, Entropy
from rosic.contracts.interpreter import Interpreter
from rosic.contracts.messenger import Messenger
from rosic.contracts.recording import Recorder
from rosic.contracts.renderer import Renderer
from rosic.contracts.store import StopLatch, Store
from rosic.core.fleet.mission import Mission
from rosic.core.language import UnitTable
from rosic.core.order_status import Face
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Profile, RobotId


class GatewaySettings(msgspec.Struct, frozen=True, kw_only=True):
    """What a gateway is made with, besides its adapters.

    Attributes:
        rulebook: Roles, care and pre-emption.
        place: Name of this place, as people see it.
        zone: Of the place, an IANA name.
        limit, robot_limits: Of each person; of robots that have one, for everybody together.
        robot_limit: Of robots that are added while it runs; None: they have none.
        lease_idle_s: How long a robot stays somebody's after their last order ended.
        keep: How long what is over is kept.
        room: For files that people keep.
        missions: What several robots do when somebody says so.
    """

    profiles: tuple[Profile, ...]
    people: tuple[ConfiguredPerson, ...] = ()
    rulebook: RoleRules = RoleRules(roles=DEFAULT_ROLES)
    place: str = "rosic"
    zone: str = "UTC"
    limit: RateLimit = RateLimit()
    robot_limits: Mapping[RobotId, RateLimit] = {}
    robot_limit: RateLimit | None = None
    lease_idle_s: float = 60.0
    keep: Keep = Keep()
    missions: tuple[Mission, ...] = ()
    room: FileQuota = FileQuota()


class GatewayParts(msgspec.Struct, frozen=True, kw_only=True):
    """The adapters of a gateway; a test owns each of them.

    Attributes:
        renderer: Draws what is seen; None: people are told that nobody here can.
        interpreter: May be shown what is not understood; None: nobody is.
        recorder: Makes files of what is seen of robots; None: people are told that nobody here can.
    """

    messengers: tuple[Messenger, ...]
    robot_factory: Callable[[str], RobotFactory]
    store: Store
    latch: StopLatch
    clock: Clock
    entropy: Entropy
    units: UnitTable
    face: Face
    renderer: Renderer | None = None
    interpreter: Interpreter | None = None
    recorder: Recorder | None = None
