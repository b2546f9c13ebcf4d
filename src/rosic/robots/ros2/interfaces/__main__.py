"""Builds a package of ROS 2 interfaces, and says where it is."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rosic.errors import ConfigurationError
from rosic.robots.ros2.interfaces.build import InterfacePackage
from rosic.robots.ros2.interfaces.cache import OWN, default_cache, ensure_built


def main(arguments: list[str] | None = None) -> int:
    """Build, and write the folder that belongs on ``PYTHONPATH`` to standard output."""
    parser = argparse.ArgumentParser(
        prog="python -m rosic.robots.ros2.interfaces", description=__doc__
    )
    parser.add_argument(
        "--output", type=Path, default=default_cache(), help="where to keep what is built"
    )
    parser.add_argument("--package", default=OWN.name, help="its name (default: %(default)s)")
    parser.add_argument(
        "--source",
        type=Path,
        default=OWN.source,
        help="a folder with msg, srv and action below it (default: the one that comes with ROSIC)",
    )
    asked = parser.parse_args(arguments)
    try:
        built = ensure_built(
            InterfacePackage(asked.package, asked.source.resolve()), asked.output.resolve()
        )
    except ConfigurationError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(f"{built}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
