"""Another date for a process and all that it starts: `clock.c`, compiled and preloaded."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

from tests.pace import pace
from tests.servers import needed

SOURCE = Path(__file__).with_name("clock.c")


def compiled(folder: Path) -> Path:
    """Compile it into a folder that exists; skip the test where there is no compiler.

    Raises:
        ValueError: There is a space or a colon in the folder's path; libraries are listed by these.
    """
    if set(str(folder)) & set(" :"):
        raise ValueError(f"nothing can be preloaded from {folder}")
    library = folder / "clock.so"
    command = [needed("gcc"), "-shared", "-fPIC", "-O2", "-Wall", "-Wextra", "-Werror"]
    # A compiler must not meet the libraries that the ROS 2 wheels put on the path of every process.
    own = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
    subprocess.run(  # noqa: S603 - our own source
        [*command, "-o", library, SOURCE, "-ldl"], env=own, check=True, timeout=60 * pace()
    )
    return library


def shifted(library: Path, to_s: float) -> dict[str, str]:
    """Return the environment of a process for which it is so many seconds after 1970."""
    ours_s = int(os.environ.get("ROSIC_SHIFT_S", "0"))  # this one's own, if it has another date
    return {"LD_PRELOAD": str(library), "ROSIC_SHIFT_S": str(round(to_s - time.time()) + ours_s)}
