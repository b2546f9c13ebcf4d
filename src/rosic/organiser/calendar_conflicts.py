"""What keeps somebody from a robot because of slots, as a value and as a refusal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.robot.profile import RobotId
from rosic.core.slot import BookedSlot
from rosic.errors import NotPermitted, RobotTaken
from rosic.organiser import calendar_messages as words

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.identity import PrincipalId
    from rosic.organiser.timezones import Zone


class SlotTaken(RobotTaken):
    """It is somebody else's time. Nothing was done or booked.

    Attributes:
        slot: The one in the way.
        holder: Whose it is.
        until_ns: When it ends, wall clock.
        next_free_ns: From when on what was asked for is possible.
    """

    def __init__(
        self, sentence: str, *, slot: BookedSlot, next_free_ns: int, offers: tuple[str, ...] = ()
    ) -> None:
        super().__init__(sentence, offers=offers)
        self.slot = slot
        self.holder = slot.principal
        self.until_ns = slot.end_ns
        self.next_free_ns = next_free_ns


class OutsideSlot(NotPermitted):
    """The robot has to be booked, and now is nobody's time. Nothing was done.

    Attributes:
        own: The person's next slot, if they have one.
        next_free_ns: From when on it can be booked.
    """

    def __init__(
        self,
        sentence: str,
        *,
        own: BookedSlot | None,
        next_free_ns: int,
        offers: tuple[str, ...] = (),
    ) -> None:
        super().__init__(sentence, offers=offers)
        self.own = own
        self.next_free_ns = next_free_ns


class SlotConflict(msgspec.Struct, frozen=True, kw_only=True):
    """Why somebody may not move a robot now.

    Attributes:
        now_ns: When this was asked, wall clock.
        required: The robot moves only in a slot.
        slot: Somebody else's, now; None: it is nobody's time.
        own: The person's own next slot with this robot.
        free_ns: From when on nobody else has it: a slot could begin there.
    """

    robot: RobotId
    now_ns: int
    required: bool
    slot: BookedSlot | None
    own: BookedSlot | None
    free_ns: int

    @property
    def holder(self) -> PrincipalId | None:
        """Who has it now."""
        return self.slot.principal if self.slot is not None else None

    @property
    def until_ns(self) -> int | None:
        """Until when they have it."""
        return self.slot.end_ns if self.slot is not None else None

    def refusal(
        self, shown: str, name_of: Callable[[str], str], zone: Zone, useful_s: int
    ) -> SlotTaken | OutsideSlot:
        """Return it as what a person is told.

        Args:
            shown: The robot's title.
            name_of: A principal's name.
            zone: In which they read times.
            useful_s: How long the slot is that they are offered.
        """
        free = self._moment(self.free_ns, zone)
        own = "" if self.own is None else self._moment(self.own.start_ns, zone)
        offers = self._offers(zone, useful_s)
        if self.slot is None:
            told = "" if self.free_ns <= self.now_ns else free
            sentence = words.needs_slot(shown, told, own)
            return OutsideSlot(sentence, own=self.own, next_free_ns=self.free_ns, offers=offers)
        name, until = name_of(self.slot.principal), self._moment(self.slot.end_ns, zone)
        if self.required:
            after = words.yours_at(own) if own else words.free_at(free)
            sentence = words.needs_slot_held(shown, name, until, after)
        else:
            sentence = words.held_now(shown, name, until, free)
        return SlotTaken(sentence, slot=self.slot, next_free_ns=self.free_ns, offers=offers)

    def _moment(self, at_ns: int, zone: Zone) -> str:
        return words.moment(at_ns, self.now_ns, zone)

    def _offers(self, zone: Zone, useful_s: int) -> tuple[str, ...]:
        """Return what would book the next free time, or wait for it.

        Nothing for whoever has a time coming anyway.
        """
        if self.own is not None:
            return ()
        if self.free_ns <= self.now_ns:
            return (f"book {self.robot} now {words.length(useful_s)}",)
        book = words.bookable(self.robot, self.free_ns, useful_s, zone)
        return (book,) if self.slot is None else (book, f"wait {self.robot}")
