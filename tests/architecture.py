"""The picture and the tables of docs/architecture.md, drawn from the source as it is.

Run as ``python -m tests.architecture``; a test finds a picture or a table that is of another day.
Imports under ``TYPE_CHECKING`` count. Which row a package has comes from the layers that
import-linter is given; which imports there are comes from the source alone.
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple
from xml.sax.saxutils import escape

from tests.shape import measures
from tests.shape.tree import source

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "architecture.md"
PICTURE: Final = ROOT / "docs" / "images" / "imports.svg"
BEGIN: Final = "<!-- {name}: written by make texts -->\n"
END: Final = "<!-- end of {name} -->\n"
# What the layers leave out stands right above one of them.
BESIDE: Final = {"testing": "contracts", "rosic_sim": "app"}

CELL: Final = 32
LEFT: Final = 250
TOP: Final = 120
DOWN: Final = "#0284c7"
UP: Final = "#b91c1c"


class Row(NamedTuple):
    """A package, and which layer it is of, counted from below; 0: of none."""

    name: str
    layer: int


def layers() -> list[list[str]]:
    """Return the layers that import-linter is given, from above; each as its packages."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    [contract] = [c for c in settings["tool"]["importlinter"]["contracts"] if c["id"] == "layers"]
    return [[name.strip(" ()") for name in line.split("|")] for line in contract["layers"]]


def package_of(module: str) -> str:
    """Return the package of a module as the picture calls it; empty for the root itself."""
    root, _, inner = module.partition(".")
    return inner.partition(".")[0] if root == "rosic" else root


def imports_between(trees: Mapping[str, str]) -> set[tuple[str, str]]:
    """Return which package imports which: how often changes with every commit, whether seldom."""
    graph = measures.imports({name: ast.parse(text) for name, text in trees.items()})
    pairs = (
        (package_of(name), package_of(target))
        for name, targets in graph.items()
        for target in targets
    )
    return {pair for pair in pairs if pair[0] != pair[1] and all(pair)}


def rows(packages: Sequence[str], order: Sequence[Sequence[str]]) -> list[Row]:
    """Return the packages from above, each under what may import it."""
    found: list[Row] = []
    for number, layer in enumerate(order):
        found += [
            Row(name, 0) for name, below in BESIDE.items() if name in packages and below in layer
        ]
        found += [Row(name, len(order) - number) for name in layer if name in packages]
    rest = sorted(set(packages) - {row.name for row in found})
    return [*(Row(name, 0) for name in rest), *found]


def packages_of(trees: Mapping[str, str]) -> list[str]:
    """Return the names of the packages."""
    return sorted({package_of(name) for name in trees} - {"", "__main__"})


def drawn(trees: Mapping[str, str], order: Sequence[Sequence[str]]) -> str:
    """Return the picture: one row for each package, with a dot under each that it imports."""
    found, shown = imports_between(trees), rows(packages_of(trees), order)
    side = len(shown) * CELL
    width, height = LEFT + side + 90, TOP + side + 70
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
        ' font-family="DejaVu Sans, Verdana, sans-serif" font-size="14" fill="#0f172a">'
    )
    return "\n".join(
        (
            head,
            "  <title>Which package of ROSIC imports which</title>",
            f'  <rect width="{width}" height="{height}" rx="14" fill="#f8fafc"/>',
            *_grid(shown),
            *_dots(shown, found),
            *_legend(TOP + side),
            "</svg>\n",
        )
    )


def _grid(shown: Sequence[Row]) -> Iterator[str]:
    side = len(shown) * CELL
    for at, row in enumerate(shown):
        y, x = TOP + at * CELL, LEFT + at * CELL
        fill = "#ffffff" if row.layer % 2 else "#f1f5f9"
        yield f'  <rect x="14" y="{y}" width="{LEFT - 14 + side}" height="{CELL}" fill="{fill}"/>'
        yield f'  <text x="{LEFT - 12}" y="{y + 21}" text-anchor="end">{escape(row.name)}</text>'
        layer = f"layer {row.layer}" if row.layer else "beside"
        yield f'  <text x="24" y="{y + 21}" font-size="12" fill="#475569">{layer}</text>'
        yield f'  <rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="#94a3b8"/>'
        yield (
            f'  <text transform="translate({x + 20} {TOP - 10}) rotate(-45)">'
            f"{escape(row.name)}</text>"
        )


def _dots(shown: Sequence[Row], found: Collection[tuple[str, str]]) -> Iterator[str]:
    for i, importer in enumerate(shown):
        for j, imported in enumerate(shown):
            if (importer.name, imported.name) in found:
                x, y = LEFT + j * CELL + CELL // 2, TOP + i * CELL + CELL // 2
                yield f'  <circle cx="{x}" cy="{y}" r="8" fill="{DOWN if j > i else UP}"/>'


def _legend(y: int) -> Iterator[str]:
    for at, colour, said in (
        (30, DOWN, "the package of the row imports that of the column, which stands below it"),
        (54, UP, "the same, upwards"),
    ):
        yield f'  <circle cx="{LEFT + 8}" cy="{y + at - 5}" r="6" fill="{colour}"/>'
        yield f'  <text x="{LEFT + 24}" y="{y + at}" font-size="13">{said}</text>'


def table(trees: Mapping[str, str], order: Sequence[Sequence[str]]) -> str:
    """Return what each package is for, in the first sentence of its own text."""
    head = ("| layer | package | what it is for |", "|---|---|---|")
    return "\n".join((*head, *_table_rows(trees, order))) + "\n"


def _table_rows(trees: Mapping[str, str], order: Sequence[Sequence[str]]) -> Iterator[str]:
    for row in rows(packages_of(trees), order):
        whole = row.name if row.name in trees else f"rosic.{row.name}"
        said = (ast.get_docstring(ast.parse(trees[whole])) or "").partition("\n")[0]
        yield f"| {row.layer or ''} | `{whole}` | {said.replace('``', '`')} |"


def feature_table(trees: Mapping[str, str]) -> str:
    """Return what each feature is for."""
    lines = ["| feature | what it is for |", "|---|---|"]
    for name, text in trees.items():
        folder, _, feature = name.rpartition(".")
        if folder == "rosic.features" and any(other.startswith(f"{name}.") for other in trees):
            said = (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0]
            lines.append(f"| `{feature}` | {said.replace('``', '`')} |")
    return "\n".join(lines) + "\n"


def with_part(page: str, name: str, text: str) -> str:
    """Return a page with one of its written parts in its place."""
    begin, end = BEGIN.format(name=name), END.format(name=name)
    head, _, rest = page.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}{text}{end}{tail}"


def written(page: str) -> str:
    """Return the page with its tables as the source is now."""
    trees, order = source(), layers()
    page = with_part(page, "packages", table(trees, order))
    return with_part(page, "features", feature_table(trees))


if __name__ == "__main__":
    PICTURE.write_text(drawn(source(), layers()), encoding="utf-8")
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
