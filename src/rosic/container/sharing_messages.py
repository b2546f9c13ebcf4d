"""Every sentence about lending what one keeps."""

from __future__ import annotations

from rosic.core.i18n import said, said_n
from rosic.core.language.sanitise import quote


def lent_enough(most: int) -> str:
    """Return that sharing has its bounds."""
    return said_n(
        "You can share {n} thing at most, and you do. Nothing has changed. Take one back first.",
        "You can share {n} things at most, and you do. Nothing has changed. Take one back first.",
        most,
    )


def not_lent(name: str) -> str:
    """Return that there is nothing to take back."""
    return said("You share nothing called {name} so. Nothing has changed.", name=quote(name))
