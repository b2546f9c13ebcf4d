"""How large the source is and how it hangs together: figures of one tree, and the bounds they keep.

Every figure that the documentation names comes from here (`python -m tests.shape`). Imports under
`TYPE_CHECKING` count as imports: a circle of types is a circle for whoever reads.
"""

from __future__ import annotations

import ast
from collections import Counter
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SMALL_LINES = 60
# Makes the parts of a gateway: what it sets into one that is made is a collaborator come too late.
COMPOSITION = "rosic.app"


class Figures(NamedTuple):
    """The figures of one tree; lists name what is counted, so that it can be mended."""

    modules: int
    lines: int
    median_lines: float
    largest_lines: int
    small: list[str]
    import_share: float
    circles: list[list[str]]
    set_from_outside: list[str]
    wired_late: list[str]
    named_twice: list[str]


def figures(trees: Mapping[str, str]) -> Figures:
    """Measure a tree.

    Args:
        trees: The text of each module by its dotted name; a package by its own, whose few lines
            are no module's.
    """
    parsed = {name: ast.parse(text) for name, text in trees.items()}
    outside = sorted(
        found for name, tree in parsed.items() for found in set_from_outside(name, tree)
    )
    packages = {name.rpartition(".")[0] for name in trees}
    sizes = {n: len(text.splitlines()) for n, text in trees.items() if n not in packages}
    graph = imports(parsed)
    return Figures(
        modules=len(sizes),
        lines=sum(sizes.values()),
        median_lines=median(sizes.values()),
        largest_lines=max(sizes.values()),
        small=small(sizes, graph),
        import_share=_import_lines(parsed.values()) / sum(sizes.values()),
        circles=circles(graph),
        set_from_outside=outside,
        wired_late=wired_late(outside),
        named_twice=named_twice(parsed),
    )


def imports(parsed: Mapping[str, ast.Module]) -> dict[str, set[str]]:
    """Return which modules of the tree each module imports, wherever in it, types as well."""
    graph: dict[str, set[str]] = {name: set() for name in parsed}
    for name, tree in parsed.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    whole = f"{node.module}.{alias.name}"
                    target = whole if whole in parsed else node.module
                    if target in parsed and target != name:
                        graph[name].add(target)
            elif isinstance(node, ast.Import):
                graph[name] |= {alias.name for alias in node.names} & parsed.keys() - {name}
    return graph


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """Return the groups of modules of which each reaches every other."""
    reached = {name: _reached(graph, name) for name in graph}
    groups = {
        tuple(sorted(other for other in reached[name] if name in reached[other]))
        for name in graph
        if name in reached[name]
    }
    return sorted(list(group) for group in groups)


def _reached(graph: Mapping[str, set[str]], start: str) -> set[str]:
    reached: set[str] = set()
    ahead = list(graph[start])
    while ahead:
        name = ahead.pop()
        if name not in reached:
            reached.add(name)
            ahead.extend(graph[name])
    return reached


def small(sizes: Mapping[str, int], graph: Mapping[str, set[str]]) -> list[str]:
    """Return the modules of few lines that at most one other imports."""
    importers = Counter(target for targets in graph.values() for target in targets)
    return sorted(
        name for name, lines in sizes.items() if lines < SMALL_LINES and importers[name] <= 1
    )


def set_from_outside(name: str, tree: ast.Module) -> list[str]:
    """Return where an attribute is set into an object that is not the one whose method it is.

    What a function has made itself by a call it may still finish; what it was given, what it holds
    in an attribute, and what stands at the top of the module it may not.
    """
    found: list[str] = []
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        made = {
            target.id
            for node in ast.walk(function)
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        for node in ast.walk(function):
            targets: Iterable[ast.expr] = ()
            if isinstance(node, ast.Assign):
                targets = node.targets
            elif isinstance(node, ast.AugAssign | ast.AnnAssign):
                targets = (node.target,)
            found.extend(
                f"{name}:{target.lineno} {ast.unparse(target)}"
                for target in targets
                if isinstance(target, ast.Attribute) and not _own(target.value, made)
            )
    return sorted(set(found))


def wired_late(outside: Iterable[str]) -> list[str]:
    """Return which of the attributes set from outside the composition root sets.

    The others are mostly records that one family of modules fills while it works on them; these
    are collaborators and callables that a finished object should have been made with.
    """
    return [found for found in outside if found.startswith(f"{COMPOSITION}.")]


def _own(owner: ast.expr, made: set[str]) -> bool:
    return isinstance(owner, ast.Name) and (owner.id in {"self", "cls"} or owner.id in made)


def named_twice(parsed: Mapping[str, ast.Module]) -> list[str]:
    """Return the public classes whose name another module has as well."""
    places: dict[str, list[str]] = {}
    for name, tree in parsed.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places.setdefault(node.name, []).append(name)
    return sorted(
        f"{name}: {', '.join(sorted(where))}" for name, where in places.items() if len(where) > 1
    )


def _import_lines(trees: Iterable[ast.Module]) -> int:
    return sum(
        (node.end_lineno or node.lineno) - node.lineno + 1
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
