"""Generates and compiles one package of ROS 2 interfaces against the ROS 2 wheels.

What colcon and a few hundred lines of CMake do elsewhere: ``.msg``, ``.srv`` and ``.action`` to
IDL, IDL to C and Python, C to one extension module that Python loads.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TypeAlias

from rosic.errors import ConfigurationError, how_to_install
from rosic.robots.ros2.errors import RosMissing
from rosic.robots.ros2.messages.names import check_node_name

KINDS = ("msg", "srv", "action")

Progress: TypeAlias = Callable[[str, float], None]
"""Called with a package and the fraction that is built, in (0, 1]; on several threads."""
GENERATING = 0.4
"""Of the whole time, about; the rest is compiling."""

GENERATOR = Path(__file__).with_name("generate.py")
DISPATCH = Path(__file__).with_name("dispatch.c")
_STEP_S = 600.0  # a few seconds each where nothing else runs; a small computer takes minutes
_VISIBILITY = (
    ("c", "rosidl_generator_c"),
    ("fastrtps", "rosidl_typesupport_fastrtps_c"),
    ("introspection", "rosidl_typesupport_introspection_c"),
    ("typesupport", "rosidl_typesupport_c"),
)
_TEMPLATES = {
    "c": "rosidl_generator_c",
    "fastrtps": "rosidl_typesupport_fastrtps_c",
    "introspection": "rosidl_typesupport_introspection_c",
    "typesupport": "rosidl_typesupport_c",
    "python": "rosidl_generator_py",
}
# What the generated code calls to find a type support, and what it shall call instead.
_OWN_DISPATCH = {
    f"rosidl_typesupport_c__get_{kind}_typesupport_handle_function": f"rosic_find_{kind}"
    for kind in ("message", "service")
}
_LIBRARIES = (
    "rosidl_runtime_c",
    "rosidl_typesupport_c",
    "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_fastrtps_cpp",
    "rosidl_typesupport_introspection_c",
    "rmw",
    "rcutils",
    "fastcdr",
)


def unheard(_package: str, _fraction: float) -> None:
    """Nobody asked how far it is."""


@dataclass(frozen=True)
class InterfacePackage:
    """The sources of one package.

    Attributes:
        name: As it will be imported.
        source: A folder with ``msg``, ``srv`` and ``action`` below it.
    """

    name: str
    source: Path

    def files(self) -> list[Path]:
        """Return its interface files, in a stable order.

        Raises:
            ConfigurationError: There are none.
        """
        check_node_name(self.name)
        found = [file for kind in KINDS for file in sorted((self.source / kind).glob(f"*.{kind}"))]
        if not found:
            raise ConfigurationError(
                f"There is no .msg, .srv or .action file below {self.source}.",
                hint="They belong in folders named msg, srv and action.",
            )
        return found


def check_tools() -> None:
    """Make sure that everything is here that building takes.

    Raises:
        RosMissing: The generators are not installed.
        ConfigurationError: There is no compiler.
    """
    if find_spec("rosidl_generator_py") is None or find_spec("rosidl_adapter") is None:
        raise RosMissing(
            "The ROS 2 generators cannot be used by this Python.",
            hint=f"Run {how_to_install('ros2')}, or build rosic_interfaces with colcon.",
        )
    for tool in ("gcc", "g++"):
        if shutil.which(tool) is None:
            raise ConfigurationError(
                f"Building ROS interfaces takes {tool}, which is not installed.",
                hint="On Debian and Ubuntu: apt-get install gcc g++.",
            )


def build(
    package: InterfacePackage,
    output: Path,
    workers: int | None = None,
    progress: Progress = unheard,
) -> None:
    """Build ``package`` so that it can be imported with ``output`` on the path.

    Args:
        package: What to build. It may use any package that ROS 2 came with.
        output: An empty folder; the sources of the build stay in ``output/_build``.
        workers: How many processes at a time; as many as there are processors by default.
        progress: Told how far it is, from one of several threads; see `Progress`.

    Raises:
        ConfigurationError: An interface file is wrong, or something is missing; the sentence
            carries the tool's own last words.
    """
    files = package.files()
    check_tools()
    work = _Workshop(package, files, output / "_build", progress)
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        work.generate(pool)
        objects = work.compile(pool)
    target = output / package.name
    shutil.copytree(
        work.folder / "python" / package.name, target, ignore=shutil.ignore_patterns("*.c")
    )
    (target / "__init__.py").touch()
    work.link(objects, target)
    progress(package.name, 1.0)


class _Workshop:
    """One build under way."""

    def __init__(
        self, package: InterfacePackage, files: list[Path], folder: Path, progress: Progress
    ) -> None:
        self.package = package
        self._progress = progress
        self._done: list[None] = []  # appending is atomic, adding to a number is not
        self._to_do = 0
        self.folder = folder
        self._files = files
        self._prefix = Path(sys.prefix)
        self._share = self._prefix / "share"
        self._environment = dict(os.environ)
        # gcc must not meet the libraries that the ROS 2 wheels put on the path of every process.
        self._environment_for_tools = {
            name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"
        }

    # ---- generate ----

    def generate(self, pool: ThreadPoolExecutor) -> None:
        """Write C and Python."""
        self._to_do = 2 + len(_TEMPLATES)
        self._step("idl", {"source": str(self.package.source)}, self.folder / "idl")
        self._step("description", self._dependencies())
        described: dict[str, object] = {
            "type_description_tuples": [
                f"{name}:{self.folder / 'description' / self.package.name / name[:-4]}.json"
                for name in self._idl_names()
            ]
        }
        # The slowest first: with two processors they then end together.
        steps: tuple[tuple[str, dict[str, object]], ...]
        steps = (
            ("python", {}),
            ("c", described),
            ("fastrtps", {}),
            ("introspection", {}),
            ("typesupport", {}),
        )
        list(pool.map(lambda step: self._step(*step), steps))
        for step, source in _VISIBILITY:
            self._visibility(step, source)

    def _step(self, step: str, more: dict[str, object], output: Path | None = None) -> None:
        output = output or self.folder / step / self.package.name
        output.mkdir(parents=True, exist_ok=True)
        arguments = {
            "package_name": self.package.name,
            "idl_tuples": [f"{self.folder / 'idl'}:{name}" for name in self._idl_names()],
            "ros_interface_files": [str(file) for file in self._files],
            "target_dependencies": [],
            "output_dir": str(output),
            **more,
        }
        if step in _TEMPLATES:
            arguments["template_dir"] = str(self._share / _TEMPLATES[step] / "resource")
        written = self.folder / f"{step}.json"
        written.write_text(json.dumps(arguments), "utf-8")
        _run(
            # -P: the folder of this file must not shadow what the generators import.
            [sys.executable, "-P", str(GENERATOR), step, str(written)],
            self._environment,
            f"The interfaces of {self.package.name} could not be generated",
        )
        self._advance(0.0, GENERATING)

    def _advance(self, from_: float, share: float) -> None:
        """Say how far it is: ``from_``, and that share of the whole as far as it is done."""
        self._done.append(None)
        self._progress(self.package.name, from_ + share * len(self._done) / self._to_do)

    def _idl_names(self) -> list[str]:
        return [f"{file.parent.name}/{file.stem}.idl" for file in self._files]

    def _dependencies(self) -> dict[str, object]:
        idls = sorted(self._share.glob("*/*/*.idl"))
        packages = {idl.parents[1] for idl in idls}
        return {
            "ros_interface_dependencies": [f"{idl.parents[1].name}:{idl}" for idl in idls],
            "include_paths": [f"{folder.name}:{folder}" for folder in sorted(packages)],
        }

    def _visibility(self, step: str, source: str) -> None:
        """Fill in the header that CMake would: which symbols a library shows."""
        template = self._share / source / "resource" / f"{source}__visibility_control.h.in"
        if not template.exists():
            return
        name = self.package.name
        text = template.read_text("utf-8").replace("@PROJECT_NAME@", name)
        folder = self.folder / step / name / "msg"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / template.name.removesuffix(".in")).write_text(
            text.replace("@PROJECT_NAME_UPPER@", name.upper()), "utf-8"
        )

    # ---- compile ----

    def compile(self, pool: ThreadPoolExecutor) -> list[Path]:
        """Compile everything; returns the object files."""
        (self.folder / "objects").mkdir()
        c_files = sorted((self.folder / "c").rglob("*.c"))
        extension = self.folder / "python" / self.package.name
        units = [
            # Two thirds of the time goes into reading the same headers, so these are read once.
            self._together("fastrtps.cpp", sorted((self.folder / "fastrtps").rglob("*.cpp"))),
            self._together("typesupport.cpp", sorted((self.folder / "typesupport").rglob("*.cpp"))),
            self._together("introspection.c", sorted((self.folder / "introspection").rglob("*.c"))),
            self._together("python.c", sorted(extension.rglob("*_s.c"))),
            *sorted(extension.glob("_*_s.ep.*.c")),
            self._together("dispatch.c", [DISPATCH]),
            *c_files,
        ]
        self._done, self._to_do = [], len(units) + 1
        return list(pool.map(self._compile, units))

    def _together(self, name: str, sources: list[Path]) -> Path:
        unit = self.folder / name
        unit.write_text("".join(f'#include "{source}"\n' for source in sources), "utf-8")
        return unit

    def _compile(self, source: Path) -> Path:
        place = "__".join(source.relative_to(self.folder).parts)
        target = self.folder / "objects" / f"{place}.o"
        compiler = ["g++", "-std=c++17"] if source.suffix == ".cpp" else ["gcc", "-std=gnu11"]
        _run(
            [
                *compiler,
                "-fPIC",
                "-w",
                f'-DROS_PACKAGE_NAME="{self.package.name}"',
                *(f"-D{theirs}={ours}" for theirs, ours in _OWN_DISPATCH.items()),
                *(f"-I{folder}" for folder in self._include()),
                "-c",
                str(source),
                "-o",
                str(target),
            ],
            self._environment_for_tools,
            f"The interfaces of {self.package.name} could not be compiled",
        )
        self._advance(GENERATING, 1.0 - GENERATING)
        return target

    def _include(self) -> list[str]:
        numpy = find_spec("numpy")
        folders = [self.folder / step for step in (*dict(_VISIBILITY), "python")]
        folders += sorted(path for path in (self._prefix / "include").iterdir() if path.is_dir())
        folders += [self._prefix / "include", Path(sysconfig.get_paths()["include"])]
        if numpy is not None and numpy.origin is not None:
            folders.append(Path(numpy.origin).parent / "_core" / "include")
        return [str(folder) for folder in folders]

    def link(self, objects: list[Path], target: Path) -> None:
        """Link one extension module that finds the libraries of ROS 2 by itself."""
        lib = self._prefix / "lib"
        name = (
            f"{self.package.name}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
        )
        used = sorted([*lib.glob("lib*__rosidl_*_c.so"), *lib.glob("lib*__rosidl_generator_py.so")])
        _run(
            [
                "g++",
                "-shared",
                "-o",
                str(target / name),
                *map(str, objects),
                "-Wl,--as-needed",
                f"-L{lib}",
                f"-Wl,-rpath,{lib}",
                *map(str, used),
                *(f"-l{library}" for library in _LIBRARIES),
            ],
            self._environment_for_tools,
            f"The interfaces of {self.package.name} could not be linked",
        )


def _run(command: list[str], environment: dict[str, str], failed: str) -> None:
    try:
        subprocess.run(  # noqa: S603 - our own generators, and compilers found on the path
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=True,
            timeout=_STEP_S,
        )
    except subprocess.TimeoutExpired as error:
        raise ConfigurationError(f"{failed} within {_STEP_S:g} s.") from error
    except subprocess.CalledProcessError as error:
        said = [line for line in error.stderr.splitlines() if line.strip()] or ["nothing was said"]
        raise ConfigurationError(f"{failed}: {_telling(said)}") from error


def _telling(said: list[str]) -> str:
    """Return the line that says most: a compiler's first error, a traceback's last line."""
    errors = [line for line in said if ": error:" in line or ": fatal error:" in line]
    return (errors[0] if errors else said[-1]).strip()
