"""Who may do what: roles, scopes, limits, and the decision itself."""

from __future__ import annotations
