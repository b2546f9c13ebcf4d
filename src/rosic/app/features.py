"""The features of a gateway: found in `rosic.features`, made from one kernel, closed together."""

from __future__ import annotations

import asyncio
import logging
from graphlib import TopologicalSorter
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, TypeVar

from rosic import features
from rosic.core.language.command import Command, CommandTable
from rosic.errors import RosicError
from rosic.gateway import builtin_commands
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping
    from types import ModuleType

    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot


# ---- commands ----

# Every command there is: of the kernel, and of each feature that is installed with it.


def command_table() -> CommandTable:
    """Return the commands of the kernel and of every feature, by what their modules declare.

    A feature declares its own in ``COMMANDS`` of its ``commands.py``; nothing else lists them.

    Raises:
        ValueError: Two of them share a word, or a place on a page or in a menu.
    """
    declared: list[Command] = [*builtin_commands.COMMANDS]
    for feature in sorted(module.name for module in iter_modules(features.__path__)):
        declared += import_module(f"{features.__name__}.{feature}.commands").COMMANDS
    return CommandTable(declared)


# ---- features ----

F = TypeVar("F", bound=Feature)

log = logging.getLogger("rosic.gateway")


def setups() -> tuple[Callable[[Kernel], Feature], ...]:
    """Return the ``setup`` of every package of `rosic.features`, in the order they are made in."""
    names = sorted(module.name for module in iter_modules(features.__path__))
    packages = {name: import_module(f"{features.__name__}.{name}") for name in names}
    return tuple(packages[name].setup for name in in_order(packages))


def in_order(packages: Mapping[str, ModuleType]) -> tuple[str, ...]:
    """Return the names of features, each after those that provide what it needs.

    A package may say which shared parts of the kernel it ``PROVIDES``, and which it ``NEEDS``
    while it is set up.

    Raises:
        graphlib.CycleError: Two need what the other provides.
    """
    provider = {
        part: name for name, each in packages.items() for part in vars(each).get("PROVIDES", ())
    }
    needed = {
        name: [provider[part] for part in vars(each).get("NEEDS", ()) if part in provider]
        for name, each in packages.items()
    }
    return tuple(TopologicalSorter(needed).static_order())


class Features(Feature):
    """All of them, as if they were one."""

    def __init__(self, kernel: Kernel) -> None:
        self._all = tuple(setup(kernel) for setup in setups())

    def find(self, kind: type[F]) -> F | None:
        """Return the feature of a kind; None where this gateway has none."""
        return next((each for each in self._all if isinstance(each, kind)), None)

    def get(self, kind: type[F]) -> F:
        """Return the feature of a kind.

        Raises:
            LookupError: This gateway has none.
        """
        if (found := self.find(kind)) is None:
            raise LookupError(f"there is no {kind.__name__} here")
        return found

    @property
    def quiet(self) -> bool:
        """Whether nothing that somebody asked for is under way."""
        return all(each.quiet for each in self._all)

    async def restore(self) -> None:
        """Finish what an earlier run has left, before any robot is open."""
        for each in self._all:
            await each.restore()

    async def recover(self) -> None:
        """Go on after an interruption: robots are open, and interrupted orders are settled."""
        for each in self._all:
            await each.recover()

    async def run(self) -> None:
        """Have each do what it does on its own, until cancelled. One that fails ends alone."""
        await asyncio.gather(*map(_run, self._all))

    async def each_minute(self) -> None:
        """Do what is due.

        Raises:
            RecordUnavailable: Not all could be written; the rest is tried the next time.
        """
        await self._in_turn(lambda each: each.each_minute())

    async def each_day(self) -> None:
        """Forget what was kept as long as was said.

        Raises:
            RecordUnavailable, StoreFault: Not all was forgotten; the rest is tried again soon.
        """
        await self._in_turn(lambda each: each.each_day())

    async def _in_turn(self, do: Callable[[Feature], Awaitable[None]]) -> None:
        """Have each do something; one that cannot keeps no other from it."""
        unwritten: RosicError | None = None
        for each in self._all:
            try:
                await do(each)
            except RosicError as fault:
                unwritten = unwritten or fault
            except Exception:
                log.exception("%s has not done what was due", type(each).__name__)
        if unwritten is not None:
            raise unwritten

    async def close(self) -> None:
        """Follow nothing any more; wait for robots that come to rest, briefly."""
        await self._side_by_side(lambda each: each.close())

    async def leave(self) -> None:
        """Break off what is under way and keep what was counted; none waits for another."""
        await self._side_by_side(lambda each: each.leave())

    async def _side_by_side(self, do: Callable[[Feature], Awaitable[None]]) -> None:
        found = list(reversed(self._all))
        for each, fault in zip(
            found, await asyncio.gather(*map(do, found), return_exceptions=True), strict=True
        ):
            if isinstance(fault, BaseException):
                log.error("%s did not end well", type(each).__name__, exc_info=fault)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Tell each of one more robot."""
        for each in self._all:
            each.robot_added(newcomer)


async def _run(feature: Feature) -> None:
    try:
        await feature.run()
    except Exception:
        log.exception("%s does nothing on its own any more", type(feature).__name__)
