"""What people read who command many robots at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said, said_n
from rosic.core.message import Button
from rosic.core.messages import headed

if TYPE_CHECKING:
    from collections.abc import Sequence

HOW_TO: Final = said(
    "Say whom, and what: /together crazyflies takeoff 1 m, /broadcast warehouse wave."
)
NOT_THERE: Final = said("not there")
NO_PART: Final = said("takes no part in the fleet")
STOPPED: Final = said("stopped")
ANOTHERS: Final = said("somebody else has it")
AT_WORK: Final = said("at work")
NOT_AT_REST: Final = said("not at rest")
BATTERY_LOW: Final = said("battery too low")
READY: Final = said("ready")


def none_begins(name: str) -> str:
    """Return that one is not ready, so that none begins."""
    return said("{name}: all or none, and not all are ready. Nobody begins.", name=name)


def did_not_begin(shown: str) -> str:
    """Return why the others are ended, too; it continues a sentence."""
    return said("all or none, and {robot} did not begin", robot=shown)


def state(shown: str, why: str) -> str:
    """Return one robot of the table."""
    return headed(shown, why or READY)


def begin_with(shown: Sequence[str], command: str) -> tuple[tuple[Button, ...], ...]:
    """Return what lets those begin that are ready."""
    label = said("Begin with {robots}", robots=", ".join(shown))
    return ((Button(label, command),),)


def busy(shown: str) -> str:
    """Return that several are at work."""
    return said("{robots} are busy. Ask again when that has ended, or stop them.", robots=shown)


def so_many_more(count: int) -> str:
    """Return that others are in the way, too."""
    return said_n("and one more", "and {n} more", count)


def asked_of(asked: int, altogether: int) -> str:
    """Return how many were asked."""
    return said(
        "{asked} of {altogether} robots are asked. The others:", asked=asked, altogether=altogether
    )
