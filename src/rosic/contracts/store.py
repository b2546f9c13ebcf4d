"""What the record owes to ROSIC."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.history import HistoryEntry, HistoryQuery
    from rosic.core.records import Fact, Memory, Record
    from rosic.core.robot.profile import RobotId


class Store(Protocol):
    """The record. ``rosic.testing.StoreConformance`` is this in tests."""

    async def open(self) -> Memory:
        """Open, migrate, check that what is written survives power loss, and return what was.

        Raises:
            ConfigurationError: It cannot be used: read-only, in use by another gateway, newer
                than this ROSIC, not durable. Nothing was changed.
        """
        ...

    async def close(self) -> None:
        """Write what is waiting, then close. Never raises."""
        ...

    async def write(self, *records: Record) -> None:
        """Write all or none, in the order of the calls. On return they survive power loss.

        What must not wait may go before the others, in an order of its own: stops, what undoes
        them, locks and keys that are taken back.

        Raises:
            Repeated: A ``Claimed``, ``Refused`` or ``Resumed`` with this id exists. None of these
                records was written; others written at the same time are not affected.
            StoreFault: Not written, and never will be by itself. Writing works again as soon
                as the cause is gone.

        Cancelling the call does not call it back: the cancellation leaves when it is known what
        was written, with the error as its cause if nothing was.
        """
        ...

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Write soon, in order, without waiting; call ``then`` on the event loop afterwards.

        What cannot be written is kept as a note is, and ``then`` is called all the same: once, in
        any case, though perhaps before this returns. Never raises.
        """
        ...

    def note(self, *records: Record) -> None:
        """Write soon, in order, without waiting; lost if the process dies before. Never raises."""
        ...


@runtime_checkable
class ContainerStore(Protocol):
    """What a record owes to whoever looks into containers; both stores keep it.

    Every method raises StoreFault when the record cannot be read now, or changed.
    """

    async def facts(self, kind: str, after: str, limit: int) -> tuple[Fact, ...]:
        """Return at most so many facts of a kind, by key, from behind a key on."""
        ...

    async def container_facts(self, container: str) -> tuple[Fact, ...]:
        """Return everything in a container, unsealed."""
        ...

    async def history(self, query: HistoryQuery) -> tuple[HistoryEntry, ...]:
        """Return commands, the newest first."""
        ...

    async def containers(self) -> tuple[str, ...]:
        """Return whose containers there are."""
        ...

    async def shred(self, container: str) -> None:
        """Erase the key of a container; doing it again is safe."""
        ...


@runtime_checkable
class ForgettingStore(Protocol):
    """A record that can forget commands that are settled and old; both stores keep it."""

    async def prune(self) -> int:
        """Forget them. Return how many.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        ...


@runtime_checkable
class AuditStore(Protocol):
    """A record of administrative acts that can be cut off at its old end; both stores keep it."""

    async def forget_decisions(self, before_ns: int) -> int:
        """Forget acts from before a time. Return how many.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        ...


@runtime_checkable
class FileBackedRecord(Protocol):
    """A record that is kept in files, and notices when one of them is taken away."""

    def lost_file(self) -> str:
        """Return the name of a file that is gone or not as it was left; empty while all are."""
        ...


class StopLatch(Protocol):
    """Where stops survive everything else (I10): needs no free space and no database."""

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        """Return per robot its stop generation and whether it is stopped.

        A damaged entry reads as stopped: the safe side.
        """
        ...

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        """Write one robot's state. On return it survives power loss.

        Raises:
            StoreFault: Not written; the state in memory holds all the same.
        """
        ...


@runtime_checkable
class RepairableStopFile(Protocol):
    """A stop file that can be written again from what is known."""

    async def mend(self) -> None:
        """Write it again if somebody has emptied it or written over it."""
        ...
