"""Looks through everything that tests have left behind for what must be written nowhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

SECRETS = (
    b"journeys-journeys-journeys-journeys",
    b"wrong-and-yet-not-to-be-seen",
    b"not-a-real-token-for-tests-only",
)
"""The secret halves of the tokens that tests give to gateways."""
GIVEN_IN = frozenset({"rosic.toml"})
"""A configuration holds its token where a test wrote it there."""
LARGEST = 64 * 2**20


def leaks(folder: Path, secrets: Iterable[bytes] = SECRETS) -> list[str]:
    """Return the files below a folder that hold a secret: logs, records, answers, whatever it is.

    Source that was laid out for a planted fault, and what is larger than 64 MB, is not looked into.
    """
    wanted = tuple(secrets)
    found: list[str] = []
    for path in folder.rglob("*"):
        if path.suffix in {".py", ".pyc"} or path.name in GIVEN_IN:
            continue
        try:
            if not path.is_file() or path.stat().st_size > LARGEST:
                continue
            content = path.read_bytes()
        except OSError:  # gone meanwhile
            continue
        if any(secret in content for secret in wanted):
            found.append(str(path.relative_to(folder)))
    return found
