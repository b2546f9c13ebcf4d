"""Runs one of the ROS 2 code generators, in a process of its own.

Usage: python -P generate.py STEP ARGUMENTS.json. The generators share module-level state and put
themselves in the place of standard output, which is why no gateway may call them in its own
process; and they are slow (seconds for ten actions), so they run side by side.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

# Fast DDS takes two: one to write a message, one to describe it to others.
_WRITING = "rosidl_typesupport_fastrtps_c"
_DESCRIBING = "rosidl_typesupport_introspection_c"


def _idl(arguments: dict[str, Any]) -> None:
    convert = importlib.import_module("rosidl_adapter").convert_to_idl
    source = Path(arguments["source"])
    for file in arguments["ros_interface_files"]:
        convert(
            source,
            arguments["package_name"],
            Path(file).relative_to(source),
            Path(arguments["output_dir"]),
        )


def main(step: str, path: str) -> None:
    """Run one step."""
    if step == "idl":
        _idl(json.loads(Path(path).read_text("utf-8")))
    elif step == "description":
        importlib.import_module("rosidl_generator_type_description").generate_type_hash(path)
    elif step == "c":
        # With descriptions: Fast DDS takes no type without one.
        importlib.import_module("rosidl_generator_c").generate_c(path)
    elif step == "fastrtps":
        importlib.import_module(_WRITING).generate_typesupport_fastrtps_c(path)
    elif step == "introspection":
        importlib.import_module(_DESCRIBING).generate_c(path)
    elif step == "typesupport":
        importlib.import_module("rosidl_typesupport_c").generate_c(path, [_WRITING, _DESCRIBING])
    elif step == "python":
        importlib.import_module("rosidl_generator_py").generate_py(path, ["rosidl_typesupport_c"])


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
