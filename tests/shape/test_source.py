"""The shape of everything that is, or is about to be, committed."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

import pytest

from tests.shape import rules

ROOT = Path(__file__).parents[2]
# What people read or run; tests may say what the product may not.
# Everything between a messenger and a robot's adapter, and what reads profiles.
KNOWS_NO_ROS = tuple(
    f"src/rosic/{folder}/"
    for folder in (
        "authoriser",
        "config",
        "container",
        "contracts",
        "core",
        "features",
        "gateway",
        "linker",
        "messengers",
        "organiser",
        "rendering",
        "stores",
    )
)
PUBLISHED = ("src/", "docs/", "examples/", "robots/")


@cache
def files() -> tuple[str, ...]:
    """Every file that git tracks or would track, by its path from the root."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],  # noqa: S607
        cwd=ROOT,
        capture_output=True,
        check=False,
    )
    if listing.returncode:
        pytest.skip("The shape is checked in a git checkout; this folder is none.")
    names = filter(None, listing.stdout.decode().split("\0"))
    return tuple(name for name in names if (ROOT / name).is_file())


@cache
def texts() -> dict[str, str]:
    """Every one of them that is a text."""
    contents = {name: (ROOT / name).read_bytes() for name in files()}
    return {
        name: content.decode(errors="replace")
        for name, content in contents.items()
        if b"\0" not in content
    }


def modules(*folders: str) -> dict[str, str]:
    return {
        path: text
        for path, text in texts().items()
        if path.startswith(folders) and path.endswith(".py")
    }


def published() -> dict[str, str]:
    return {
        path: text
        for path, text in texts().items()
        if (path.startswith(PUBLISHED) or ("/" not in path and path.endswith(".md")))
        and not path.endswith(("/LICENSE", "/lexicon.toml", ".css"))  # somebody else's words
        and "/console/static/vendor/" not in path
    }


def test_no_module_has_outgrown_one_reason_to_change() -> None:
    assert rules.too_long(modules("src/", "tests/")) == []


def test_every_name_says_what_belongs_there() -> None:
    assert rules.vaguely_named(modules("src/", "tests/")) == []


def test_tests_lie_where_what_they_test_lies() -> None:
    assert rules.without_source(modules("tests/"), modules("src/")) == []


def test_the_stop_is_never_called_what_it_is_not() -> None:
    assert rules.claims_of_safety(published()) == []


def test_only_the_adapter_of_a_graph_speaks_of_ros() -> None:
    found = modules(*KNOWS_NO_ROS)

    assert {path.split("/")[2] for path in found} == {f.split("/")[2] for f in KNOWS_NO_ROS}
    assert rules.words_of_ros(found) == []


def test_nothing_points_at_one_machine_or_one_download_site() -> None:
    assert rules.traces_of_a_machine(texts()) == []


def test_the_spelling_is_british() -> None:
    assert rules.american_spellings(published()) == []


def test_every_link_between_pages_leads_somewhere() -> None:
    pages = {path: text for path, text in texts().items() if path.endswith(".md")}

    assert rules.broken_links(pages, files()) == []


def test_every_package_says_what_it_is_for() -> None:
    assert rules.without_docstring(modules("src/")) == []


def test_nothing_else_has_the_name_of_what_makes_a_sentence_translatable() -> None:
    assert rules.hidden_translators(modules("src/")) == []


def test_every_exception_that_a_docstring_names_is_there() -> None:
    assert rules.unknown_exceptions(modules("src/")) == []
