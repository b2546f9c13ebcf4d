"""The event loop of a gateway: a faster one where it is installed (extra ``fast``)."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

T = TypeVar("T")


def _factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    try:
        from uvloop import new_event_loop  # noqa: PLC0415  optional, and only a gateway needs it
    except ImportError:
        return None
    return new_event_loop


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run to its end, as ``asyncio.run`` does."""
    with asyncio.Runner(loop_factory=_factory()) as runner:
        return runner.run(main)


def name() -> str:
    """Return which loop ``run`` takes, for a report."""
    return "asyncio" if _factory() is None else "uvloop"
