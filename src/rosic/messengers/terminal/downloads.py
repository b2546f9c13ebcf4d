"""Where a terminal puts the files it is sent: a folder that only its own user may look into.

Not in the data folder: a file that was asked for is in the open, and would go into every backup.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.core.message import LIES_IN
from rosic.errors import MessengerFault, RosicError

if TYPE_CHECKING:
    from rosic.core.message import Attachment

FILE_BYTES = 50_000_000
TRIES = 1_000


class DownloadFolder:
    """Makes its folder when the first file comes."""

    def __init__(self) -> None:
        self._folder: Path | None = None

    @property
    def folder(self) -> Path | None:
        """Where files lie that were sent; None: there are none."""
        folder = self._folder
        return folder if folder is not None and folder.is_dir() and any(folder.iterdir()) else None

    async def put(self, attachment: Attachment, lies_in: str = "") -> str:
        """Write a file, over none that is there, and return a sentence about where it lies.

        Args:
            attachment: The file.
            lies_in: The sentence in the reader's language, without its path; empty for English.

        Raises:
            MessengerFault: It is too large, or cannot be written. There is no part of it.
        """
        if attachment.size > FILE_BYTES:
            raise MessengerFault("The file is too large. It was not written.")
        try:
            path = await self._written(attachment)
        except OSError as error:
            raise MessengerFault(f"The file cannot be written ({error.strerror}).") from error
        except RosicError as error:
            raise MessengerFault(error.sentence) from error
        return (lies_in or LIES_IN).format(path=path)

    async def _written(self, attachment: Attachment) -> Path:
        if self._folder is None or not self._folder.is_dir():
            self._folder = Path(tempfile.mkdtemp(prefix="rosic-"))
        name = Path(attachment.name)
        for number in range(TRIES):
            path = self._folder / (f"{name.stem}-{number}{name.suffix}" if number else name)
            try:
                opened = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            except FileExistsError:
                continue
            try:
                with os.fdopen(opened, "wb") as file:
                    async for piece in attachment.read():
                        file.write(piece)
            except BaseException:
                path.unlink(missing_ok=True)
                raise
            return path
        raise OSError(0, "there are too many of that name")
