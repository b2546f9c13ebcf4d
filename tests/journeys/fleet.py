"""The place of these journeys: five robots that are counted, some people, one bot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

TOKEN = "4242424242:journeys-journeys-journeys-journeys"  # noqa: S105 - of the fake server
ROBOTS = ("ant", "bee", "cat", "fly1", "fly2")
GROUP = "flies"

PROFILE = """
id: {name}
title: {shown}
{groups}
link: {{ kind: {link} }}
busy: {busy}
queue_length: {queue_length}
skills:
  hop:
    class: motion
    parameters:
      distance: {{ unit: m, min: 0.01, max: 5, default: 1 }}
  sort:
    class: task
"""

CONFIG = """
[gateway]
data = "data"
lease_idle_s = {lease_idle_s}

[[messenger]]
kind = "telegram"
name = "lab"
token = "{token}"
api_base = "{api_base}"

[limits]
burst = 100000
per_s = 100000
{tables}
"""


class Person(msgspec.Struct, frozen=True):
    """Somebody with an account at the fake server, whose id is also the id of their chat."""

    account: int
    name: str
    role: str = "operator"


def write_place(
    folder: Path,
    api_base: str,
    people: Sequence[Person],
    *,
    link: str = "counting",
    lease_idle_s: float = 1.0,
    queue_length: int = 50,
) -> Path:
    """Write the configuration and the profiles of a gateway; return the file."""
    for name in ROBOTS:
        text = PROFILE.format(
            name=name,
            shown=name.capitalize(),
            groups=f"groups: [{GROUP}]" if name.startswith("fly") else "",
            busy="queue" if name == "bee" else "refuse",
            link=link,
            queue_length=queue_length,
        )
        (folder / f"{name}.yaml").write_text(text)
    robots = [f'[[robot]]\nprofile = "{name}.yaml"' for name in ROBOTS]
    return write_config(folder, api_base, people, robots, lease_idle_s=lease_idle_s)


def write_config(
    folder: Path,
    api_base: str,
    people: Sequence[Person],
    robots: Sequence[str],
    *,
    lease_idle_s: float = 1.0,
) -> Path:
    """Write the configuration of a gateway with these tables of robots; return the file."""
    known = [
        f'[[principal]]\nname = "{p.name}"\naddress = "telegram:{p.account}"\nrole = "{p.role}"'
        for p in people
    ]
    file = folder / "rosic.toml"
    file.write_text(
        CONFIG.format(
            token=TOKEN,
            api_base=api_base,
            lease_idle_s=lease_idle_s,
            tables="\n\n".join([*robots, *known]),
        )
    )
    return file
