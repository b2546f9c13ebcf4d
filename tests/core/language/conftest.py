from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import pytest

from rosic.app.features import command_table
from rosic.config.units import compile_units
from rosic.core.language import Do, Line, LineContext, UnitTable, Vocabulary, bind, understand
from rosic.core.robot.skill import Argument
from tests.core.language.fleet import profiles

Means: TypeAlias = Callable[..., Line]
Arguments: TypeAlias = Callable[..., dict[str, Argument]]


@pytest.fixture(scope="session")
def units() -> UnitTable:
    return compile_units()


@pytest.fixture(scope="session")
def vocabulary(units: UnitTable) -> Vocabulary:
    return Vocabulary.build(profiles(), units, command_table())


@pytest.fixture(scope="session")
def everyone(vocabulary: Vocabulary) -> frozenset[str]:
    return frozenset(vocabulary.profiles)


@pytest.fixture(scope="session")
def means(vocabulary: Vocabulary, everyone: frozenset[str]) -> Means:
    """One line to what it means."""

    def understood(text: str, selected: str = "", visible: frozenset[str] = everyone) -> Line:
        (line,) = understand(text, vocabulary, LineContext(selected, visible))
        return line

    return understood


@pytest.fixture(scope="session")
def arguments(vocabulary: Vocabulary, means: Means) -> Arguments:
    """One command to its arguments; raises what `bind` raises."""

    def bound(text: str, selected: str = "") -> dict[str, Argument]:
        line = means(text, selected)
        assert isinstance(line, Do), line
        return bind(vocabulary, line.robots[0], line.skills[0], line.spoken, group=line.group)

    return bound
