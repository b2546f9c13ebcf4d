"""Settings whose value stands elsewhere: ``{ env = "NAME" }`` and ``{ file = "path" }``.

No sentence here repeats a value, as any of them may be what must not be seen.
"""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rosic.config.source_map import Data, SourceMap, read_text, readable_by_others
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.contracts.file_rules import Place


# ---- file permissions ----

# Who else may write what a gateway believes: its configuration, its profiles, their folders.


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


# ---- secrets ----

# A plain text under such a key is hidden as well, although it would better stand elsewhere.
CONFIDENTIAL = re.compile(r"(?:.*_)?(?:token|password|passphrase|secret|key|credentials?)")

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class SecretSettings:
    """Takes the references out of one messenger's table."""

    def __init__(self, source: SourceMap, folder: Path, environ: Mapping[str, str]) -> None:
        self.errors: list[ConfigurationError] = []
        self._source = source
        self._folder = folder
        self._environ = environ

    def resolve(self, value: Data, place: Place) -> Data:
        """Return a value with a `Secret` wherever a reference or a confidential text stood.

        What cannot be resolved is noted in ``errors`` and left out.
        """
        if isinstance(value, list):
            return [self.resolve(item, (*place, index)) for index, item in enumerate(value)]
        if isinstance(value, dict):
            if value and value.keys() <= {"env", "file"}:
                return self._reference(value, place)
            return {key: self.resolve(item, (*place, key)) for key, item in value.items()}
        if isinstance(value, str) and value and _confidential(place):
            return Secret(value)
        return value

    def _reference(self, reference: dict[str, Data], place: Place) -> Secret | None:
        try:
            text = self._look_up(reference, place)
        except ConfigurationError as error:
            self.errors.append(error)
            return None
        return Secret(text)

    def _look_up(self, reference: dict[str, Data], place: Place) -> str:
        said = called(place)
        [(kind, name), *others] = reference.items()
        if others or not isinstance(name, str) or not name:
            raise self._source.error(
                place,
                f"{said} must say either env or file.",
                'Write { env = "NAME" } or { file = "path" }.',
            )
        text = self._from_environment(name, place) if kind == "env" else self._from(name, place)
        if not text:
            raise self._source.error(place, f"The secret of {said} is empty.")
        if not text.isprintable():
            raise self._source.error(place, f"The secret of {said} is not one line of plain text.")
        return text

    def _from_environment(self, name: str, place: Place) -> str:
        if not NAME.fullmatch(name):
            raise self._source.error(
                place,
                f"{called(place)} names no variable of the environment.",
                "Write the NAME of one that holds the secret, not the secret.",
            )
        if name not in self._environ:
            raise self._source.error(
                place,
                f"The environment variable {name} is not set.",
                "Set it where ROSIC is started.",
            )
        return self._environ[name].strip()

    def _from(self, name: str, place: Place) -> str:
        path = self._folder / Path(name).expanduser()
        try:
            if not path.is_file():
                raise self._source.error(place, f"There is no file {name} to read a secret from.")
            if readable_by_others(path):
                raise self._source.error(
                    place,
                    f"Others may read {name}, which holds a secret.",
                    f"Run: chmod 600 {name}",
                )
        except OSError:
            raise self._source.error(place, f"The file {name} may not be looked at.") from None
        try:
            return read_text(path).strip()
        except ConfigurationError:
            raise self._source.error(
                place, f"The file {name} cannot be read as a secret."
            ) from None


def called(place: Place) -> str:
    """Return what people call a place in the file."""
    return f"'{place[-1]}'"


def _confidential(place: Place) -> bool:
    names = [part for part in place if isinstance(part, str)]
    return bool(names) and CONFIDENTIAL.fullmatch(names[-1].lower()) is not None
