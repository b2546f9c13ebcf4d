"""Every planted fault still has its place: a line that has moved is noticed without a run."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from tests.planted.every import ALL
from tests.planted.faults import Fault, place

ROOT = Path(__file__).parents[2]


def test_what_a_fault_takes_out_is_there_once() -> None:
    """Else the fault is planted where the line has gone to."""
    moved = [
        f"{fault.name}: {fault.file}"
        for fault in ALL
        if (ROOT / "src" / place(fault.file)).read_text(encoding="utf-8").count(fault.guard) != 1
    ]
    assert not moved


def test_what_is_to_catch_a_fault_is_there() -> None:
    """A whole file, or a test in it by its name."""
    gone = []
    for fault in ALL:
        for caught_by in fault.caught_by:
            file, *names = caught_by.split("::")
            place = ROOT / file
            text = place.read_text(encoding="utf-8") if place.is_file() else ""
            if not all(name.partition("[")[0] in text for name in names) or not place.exists():
                gone.append(f"{fault.name}: {caught_by}")
    assert not gone


def test_faults_are_told_apart() -> None:
    names = [fault.name for fault in ALL]
    assert len(set(names)) == len(names)


def test_every_list_of_faults_is_planted() -> None:
    """A list in a module of its own that nobody reads plants nothing."""
    planted = {fault.name for fault in ALL}
    for file in (ROOT / "tests" / "planted").glob("*faults*.py"):
        module = import_module(f"tests.planted.{file.stem}")
        for name, value in vars(module).items():
            if (
                isinstance(value, tuple)
                and value
                and all(isinstance(each, Fault) for each in value)
            ):
                assert planted.issuperset(fault.name for fault in value), f"{file.name}: {name}"
