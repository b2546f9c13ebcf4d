"""What is only told: nobody who hears of it decides anything, and nothing is lost if none does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, ParamSpec, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

# ---- deferred ----

# A decision that is made by a part which does not exist yet: refused until it does.

P = ParamSpec("P")
R = TypeVar("R")


class Deferred(Generic[P, R]):
    """Breaks a circle of construction where something is decided (I18).

    Whoever asks takes it as a constructor argument; whoever decides is bound to it once made.

    Args:
        until: Answers until then, and must refuse.
    """

    def __init__(self, until: Callable[P, R]) -> None:
        self._decide = until
        self._bound = False

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Decide."""
        return self._decide(*args, **kwargs)

    def bind(self, decide: Callable[P, R]) -> None:
        """Say who decides from now on.

        Raises:
            RuntimeError: Somebody does already; nobody takes a decision from another.
        """
        if self._bound:
            raise RuntimeError("somebody decides this already")
        self._decide, self._bound = decide, True


# ---- signal ----


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
        """Tell everybody; there is no answer, and who fails at hearing it keeps it from nobody.

        Raises:
            Exception: What the first of them failed with, once all of them were told.
        """
        failed: Exception | None = None
        for hear in self._heard_by:
            try:
                hear(*args, **kwargs)
            except Exception as why:  # noqa: BLE001 - raised below
                failed = failed or why
        if failed is not None:
            raise failed
