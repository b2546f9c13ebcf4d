"""Whoever needs one word of the domain imports it first; no other import has to come before."""

from __future__ import annotations

import subprocess
import sys

from tests.cli.running import SOURCE, environment
from tests.pace import pace

# Each in a process forked from one that has imported nothing of ROSIC.
EACH_FIRST = """
import os, pathlib, sys
import msgspec, pint
source = pathlib.Path(sys.argv[1])
for path in sorted((source / "rosic" / "core").rglob("*.py")):
    module = ".".join(path.relative_to(source).with_suffix("").parts).removesuffix(".__init__")
    if not os.fork():
        try:
            __import__(module)
        except ImportError as error:
            print(f"{module}: {error}", flush=True)
        os._exit(0)
    os.wait()
print("all")
"""


def test_every_module_of_the_core_can_be_imported_first() -> None:
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", EACH_FIRST, str(SOURCE)],
        capture_output=True,
        text=True,
        check=True,
        timeout=150 * pace(),
        env=environment(),
    )
    assert done.stdout == "all\n"
