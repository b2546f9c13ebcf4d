"""Who else may write what a gateway believes: its configuration, its profiles, their folders."""

from __future__ import annotations

import os
import stat
from typing import TYPE_CHECKING, NamedTuple

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path


class OpenPath(NamedTuple):
    """A file or a folder that others may write.

    Attributes:
        everybody: Not only a group or another owner: whoever is on this machine.
    """

    error: ConfigurationError
    everybody: bool


def open_to_others(files: Iterable[Path]) -> Iterator[OpenPath]:
    """Look at files and the folders that they lie in; what cannot be looked at is left out."""
    for path in dict.fromkeys(place for file in files for place in (file, file.absolute().parent)):
        try:
            status = path.stat()
        except OSError:
            continue
        found = _found(path, status)
        if found is not None:
            yield found


def _found(path: Path, status: os.stat_result) -> OpenPath | None:
    mode = status.st_mode
    what = "The folder" if stat.S_ISDIR(mode) else "The file"
    if stat.S_ISDIR(mode) and mode & stat.S_ISVTX:
        return None  # as /tmp: others may add files there, and replace none
    if mode & stat.S_IWOTH:
        sentence = f"{what} {path} may be written by everybody on this machine."
        return OpenPath(ConfigurationError(sentence, hint=f"Run: chmod o-w {path}"), everybody=True)
    if status.st_uid not in {0, os.geteuid()}:
        sentence = f"{what} {path} belongs to another user, who may change it."
        return OpenPath(
            ConfigurationError(sentence, hint=f"Run: chown $USER {path}"), everybody=False
        )
    if mode & stat.S_IWGRP and status.st_gid != status.st_uid:  # not a group of one's own
        sentence = f"{what} {path} may be written by its group."
        return OpenPath(
            ConfigurationError(sentence, hint=f"Run: chmod g-w {path}"), everybody=False
        )
    return None
