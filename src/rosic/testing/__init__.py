"""For whoever writes an adapter: conformance suites, a clock to own, servers to test against."""

from __future__ import annotations
