"""One homeserver for all tests of a worker; a test has its own users and rooms there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.real.matrix.synapse import synapse_in

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.real.matrix.synapse import Synapse


@pytest.fixture(scope="session")
def synapse(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Synapse]:
    """A homeserver that runs; who stops it starts it again."""
    with synapse_in(tmp_path_factory.mktemp("synapse")) as running:
        yield running
