"""What stands beneath an order once it has ended: again, back to its robot, a picture, the menu.

None of these moves anything: again asks first, as everything does that is tapped. So they are bound
to nobody, nothing is kept of them, and they are good for as long as they are shown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.authoriser.buttons import open_button
from rosic.core.message import Button
from rosic.core.saying import Catalogue, in_language, said
from rosic.pipeline.replies import ASK_FIRST

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.pipeline.agreement import Agreements
    from rosic.pipeline.reception import Reception
    from rosic.pipeline.rooms import Rooms

KEPT: Final = 1_024
AGAIN, BACK, MENU = said("Again"), said("Back"), said("Menu")
ALL_ROBOTS: Final = "robots"
LAST: Final = "again"

Row: TypeAlias = tuple[tuple[Button, ...], ...]
Ended: TypeAlias = tuple[str, str, Catalogue | None]
"""Whom it was asked of, a robot or a group; what, as typed; whose language they read."""


class EndButtons(dict[Ended, Row]):
    """The row beneath each end. People repeat themselves, so what was made is found again.

    Bounded, and thrown away whole: what it does not hold is made anew.
    """

    def __init__(self, rooms: Rooms, agreements: Agreements, reception: Reception) -> None:
        super().__init__()
        self._rooms = rooms
        self._agreements = agreements
        self._reception = reception

    def __missing__(self, ended: Ended) -> Row:
        if len(self) >= KEPT:
            self.clear()
        made = [button for button in self._made(ended) if button is not None]
        row = self[ended] = (tuple(made),)
        return row

    def _made(self, ended: Ended) -> Iterator[Button | None]:
        name, text, catalogue = ended
        labels = [in_language(label, catalogue) for label in (AGAIN, BACK, MENU)]
        whole = self._agreements.named_for(name, text)
        # What is too long to be carried is asked by whoever said it last here.
        yield open_button(labels[0], f"{ASK_FIRST}{whole}") or open_button(labels[0], LAST)
        if name in self._rooms.profiles:
            yield open_button(labels[1], f"use {name}")
            for seen in self._reception.sights(name)[:1]:
                yield open_button(in_language(seen.label, catalogue), seen.command)
        elif self._rooms.vocabulary.members(name):
            yield open_button(labels[1], f"help {name}")
        yield open_button(labels[2], ALL_ROBOTS)
