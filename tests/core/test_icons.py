"""A sign before a skill's name on its button: one, and none that means stop."""

from __future__ import annotations

import pytest

from rosic.core import messages
from rosic.core.robot.skill import Skill


@pytest.mark.parametrize("icon", ["🦾", "⚙️", "👋🏽", "🧑‍🔧", "🏠"])
def test_one_sign_stands_before_the_name(icon: str) -> None:
    skill = Skill(id="wave_hand", icon=icon)
    assert messages.button_label(skill) == f"{icon} Wave hand"
    assert messages.label(skill) == "Wave hand", "where it is no button it is a name"


@pytest.mark.parametrize(
    "icon",
    ["x", "1", " ", "🦾🦾", "🦾 ", "\u202e", "🦾\u202e", "\u200d🦾", "🛑", "✋🏽", "<", "🦾" * 9],
)
def test_anything_else_is_none(icon: str) -> None:
    with pytest.raises(ValueError, match="icon must be one sign"):
        Skill(id="wave", icon=icon)
