"""What there is to see of each robot now, looked at once for all cards that show it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined
from rosic.core.messages import named_of, rest_unmeasured, unmeasured
from rosic.core.robot.profile import Slots
from rosic.features.dashboard import messages as words

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.core.order_status import Face
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.order_execution import OrderExecutor, RunningOrder


class RobotSnapshots:
    """The newest look at each robot.

    A number beside it grows whenever there is something new to see: a card compares numbers. While
    nobody looks, orders are not followed.

    Attributes:
        benchmark: Returns what is to be said of a robot against its benchmarks; None: nobody knows.
    """

    def __init__(self, rooms: Components, lives: OrderExecutor, face: Face) -> None:
        self._rooms = rooms
        self._lives = lives
        self._face = face
        self.benchmark: Callable[[RobotId], str] | None = None
        self._seen: dict[RobotId, tuple[int, str]] = {}
        self._followed: dict[RobotId, RunningOrder] = {}

    def begin(self) -> None:
        """Follow orders from now on, those under way included."""
        self._followed = self._lives.follow()

    def end(self) -> None:
        """Follow nothing any more."""
        self._lives.leave_off()
        self._followed = {}

    def look(self, robots: Iterable[RobotId]) -> None:
        """Look at these robots."""
        for robot in robots:
            text = joined("\n", self._lines(robot))
            number, before = self._seen.get(robot, (0, ""))
            if text != before:
                self._seen[robot] = (number + 1, text)

    def number(self, robot: RobotId) -> int:
        """Return how often there was something new to see."""
        return self._seen[robot][0]

    def text(self, robot: RobotId, *, named: bool = True) -> str:
        """Return what there is to see; perhaps without the names of people."""
        return self._seen[robot][1] if named else joined("\n", self._lines(robot, named=False))

    # ---- one robot ----

    def _lines(self, robot: RobotId, *, named: bool = True) -> Iterator[str]:
        linker, profile = self._rooms.linker, self._rooms.profiles[robot]
        presence, queued = linker.presence(robot), linker.waiting(robot)
        states = [
            self._stopped(robot, named=named),
            self._holder(robot, named=named),
            words.waiting(queued) if queued else "",
            words.battery(profile, presence),
            words.link(presence),
        ]
        yield words.head(profile, [state for state in states if state])
        life = self._followed.get(robot)
        if life is not None:
            what = _what(life)
            yield from (words.step(step, what) for step in life.shown.steps)
        measured = self.benchmark(robot) if self.benchmark is not None else ""
        if measured:
            yield words.benchmark(measured)
        done = life.shown.now(briefly=not named) if life is not None else ""
        if done:
            yield words.now(done)
        elif presence.doing:
            yield words.now(words.doing(named_of(profile, presence.doing)))
        elif presence.at_rest:
            yield words.now(words.at_rest())
        elif rest_unmeasured(profile, presence):
            yield words.now(unmeasured(presence))

    def _stopped(self, robot: RobotId, *, named: bool) -> str:
        entry = self._rooms.board[robot]
        if not entry.latched:
            return ""
        name = self._rooms.organiser.name_of(entry.by) if entry.by and named else ""
        return words.stopped(name, self._face(entry.since_ns) if entry.since_ns else "")

    def _holder(self, robot: RobotId, *, named: bool) -> str:
        organiser = self._rooms.organiser
        calendar, now_ns = organiser.calendar, organiser.wall_ns()
        booked = self._rooms.profiles[robot].slots is not Slots.NONE and calendar.has_slots(robot)
        slot = calendar.present(robot, now_ns) if booked else None
        who = organiser.whose(robot)
        if who is not None:
            ends = slot is not None and slot.principal == who
            # On the place's clocks, as all of a card: others look at it as well.
            until = organiser.moment("", slot.end_ns) if slot is not None and ends else ""
            return words.theirs(organiser.name_of(who) if named else words.taken(), until)
        following = calendar.next_of(robot, now_ns) if booked else None
        return words.free("" if following is None else organiser.moment("", following.start_ns))


def _what(life: RunningOrder) -> str:
    """Return what was asked; what somebody wrote freely is theirs, and stays in their own chat."""
    skill = life.order.skill
    if any(parameter.text for parameter in skill.parameters.values()):
        return skill.shown
    return words.short(life.order.words)
