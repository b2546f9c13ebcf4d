"""The figures of the source, each seen to move, and the bounds that they keep from now on."""

from __future__ import annotations

import ast

import pytest

from tests.shape import measures
from tests.shape.tree import source

# Modules of under 60 lines with one importer, and why each is not joined to it.
ALONE = {
    "rosic.__main__": "python -m rosic",
    "rosic.bench.timer_baseline": "a process that imports next to nothing",
    "rosic.cli.sim": "a subcommand, found by its name",
    "rosic.core.language.secrecy": "its importer is the package, whose names it gives",
    "rosic.robots.ros2.interfaces.__main__": "python -m rosic.robots.ros2.interfaces",
    "rosic.robots.ros2.interfaces.generate": "a process of its own, started by its path",
    "rosic.stores.migrations.env": "run by Alembic, by its path",
    "rosic_sim.robots.machines.fast_forward": "for whoever tests machines; ships with them",
    "rosic_sim.scenarios.registry": "whoever names a play imports none of them",
}


def parsed(**texts: str) -> dict[str, ast.Module]:
    return {name: ast.parse(text) for name, text in texts.items()}


@pytest.fixture(scope="module")
def found() -> measures.Figures:
    return measures.figures(source())


def test_no_class_name_stands_for_two_things(found: measures.Figures) -> None:
    assert found.named_twice == []


def test_no_modules_import_each_other_in_a_circle(found: measures.Figures) -> None:
    assert found.circles == []


def test_the_composition_root_sets_nothing_into_what_is_made(found: measures.Figures) -> None:
    assert found.wired_late == []


def test_nothing_is_set_into_another_object_from_outside(found: measures.Figures) -> None:
    assert found.set_from_outside == [], "let its owner have a method that says what happens"


def test_a_small_module_with_one_importer_has_a_reason(found: measures.Figures) -> None:
    assert found.small == sorted(ALONE), "join it to its importer, or say in ALONE why not"


def test_a_circle_is_found_also_where_only_types_are_imported() -> None:
    graph = measures.imports(
        parsed(
            a="from b import x",
            b="import c",
            c="if TYPE_CHECKING:\n    from a import y",
            d="from a import x",
        )
    )
    assert measures.circles(graph) == [["a", "b", "c"]]


@pytest.mark.parametrize(
    ("text", "set_outside"),
    [
        ("def f(a):\n    a.x = 1", ["m:2 a.x"]),
        ("def f(a):\n    a.b.x = 1", ["m:2 a.b.x"]),
        ("class A:\n    def f(self):\n        self.b.x += 1", ["m:3 self.b.x"]),
        ("class A:\n    def f(self):\n        self.x = 1", []),
        ("def f():\n    a = A()\n    a.x = 1", []),
        ("def f(a, b):\n    a.x, (b.y, c) = 1, (2, 3)", ["m:2 a.x", "m:2 b.y"]),
        ("def f(a):\n    with g() as a.x:\n        pass", ["m:2 a.x"]),
        ("def f(a, name):\n    setattr(a, name, 1)", ["m:2 a.setattr"]),
        ("@dataclass\nclass R:\n    x: int\ndef f(a):\n    a.x = a.y = 1", ["m:5 a.y"]),
        ("class R:\n    def __init__(self):\n        self.x = 1\ndef f(a):\n    a.x = 2", []),
        (
            "class S:\n    x: int\n    def act(self): ...\ndef f(a):\n    a.x = 1",
            ["m:5 a.x"],
        ),
        (
            "class R:\n    x: int\nclass S:\n    def g(self): self.x = 2\ndef f(a): a.x = 1",
            ["m:5 a.x"],
        ),
        (
            "class R:\n    x: int\nclass A:\n    def f(self):\n        self.b.x = 1",
            ["m:5 self.b.x"],
        ),
    ],
)
def test_what_is_set_from_outside_is_found(text: str, set_outside: list[str]) -> None:
    assert measures.set_from_outside("m", ast.parse(text)) == set_outside


def test_what_is_foreign_may_be_filled_where_it_is_named_and_nowhere_else() -> None:
    tree = ast.parse("def f(message, other):\n    message.header.stamp = other.x = 1")
    found = measures.set_from_outside("rosic_sim.ros2.reports", tree)
    assert found == ["rosic_sim.ros2.reports:2 other.x"]
    assert measures.set_from_outside("m", tree) == ["m:2 message.header.stamp", "m:2 other.x"]


def test_every_name_of_something_foreign_is_still_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    trees = {name: ast.parse(text) for name, text in source().items()}
    needed = set()
    for entry in measures.FOREIGN:
        module = entry.split()[0]
        before = measures.set_from_outside(module, trees[module])
        with monkeypatch.context() as without:
            without.setattr(measures, "FOREIGN", measures.FOREIGN - {entry})
            if measures.set_from_outside(module, trees[module]) != before:
                needed.add(entry)
    assert needed == measures.FOREIGN


def test_an_attribute_set_into_a_collaborator_anywhere_in_the_source_is_found() -> None:
    trees = source()
    planted = "\n\ndef late(other: object) -> None:\n    other.attribute = 1\n"
    for name in ("rosic.messengers.telegram.polling", "rosic_sim.ros2.reports", "rosic.core.lease"):
        before = measures.set_from_outside(name, ast.parse(trees[name]))
        found = measures.set_from_outside(name, ast.parse(trees[name] + planted))
        new = [one.partition(" ")[2] for one in found if one not in before]
        assert new == ["other.attribute"]


def test_what_the_composition_root_sets_is_told_from_what_others_fill() -> None:
    text = "def make(parts):\n    parts.executor.after = print\n"
    names = ("rosic.app.gateway", "rosic.stores.writer", "rosic.application")
    outside = [found for n in names for found in measures.set_from_outside(n, ast.parse(text))]

    assert measures.wired_late(outside) == ["rosic.app.gateway:2 parts.executor.after"]


def test_a_class_name_of_two_modules_is_found() -> None:
    twice = measures.named_twice(
        parsed(a="class State: ...", b="class State: ...\nclass _Own: ...", c="class _Own: ...")
    )
    assert twice == ["State: a, b"]


def test_a_small_module_with_one_importer_is_found() -> None:
    graph = {"a": {"b", "c"}, "d": {"c"}, "b": set(), "c": set()}
    assert measures.small({"b": 10, "c": 10, "a": 100, "d": 100}, graph) == ["b"]


def test_what_every_feature_has_may_be_small_and_nothing_else_of_it() -> None:
    feature = "rosic.features.booking"
    sizes = dict.fromkeys((f"{feature}.{name}" for name in ("commands", "messages", "queue")), 10)
    assert measures.small({**sizes, "rosic.cli.commands": 10}, {}) == [
        "rosic.cli.commands",
        f"{feature}.queue",
    ]
