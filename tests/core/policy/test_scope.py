"""What a scope may look like; what it reaches is in ``tests/core/policy``."""

from __future__ import annotations

import pytest

from rosic.core.policy.scope import Scope


@pytest.mark.parametrize(
    "text", ["", "omni", "omni:", ":move", "a:b:c", "Omni:move", "omni move:x"]
)
def test_what_is_no_scope_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is no right"):
        Scope.parse(text)
