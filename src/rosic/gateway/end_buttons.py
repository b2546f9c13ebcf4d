"""What stands beneath an order once it has ended: again, back to its robot, a picture, the menu.

None of these moves anything: again asks first, as everything does that is tapped. So they are bound
to nobody, nothing is kept of them, and they are good for as long as they are shown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.authoriser.button_tokens import open_button
from rosic.core.i18n import Catalogue, in_language, said
from rosic.core.language.parser import REMEMBERED
from rosic.core.message import Button
from rosic.gateway.replies import ASK_FIRST

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.gateway.agreement import Agreements
    from rosic.gateway.components import Components
    from rosic.gateway.hooks import PipelineHooks

KEPT: Final = REMEMBERED
"""Rows: one for each text that is remembered."""
AGAIN, BACK, MENU = said("Again"), said("Back"), said("Menu")
ALL_ROBOTS: Final = "robots"
LAST: Final = "again"
SEVERAL: Final = "+"
"""Between robots that are named one by one."""
NAMED: Final = 3

Row: TypeAlias = tuple[tuple[Button, ...], ...]
Ended: TypeAlias = tuple[str, str, Catalogue | None]
"""Whom it was asked of, a robot or a group; what, as typed; whose language they read."""


class EndButtons(dict[Ended, Row]):
    """The row beneath each end. People repeat themselves, so what was made is found again.

    Bounded, and thrown away whole: what it does not hold is made anew.
    """

    def __init__(self, rooms: Components, agreements: Agreements, hooks: PipelineHooks) -> None:
        super().__init__()
        self._rooms = rooms
        self._agreements = agreements
        self._hooks = hooks
        self._lasting: dict[tuple[str, Catalogue | None], tuple[Button, ...]] = {}

    def __missing__(self, ended: Ended) -> Row:
        if len(self) >= KEPT:
            self.clear()
        name, text, catalogue = ended
        lasting = self._lasting.get((name, catalogue))
        if lasting is None:
            lasting = self._lasting[name, catalogue] = tuple(self._after(name, catalogue))
        again = self._again(name, text, catalogue)
        row = self[ended] = (lasting if again is None else (again, *lasting),)
        return row

    def clear(self) -> None:
        """Make everything anew from now on."""
        super().clear()
        self._lasting.clear()

    def of_task(self, whom: str, again: str, catalogue: Catalogue | None) -> Row:
        """Return the row beneath the end of a task.

        Args:
            whom: The robot that had it, else whom it was for; empty: any.
            again: What gives it anew; empty, or too long to be carried: it is not offered.
            catalogue: Whose language its author reads.
        """
        made = [open_button(in_language(AGAIN, catalogue), f"{ASK_FIRST}{again}")] if again else []
        return (tuple(button for button in (*made, *self._after(whom, catalogue)) if button),)

    def _after(self, whom: str, catalogue: Catalogue | None) -> Iterator[Button]:
        """Yield what stands behind `AGAIN`."""
        found = (
            *self._back(whom, catalogue),
            open_button(in_language(MENU, catalogue), ALL_ROBOTS),
        )
        yield from (button for button in found if button is not None)

    def _back(self, name: str, catalogue: Catalogue | None) -> Iterator[Button | None]:
        """Yield the way back to whom it was asked of, and a picture where one is to be had."""
        label, profiles = in_language(BACK, catalogue), self._rooms.profiles
        name = name.casefold()
        if name in profiles:
            yield open_button(label, f"use {name}")
            for seen in self._hooks.view_buttons(name)[:1]:
                yield open_button(in_language(seen.label, catalogue), seen.command)
        elif self._rooms.vocabulary.members(name):
            yield open_button(label, f"help {name}")
        else:  # several that were named one by one: to each
            for robot in [robot for robot in name.split(SEVERAL) if robot in profiles][:NAMED]:
                yield open_button(profiles[robot].shown, f"use {robot}")

    def _again(self, name: str, text: str, catalogue: Catalogue | None) -> Button | None:
        label, whole = in_language(AGAIN, catalogue), self._agreements.named_for(name, text)
        # What is too long to be carried is asked by whoever said it last here.
        return open_button(label, f"{ASK_FIRST}{whole}") or open_button(label, LAST)
