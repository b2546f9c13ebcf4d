"""How each skill of a profile is carried out: topics, services, actions, parameters, files."""

from __future__ import annotations
