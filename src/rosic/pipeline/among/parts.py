"""What the parts of the fellowship share."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy
    from rosic.contracts.store import Store
    from rosic.pipeline.among.post import Post
    from rosic.pipeline.among.rights import FellowRights
    from rosic.pipeline.changes import Changes
    from rosic.pipeline.reach import Reach
    from rosic.pipeline.rooms import Rooms


class Around(NamedTuple):
    """Who may what, how it changes, how it is told, and what time it is."""

    rights: FellowRights
    rooms: Rooms
    changes: Changes
    reach: Reach
    post: Post
    store: Store
    clock: Clock
    entropy: Entropy
