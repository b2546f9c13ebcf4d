"""docs/architecture.md shows the source as it is: which packages, and who imports whom."""

from __future__ import annotations

from itertools import pairwise
from xml.etree import ElementTree as ET

from tests import architecture
from tests.shape.tree import source

# What the layers of import-linter do not reach, as `rosic_sim` is another root. None may be added.
UPWARDS = {("app", "rosic_sim")}
SVG = "{http://www.w3.org/2000/svg}"


def test_the_picture_is_of_today() -> None:
    drawn = architecture.drawn(source(), architecture.layers())
    assert architecture.PICTURE.read_text(encoding="utf-8") == drawn, "run make texts"


def test_the_tables_are_of_today() -> None:
    page = architecture.PAGE.read_text(encoding="utf-8")
    assert architecture.written(page) == page, "run make texts"


def test_imports_between_packages_point_down() -> None:
    trees = source()
    shown = architecture.rows(architecture.packages_of(trees), architecture.layers())
    height = {row.name: -at for at, row in enumerate(shown)}
    upwards = {
        (importer, imported)
        for importer, imported in architecture.imports_between(trees)
        if importer in height and height[importer] < height[imported]
    }
    assert upwards == UPWARDS


def test_every_package_has_a_row_and_says_what_it_is_for() -> None:
    trees = source()
    shown = architecture.rows(architecture.packages_of(trees), architecture.layers())
    assert sorted(row.name for row in shown) == architecture.packages_of(trees)
    for line in architecture.table(trees, architecture.layers()).splitlines()[2:]:
        assert line.split("|")[3].strip().endswith("."), line


def test_no_label_of_the_picture_lies_on_another() -> None:
    tree = ET.fromstring(architecture.PICTURE.read_text(encoding="utf-8"))  # noqa: S314
    across = [text for text in tree.iter(f"{SVG}text") if text.get("x") is not None]
    by_line: dict[float, list[tuple[float, float]]] = {}
    for text in across:
        wide = 0.65 * float(text.get("font-size", "14")) * len(text.text or "")
        x = float(text.get("x", "0")) - (wide if text.get("text-anchor") == "end" else 0)
        by_line.setdefault(float(text.get("y", "0")), []).append((x, x + wide))
    lines = sorted(by_line)
    assert all(later - earlier >= 16 for earlier, later in pairwise(lines))
    for spans in by_line.values():
        assert all(end < begin for (_, end), (begin, _) in pairwise(sorted(spans))), spans


def test_a_new_import_changes_the_picture_also_where_only_types_are_imported() -> None:
    order = architecture.layers()
    trees = {
        "rosic.core": '"""Words."""',
        "rosic.errors": '"""Errors."""',
        "rosic.linker": '"""Linker."""',
    }
    plain = architecture.drawn(trees, order)
    typed = trees | {"rosic.linker": "if TYPE_CHECKING:\n    from rosic.errors import Fault"}
    upward = trees | {"rosic.core": "import rosic.linker"}

    assert architecture.imports_between(trees) == set()
    assert architecture.imports_between(typed) == {("linker", "errors")}
    assert architecture.drawn(typed, order).count(f'r="8" fill="{architecture.DOWN}"') == 1
    assert architecture.drawn(upward, order).count(f'r="8" fill="{architecture.UP}"') == 1
    assert "<circle" in plain
    assert 'r="8"' not in plain
    assert architecture.drawn(dict(reversed(trees.items())), order) == plain


def test_a_package_that_no_layer_names_is_shown_on_top() -> None:
    trees = {"rosic.core": "", "rosic.novelty": "", "rosic.testing": "", "rosic.contracts": ""}
    shown = architecture.rows(architecture.packages_of(trees), architecture.layers())
    assert [row.name for row in shown] == ["novelty", "testing", "contracts", "core"]
