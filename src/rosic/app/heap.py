"""The garbage collector of a gateway that has started."""

from __future__ import annotations

import gc

# The collector looks for cycles among young objects whenever so many more were made than freed.
# A command makes some fifty objects and no cycle: at the usual 700 it would look every dozen
# commands. What may lie about uncollected meanwhile is a few megabytes.
YOUNG, MIDDLE, OLD = 50_000, 20, 50


def settle() -> None:
    """Leave what was made at start alone from now on, and look for cycles less often."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)
