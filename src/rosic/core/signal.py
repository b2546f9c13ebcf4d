"""What is only told: nobody who hears of it decides anything, and nothing is lost if none does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, ParamSpec

if TYPE_CHECKING:
    from collections.abc import Callable

P = ParamSpec("P")


class Signal(Generic[P]):
    """Tells whoever is connected, in the order in which they were.

    What decides is no signal: it is a constructor argument, or a `Deferred` (I18).
    """

    __slots__ = ("_heard_by",)

    def __init__(self) -> None:
        self._heard_by: tuple[Callable[P, object], ...] = ()

    def connect(self, hear: Callable[P, object]) -> None:
        """Tell somebody more from now on."""
        self._heard_by = (*self._heard_by, hear)

    def emit(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Tell everybody; there is no answer."""
        for hear in self._heard_by:
            hear(*args, **kwargs)
