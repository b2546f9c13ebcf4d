"""What Fast DDS leaves in ``/dev/shm`` when its process is killed, and what may be removed."""

from __future__ import annotations

import fcntl
import re
import time
from contextlib import suppress
from pathlib import Path

_FOLDER = Path("/dev/shm")  # noqa: S108 - where Fast DDS keeps its files
YOUNG_S = 2.0
_SEGMENT = re.compile(r"fastdds_[0-9a-f]{16}")
_PORT = re.compile(r"fastdds_port(\d+)")
# The ports of domain d, by the rules of RTPS.
_FIRST_PORT, _PORTS_OF_A_DOMAIN = 7400, 250


def sweep(domain_id: int) -> int:
    """Remove what nobody can miss, and return how many files that was.

    Not everything that looks abandoned is. A process that has ended may have been the reader of a
    port to which another still writes; without its file, that one's messages are lost in silence.
    So a file goes only when no process has it mapped, and besides

    - a segment (its name is random, so nobody will open it again) when the lock is free that its
      owner holds as long as it lives;
    - a port of ``domain_id``, which is ours alone.

    Files of the last seconds stay: their process may be about to lock them.
    """
    used = _mapped()
    free = [name for name in _old_names() if name not in used]
    return sum(
        _remove(name)
        for name in free
        if _is_port_of(domain_id, name) or (_SEGMENT.fullmatch(name) and _is_ownerless(name))
    )


def _old_names() -> list[str]:
    names = []
    for file in _FOLDER.glob("fastdds_*"):
        with suppress(FileNotFoundError):
            if time.time() - file.stat().st_ctime > YOUNG_S:
                names.append(file.name)
    return names


def _mapped() -> set[str]:
    found: set[str] = set()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):  # it has ended, or is not ours to look at
            found.update(re.findall(rf"{_FOLDER}/(fastdds_\w+)", maps.read_text()))
    return found


def _is_port_of(domain_id: int, name: str) -> bool:
    match = _PORT.fullmatch(name)
    return match is not None and domain_id == (int(match[1]) - _FIRST_PORT) // _PORTS_OF_A_DOMAIN


def _is_ownerless(segment: str) -> bool:
    try:
        with (_FOLDER / f"{segment}_el").open("r+") as companion:
            fcntl.flock(companion, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # held, or gone
        return False
    return True


def _remove(name: str) -> int:
    files = [_FOLDER / name, _FOLDER / f"{name}_el", _FOLDER / f"sem.{name}_mutex"]
    there = [file for file in files if file.exists()]
    for file in there:
        file.unlink(missing_ok=True)
    return len(there)
