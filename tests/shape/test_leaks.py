"""What looks for tokens at the end of a run finds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.journeys.fleet import TOKEN
from tests.leaks import SECRETS, leaks

if TYPE_CHECKING:
    from pathlib import Path


def test_a_token_in_a_log_is_found_and_one_in_a_configuration_is_where_it_belongs(
    tmp_path: Path,
) -> None:
    assert TOKEN.partition(":")[2].encode() in SECRETS
    (tmp_path / "rosic.toml").write_text(f'token = "{TOKEN}"')
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "gateway.log").write_text("started\n")
    assert leaks(tmp_path) == []
    (tmp_path / "data" / "gateway.log").write_text(f"GET /bot{TOKEN}/getMe\n")
    assert leaks(tmp_path) == ["data/gateway.log"]
    (tmp_path / "data" / "gateway.log").unlink()
