"""A place that a module's tests share, and a gateway that runs there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.cli.running import gateway, write_config

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.cli.running import Gateway


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_config(tmp_path_factory.mktemp("place"))


@pytest.fixture(scope="module")
def running(config: Path) -> Iterator[Gateway]:
    with gateway(config) as opened:
        yield opened
