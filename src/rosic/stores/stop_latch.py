"""Where stops survive everything else: a small file that needs no free space and no database."""

from __future__ import annotations

import errno
import os
import threading
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.errors import ConfigurationError, StoreFault
from rosic.stores import slots
from rosic.stores.record_files import KeptFiles
from rosic.stores.root_key import create
from rosic.stores.slots import DamagedSlot, SlotState
from rosic.stores.write_thread import WriteJob, WriteThread

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rosic.core.robot.profile import RobotId

GROUP_MAX = 256
QUEUE_MAX = 10_000


class MemoryLatch:
    """Stops that last as long as this object: for tests and ``rosic demo``."""

    def __init__(self) -> None:
        self._states: dict[RobotId, tuple[int, bool]] = {}

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        """Return per robot its stop generation and whether it is stopped."""
        return dict(self._states)

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        """Remember a state, unless a later generation is known."""
        if generation >= self._states.get(robot, (0, False))[0]:
            self._states[robot] = (generation, latched)


class FileLatch:
    """One file, made whole at first use and only overwritten in place from then on.

    Writing has a thread of its own: a database that is stuck delays no stop.

    Args:
        path: Made, for its owner only, by the first ``read`` or ``write``.
        robots_max: Room in a new file.
        robots_min: An existing one with less room is made anew with as much, before anything
            moves; one with more keeps what it has.
        kept: Knows the file while it is open.
        wait_for_disk: Returns when what was written to a descriptor would survive a power cut.
    """

    def __init__(
        self,
        path: Path,
        *,
        robots_max: int = 4096,
        robots_min: int = 0,
        kept: KeptFiles | None = None,
        wait_for_disk: Callable[[int], None] = os.fdatasync,
    ) -> None:
        self._path = path
        self.kept = KeptFiles() if kept is None else kept
        self._wait_for_disk = wait_for_disk
        self._robots_max = max(robots_max, robots_min)
        self._robots_min = robots_min
        self._free: list[int] = []
        self._file: int | None = None
        self._opening = threading.Lock()
        self._writing = threading.Lock()
        self._image = bytearray()  # what is to stand in the file
        self._places: dict[RobotId, int] = {}
        self._states: dict[RobotId, SlotState] = {}
        self._unsure: set[RobotId] = set()
        self._lane: WriteThread[SlotState] | None = None

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        """Return per robot its stop generation and whether it is stopped; meant for the start.

        A damaged entry reads as stopped.

        Raises:
            ConfigurationError: The file cannot be used, or is so damaged that it cannot be said
                which robot is stopped.
        """
        try:
            self._open()
        except DamagedSlot as error:
            raise ConfigurationError(
                f"The stop file {self._path} is damaged.",
                hint="Make sure that every robot is at rest, then remove the file.",
            ) from error
        except OSError as error:
            raise ConfigurationError(
                f"The stop file {self._path} cannot be used ({error.strerror}).",
                hint="Stops would not outlive a restart, so nothing was started.",
            ) from error
        states = list(self._states.values())
        return {state.robot: (state.generation, state.latched) for state in states}

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        """Overwrite one robot's slot; see ``contracts.store``.

        A generation lower than the one that is known changes nothing.
        """
        await self._begun().put(SlotState(robot, generation, latched))

    async def mend(self) -> None:
        """Write the file again if somebody has emptied it or written over it.

        Raises:
            OSError: It is as it was.
        """
        if self._file is not None:
            await self._begun().call(self._mend)

    def _begun(self) -> WriteThread[SlotState]:
        if self._lane is None:
            self._lane = WriteThread(
                "rosic-latch",
                self._settle,
                finish=self._let_go,
                group_max=GROUP_MAX,
                queue_max=QUEUE_MAX,
            )
            self._lane.start()
        return self._lane

    async def close(self) -> None:
        """Write what is waiting and close the file. Never raises."""
        if self._lane is None:
            self._let_go()
        else:
            await self._lane.stop()
            self._lane = None

    def _let_go(self) -> None:
        if self._file is not None:
            self.kept.forget(self._path)
            os.close(self._file)
            self._file = None

    # ---- the file ----

    def _open(self) -> int:
        """Open the file once, and learn what it says.

        Raises:
            DamagedSlot: It cannot be said which robot is stopped.
            OSError: It cannot be opened or made.
        """
        with self._opening:
            if self._file is None:
                self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                self._make_room()
                descriptor = os.open(self._path, os.O_RDWR | os.O_CLOEXEC)
                try:
                    self._learn(descriptor)
                except BaseException:
                    os.close(descriptor)
                    raise
                self.kept.know(self._path, descriptor, is_whole=self._is_whole)
                self._file = descriptor
            return self._file

    def _make_room(self) -> None:
        """See that there is a file, and room in it. A power cut leaves the old one or the new."""
        if not self._path.exists():
            create(self._path, slots.empty_file(self._robots_max))
        elif self._robots_min:
            content = self._path.read_bytes()
            if slots.robots_max_of(content) < self._robots_min:
                create(self._path, slots.enlarged(content, self._robots_min))

    def _learn(self, descriptor: int) -> None:
        content = os.pread(descriptor, os.fstat(descriptor).st_size, 0)
        self._image = bytearray(content)
        room = self._robots_max = slots.robots_max_of(content)
        for index in range(room):
            name, state = slots.name_offset(index), slots.state_offset(index, room)
            place = slots.read_place(
                content[name : name + slots.SLOT_BYTES], content[state : state + slots.SLOT_BYTES]
            )
            if place is not None:
                self._places[place.robot] = index
                known = self._states.get(place.robot)
                if known is None or known.generation <= place.generation:
                    self._states[place.robot] = place
        taken = set(self._places.values())
        self._free = [index for index in reversed(range(room)) if index not in taken]

    # ---- in the thread ----

    def _settle(self, jobs: list[WriteJob[SlotState]]) -> bool:
        """Write the newest state of each robot in place, then wait once for the disk."""
        try:
            descriptor = self._open()
            for job in jobs:
                self._accept(job)
            with self._writing:
                self._overwrite(descriptor)
            self._wait_for_disk(descriptor)
            if self.kept.is_elsewhere(self._path) or not self._is_a_stop_file(descriptor):
                raise FileNotFoundError(errno.ENOENT, "gone or not as written", str(self._path))
        except (OSError, DamagedSlot) as error:
            for job in jobs:
                if job.error is None:
                    fault = StoreFault(said("The stop holds, but could not be kept on disk."))
                    fault.__cause__ = error
                    job.fail(fault)
            return False
        self._unsure.clear()
        return False

    def _accept(self, job: WriteJob[SlotState]) -> None:
        state = job.content
        known = self._states.get(state.robot)
        if known is None:
            if not slots.is_robot(state.robot) or len(self._places) >= self._robots_max:
                job.fail(StoreFault(said("The stop holds, but the stop file has no room for it.")))
                return
            self._places[state.robot] = self._free.pop()
        elif state.generation < known.generation:
            return
        self._states[state.robot] = state
        # Stays here until the disk has confirmed it: what failed is written again with the next.
        self._unsure.add(state.robot)

    def _overwrite(self, descriptor: int) -> None:
        """Write every state the disk has not confirmed, neighbours together.

        Each visit to the file gives up the interpreter's lock, and a busy event loop takes its
        time to give it back: fifty robots are stopped in two visits, not in a hundred.
        """
        places = sorted((self._places[robot], robot) for robot in self._unsure)
        is_whole = self._is_a_stop_file(descriptor)
        for first, robots in _neighbours(places):
            states = b"".join(slots.pack_state(self._states[robot]) for robot in robots)
            names = b"".join(slots.pack_name(robot) for robot in robots)
            for content, at in (
                (states, slots.state_offset(first, self._robots_max)),
                (names, slots.name_offset(first)),
            ):
                self._image[at : at + len(content)] = content
                if is_whole:
                    os.pwrite(descriptor, content, at)
        if not is_whole:
            self._write_again(descriptor)

    # ---- what somebody else has done to it ----

    def _is_whole(self) -> bool:
        """Whether everything stands in the file that was written; from any thread."""
        if self._file is None or not self._writing.acquire(blocking=False):
            return True  # it is being written now, and looked at afterwards
        try:
            return self._stands_in(self._file)
        finally:
            self._writing.release()

    def _is_a_stop_file(self, descriptor: int) -> bool:
        header = os.pread(descriptor, slots.SLOT_BYTES, 0)
        whole = os.fstat(descriptor).st_size == len(self._image)
        return whole and header == self._image[: slots.SLOT_BYTES]

    def _stands_in(self, descriptor: int) -> bool:
        used = 1 + max(self._places.values(), default=-1)
        names_end, states = slots.name_offset(used), slots.state_offset(0, self._robots_max)
        parts = (
            (slots.name_offset(0), names_end),
            (states, states + names_end - slots.name_offset(0)),
        )
        return self._is_a_stop_file(descriptor) and all(
            os.pread(descriptor, end - start, start) == self._image[start:end]
            for start, end in parts
        )

    def _mend(self) -> None:
        if self._file is not None and not self.kept.is_elsewhere(self._path):
            with self._writing:
                if not self._stands_in(self._file):
                    self._write_again(self._file)
            self._wait_for_disk(self._file)

    def _write_again(self, descriptor: int) -> None:
        os.pwrite(descriptor, self._image, 0)
        os.ftruncate(descriptor, len(self._image))


def _neighbours(places: list[tuple[int, RobotId]]) -> list[tuple[int, list[RobotId]]]:
    """Return runs of places that follow each other, as first place and robots."""
    runs: list[tuple[int, list[RobotId]]] = []
    for place, robot in places:
        if runs and place == runs[-1][0] + len(runs[-1][1]):
            runs[-1][1].append(robot)
        else:
            runs.append((place, [robot]))
    return runs
