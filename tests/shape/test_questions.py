"""What asks whoever reads it is said to be a question: programs and the page go by that."""

from __future__ import annotations

import ast
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "rosic"
PLAIN = "Reply"
LEFT = "LEAVE"


def answers_that_can_be_left(code: str) -> list[int]:
    """Return the lines of plain answers that carry the button which leaves a question."""
    return [
        call.lineno
        for call in ast.walk(ast.parse(code))
        if isinstance(call, ast.Call)
        and isinstance(call.func, ast.Name)
        and call.func.id == PLAIN
        and any(isinstance(part, ast.Name) and part.id == LEFT for part in ast.walk(call))
    ]


def test_no_question_is_a_plain_answer() -> None:
    found = {
        str(path.relative_to(SOURCE)): lines
        for path in SOURCE.rglob("*.py")
        if LEFT in (code := path.read_text()) and (lines := answers_that_can_be_left(code))
    }
    assert found == {}


def test_one_would_be_found() -> None:
    assert answers_that_can_be_left("x = 1\nReply(text, ((yes, Button(LEAVE_IT, LEAVE)),))") == [2]
    assert answers_that_can_be_left("asks_first(text, ((Button(LEAVE_IT, LEAVE),),))") == []
