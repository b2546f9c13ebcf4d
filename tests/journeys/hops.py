"""How long each hop of one command took, from the clocks of everybody who saw it pass.

All processes are on one machine, so their wall clocks are one clock.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from tests.journeys.record import ask_record

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tests.journeys.lab import Lab

DAY_S = 86_400.0


async def hops_of(
    place: Lab, begun: Mapping[str, Any], message: int, seen: Mapping[str, float]
) -> dict[str, float]:
    """Return when each hop happened, in Unix seconds, in the order of the way.

    Args:
        begun: The server's change with which it began: written, or pressed.
        message: The card that shows the life; its chat is that of ``begun``.
        seen: What the robot's side measured.
    """
    chat = begun["chat_id"]
    changes = await place.control.call("changes", after=begun["seq"])
    delivered = next(c for c in changes if c["kind"] == "delivered" and c["update_ids"])
    card = await place.control.message(chat, message)
    claimed_s, ended_s = newest_life(place.data)
    hops = {
        "put at the server": begun["time_s"],
        "gateway received": delivered["time_s"],
        "claimed on disk": claimed_s,
        "shown in the chat": card["versions"][0]["received_s"],
        **seen,
        "ended on disk": ended_s,
        "told": card["versions"][-1]["received_s"],
    }
    return dict(sorted(hops.items(), key=lambda hop: hop[1]))


def newest_life(data: Path) -> tuple[float, float]:
    """Return when the newest command was claimed, and when it ended."""
    [[claimed_ns, ended_ns]] = ask_record(
        data,
        "select c.at_ns, e.at_ns from commands c join endings e on e.seq = c.seq"
        " where c.kind = 'claimed' order by c.seq desc limit 1",
    )
    return claimed_ns / 1e9, ended_ns / 1e9


def newest_sent_s(log: Path, robot: str, near_s: float) -> float:
    """Return when a gateway's log, which says it at the level debug, last sent a robot an order.

    Args:
        log: Its time of day is that of UTC.
        robot: Its id.
        near_s: A Unix time within half a day of it.
    """
    line = rf"^(\S+) debug \S+: {robot}: order \d+ is sent$"
    found = re.findall(line, log.read_text(), re.MULTILINE)
    hours, minutes, seconds = found[-1].split(":")
    of_day_s = int(hours) * 3600 + int(minutes) * 60 + float(seconds)
    return near_s + (of_day_s - near_s + DAY_S / 2) % DAY_S - DAY_S / 2


def hop_report(title: str, hops: Mapping[str, float]) -> str:
    """Return the hops as lines: since the one before, and since the beginning."""
    lines = [title]
    first = before = next(iter(hops.values()))
    for name, at_s in hops.items():
        lines.append(f"  {name:<24} +{(at_s - before) * 1e3:8.1f} ms {at_s - first:8.3f} s")
        before = at_s
    return "\n".join(lines)
