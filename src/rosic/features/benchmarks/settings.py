"""How robots are set: what was set and read back, merged, and kept over restarts."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.records import Fact
from rosic.gateway.writing import WriteBehind

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.order import Order
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.transactions import Transactions

SETTING: Final = "robot-setting"
MOST_OF_ONE: Final = 256

log = logging.getLogger("rosic.benchmarks")


class BenchmarkSetting(msgspec.Struct, frozen=True, array_like=True):
    """One parameter as a robot's node last confirmed it.

    Attributes:
        by: Who had it set.
        at_ns: Wall clock.
    """

    value: float | int | str | bool
    by: PrincipalId
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(dict[str, BenchmarkSetting]).decode


class BenchmarkSettings:
    """The configuration of each robot, as far as it was set from here: the paper's ``config``.

    A setting counts once the robot's node has taken it and it was read back.

    Attributes:
        of: Robot to parameter to its setting.
    """

    def __init__(self, changes: Transactions, wall_ns: Callable[[], int]) -> None:
        self.of: dict[RobotId, dict[str, BenchmarkSetting]] = {}
        self._wall_ns = wall_ns
        self._behind = WriteBehind(changes)

    def done(self, order: Order) -> None:
        """A skill that sets a robot was done: merge what it set into what is known."""
        skill = order.skill
        if skill.set_parameters is None:
            # A calibration that is a service's own business: that it was done, with what.
            given = {f"{skill.id}.{name}": value for name, value in order.arguments.items()}
            given = given or {skill.id: True}
        else:
            node = skill.set_parameters.node
            given = {
                f"{node}:{name}": _filled(value, order)
                for name, value in skill.set_parameters.values.items()
            }
        at_ns, by = self._wall_ns(), order.permit.principal
        merged = self.of.get(order.robot, {}) | {
            name: BenchmarkSetting(value, by, at_ns) for name, value in given.items()
        }
        kept = dict(list(merged.items())[-MOST_OF_ONE:])
        self.write(Fact(kind=SETTING, key=order.robot, body=_encode(kept)))

    def write(self, fact: Fact) -> None:
        """Let it be so, and write it down: the robot is set already."""
        self.apply(fact)
        self._behind.write((fact,))

    async def written(self) -> None:
        """Wait until everything is written, or noted for later."""
        await self._behind.written()

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is left out, so that others count."""
        if not fact.body:
            self.of.pop(fact.key, None)
            return
        try:
            self.of[fact.key] = _decode(fact.body)
        except msgspec.MsgspecError:
            log.warning("how %s is set cannot be read", fact.key)


def _filled(value: float | str | bool, order: Order) -> float | int | str | bool:
    meaning = order.skill.filled(value, order.arguments)
    if not isinstance(meaning, tuple):
        return meaning
    return str(order.arguments[str(value)[1:].partition(".")[0]])  # a row of numbers, by its word
