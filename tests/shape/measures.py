"""How large the source is and how it hangs together: figures of one tree, and the bounds they keep.

Every figure that the documentation names comes from here (`python -m tests.shape`). Imports under
`TYPE_CHECKING` count as imports: a circle of types is a circle for whoever reads.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SMALL_LINES = 60
# Makes the parts of a gateway: what it sets into one that is made is a collaborator come too late.
COMPOSITION = "rosic.app"
# Every feature has these, however short: `rosic.app.features` finds its commands by their name, and
# its sentences have a place of their own (docs/decisions/0016).
OF_EVERY_FEATURE = re.compile(r"rosic\.features\.\w+\.(?:commands|messages)")
# Objects of types that are not ours, by the module and the name that they have there.
FOREIGN = frozenset(
    f"{module} {name}"
    for module, names in {
        "rosic.container.export": "sheet",
        "rosic.robots.ros2.client.topics": "message",
        "rosic.robots.ros2.messages.encode": "message",
        "rosic_sim.ros2.machine_node": "response place speed goal",
        "rosic_sim.ros2.reports": "message place speed pose twist",
        "rosic_sim.ros2_others.arm_robot": "message",
        "rosic_sim.ros2_others.nav2_robot": "message pose battery",
    }.items()
    for name in names.split()
)


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
        name
        for name, lines in sizes.items()
        if lines < SMALL_LINES and importers[name] <= 1 and not OF_EVERY_FEATURE.fullmatch(name)
    )


def set_from_outside(name: str, tree: ast.Module) -> list[str]:
    """Return where an attribute is set into an object that is not the one whose method it is.

    Not counted is what has no owner that could do it better:

    - what a function has made itself by a call, and may still finish: not in the composition
      root, where whatever is set later is something that should have been an argument (I18);
    - fields of a record (nothing but fields) that the same module defines: it is that module's own
      way to keep things together, and no other module is surprised;
    - messages of ROS and sheets of a workbook, whose types are others' and have no methods for it.

    Args:
        name: The module's, dotted.
        tree: What is in it.
    """
    found: list[str] = []
    fields = _fields_of_records(tree)
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        made = set() if name.startswith(f"{COMPOSITION}.") else _made(function)
        found.extend(
            f"{name}:{target.lineno} {ast.unparse(target)}"
            for target in _set(function)
            if not _own(target.value, made)
            and not (isinstance(target.value, ast.Name) and target.attr in fields)
            and f"{name} {_root(target)}" not in FOREIGN
        )
    return sorted(set(found))


def _set(function: ast.AST) -> Iterable[ast.Attribute]:
    """Yield what a function sets, several at once and by name (`setattr`) as well."""
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node
        elif (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "setattr"
        ):
            yield ast.copy_location(ast.Attribute(node.args[0], "setattr", ast.Store()), node)


def _made(function: ast.AST) -> set[str]:
    return {
        target.id
        for node in ast.walk(function)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def _fields_of_records(tree: ast.Module) -> set[str]:
    """Return the fields of a module's records that no class of it with methods has as well."""
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    fields: dict[bool, set[str]] = {True: set(), False: set()}
    for one in classes:
        fields[_is_record(one)] |= {
            node.target.id
            for node in one.body
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
        } | {
            node.attr
            for node in ast.walk(one)
            if isinstance(node, ast.Attribute)
            and isinstance(node.ctx, ast.Store)
            and isinstance(node.value, ast.Name)
            and node.value.id == "self"
        }
    return fields[True] - fields[False]


def _is_record(one: ast.ClassDef) -> bool:
    return all(
        node.name.startswith("__")
        for node in one.body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    )


def _root(target: ast.expr) -> str:
    while isinstance(target, ast.Attribute | ast.Subscript | ast.Call):
        target = target.func if isinstance(target, ast.Call) else target.value
    return ast.unparse(target)


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
