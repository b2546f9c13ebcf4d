"""The composition root: from files to objects. The only package that knows all the others."""

from __future__ import annotations
