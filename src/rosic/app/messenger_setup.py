"""How messengers hand over what they receive: what they ask first, and how a message is known."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import (
    account_of,
    account_since,
    keep_pace_with,
    know_with,
    serve_with,
    settle_with,
)
from rosic.core.records import Fact, Memory
from rosic.core.time_units import MINUTE_NS
from rosic.errors import StoreFault

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.messenger import Messenger, Settle
    from rosic.contracts.store import Store
    from rosic.gateway.components import Components

KIND: Final = "message-identity"
KEY: Final = "account"
SAID_LATELY: Final = "said-lately"
CLOCKS_APART_NS: Final = MINUTE_NS
"""So far apart may a platform's clock and ours be."""
NEVER: Final = 2**62


async def take_in(
    messengers: Iterable[Messenger],
    memory: Memory,
    store: Store,
    rooms: Components,
    settled: Settle,
    now_ns: int,
) -> None:
    """Say to each messenger what it asks before it confirms, who is known, and what to name.

    Args:
        messengers: Those that this gateway speaks through.
        memory: What was on record before.
        store: Where it is written.
        rooms: Know who is known, and where they were met.
        settled: Whether what was received is on disk.
        now_ns: Wall clock.
    """
    messengers = tuple(messengers)
    since_ns = 0
    accounts = Counter(one.platform for one in messengers if account_of(one))
    if accounts:
        since_ns = await _account_since(memory, store, now_ns)
    for messenger in messengers:
        settle_with(messenger, settled)
        know_with(messenger, rooms.authoriser.knows)
        serve_with(messenger, rooms.container.serves)
        account_since(messenger, since_ns, several=accounts[messenger.platform] > 1)
        _keep_pace(messenger, memory, store)


def _keep_pace(messenger: Messenger, memory: Memory, store: Store) -> None:
    """Have what is said kept as far as its platform counts it: it does so over a restart."""
    mine = f"{messenger.name}:"
    facts = memory.facts.get(SAID_LATELY, ())
    kept = {fact.key.removeprefix(mine): fact.body for fact in facts if fact.key.startswith(mine)}

    def keep(name: str, body: bytes) -> None:
        store.note(Fact(kind=SAID_LATELY, key=f"{mine}{name}", body=body))

    keep_pace_with(messenger, kept, keep)


async def _account_since(memory: Memory, store: Store, now_ns: int) -> int:
    """Return since when a message's identity holds the account that received it, for ever.

    What an earlier version followed is on record without it, and may be brought once more: it has
    to be known again (I1). A record that begins now has nothing of the kind. What cannot be written
    down does not hold: then no identity has an account in this run.
    """
    for fact in memory.facts.get(KIND, ()):
        if fact.key == KEY and fact.body.isdigit():
            return int(fact.body)
    since_ns = 0 if memory == Memory() else now_ns + CLOCKS_APART_NS
    try:
        await store.write(Fact(kind=KIND, key=KEY, body=b"%d" % since_ns))
    except StoreFault:
        return NEVER
    return since_ns
