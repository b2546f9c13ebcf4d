"""One server for all tests of a worker; a test has its own accounts and rooms there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.real.xmpp.prosody import Prosody

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="session")
def prosody(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Prosody]:
    """A server that runs; who stops it starts it again."""
    with Prosody(tmp_path_factory.mktemp("prosody")) as running:
        yield running
