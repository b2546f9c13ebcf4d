"""Where a terminal is all that people talk by, nobody can be let in; and a name is no role."""

from __future__ import annotations

from tests.cli.running import rosic

ONLY = (
    "There is only this terminal to talk by, so nobody could use an invitation. Others can join "
    "once there is a messenger: rosic init. Nothing was done."
)


def test_an_invitation_that_nobody_could_use_is_not_made() -> None:
    ran = rosic("demo", "--plain", stdin="/invite operator\n/invite Bo\n")
    assert ONLY in ran.out
    assert "in a private chat" not in ran.out
    assert 'I know no role and no robot called "bo". The roles here are viewer, ' in ran.out
    assert "If that is whom you invite, say first as what: /invite viewer as Bo" in ran.out
    assert "Make the role" not in ran.out
