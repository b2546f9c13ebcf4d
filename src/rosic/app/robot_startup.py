"""What robots begin with: the numbers, leases and stops that earlier runs left them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.order_gate import OrderGate
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.gateway.stopped_by import KIND as STOPPED_BY
from rosic.gateway.stopped_by import restore

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.app.settings import GatewayParts
    from rosic.contracts.robot import Robot
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile, RobotId


def robots_of(
    parts: GatewayParts,
    profiles: Mapping[RobotId, Profile],
    numbers: Mapping[RobotId, tuple[int, int]],
    board: StopRegistry,
) -> dict[RobotId, Robot]:
    """Return the robots, not connected yet, each behind a gate that knows where it was.

    Args:
        parts: Makes adapters.
        profiles: Of the robots.
        numbers: The highest order number and fence of each so far.
        board: What is stopped.
    """
    return {
        robot: parts.robot_factory(profile.link.kind)(
            profile,
            OrderGate(
                robot,
                n=numbers[robot][0],
                fence=numbers[robot][1],
                generation=board[robot].generation,
                latched=board[robot].latched,
            ),
            parts.clock,
        )
        for robot, profile in profiles.items()
    }


def board_of(
    profiles: Mapping[RobotId, Profile], found: Mapping[RobotId, tuple[int, bool]], memory: Memory
) -> StopRegistry:
    """Return which robots are stopped, by whom and since when, as far as earlier runs tell.

    Args:
        profiles: Of the robots.
        found: What the latch says.
        memory: What the record says.
    """
    board = StopRegistry(profiles, stops_of(found, memory.generations), not_known_yet())
    restore(board, memory.facts.get(STOPPED_BY, ()))
    return board


def stops_of(
    found: Mapping[RobotId, tuple[int, bool]], generations: Mapping[RobotId, int]
) -> dict[RobotId, tuple[int, bool]]:
    """Join what the latch and the record say; the higher generation counts (I13).

    A stop that only the record knows holds: the latch could not be written when it was applied.
    """
    joined = dict(found)
    for robot, generation in generations.items():
        if generation > joined.get(robot, (0, False))[0]:
            joined[robot] = (generation, True)
    return joined
