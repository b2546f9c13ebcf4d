"""Runs the tests, and those that failed beside others once more alone, where that can matter.

Tests that start real servers and processes share the processors with one another, and with
whatever else the machine does. What failed there and passes alone was crowded out: the run passes,
and names it at its end, for that is a fault of the test, to be mended. What fails alone, too,
fails. Everything else has one chance (docs/decisions/0011).
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

CROWDED = (
    "tests/api/",
    "tests/cli/",
    "tests/conformance/",
    "tests/console/",
    "tests/journeys/",
    "tests/real/",
)
AT_MOST = 5
"""With more than so many it is not the machine."""
LAST_RESORT_S = 600
"""For a test that hangs where no Python runs; longer by the pace of the run, as every limit is."""


class Failures:
    """Remembers which tests failed, in whatever phase, on whatever worker."""

    def __init__(self) -> None:
        self.tests: dict[str, None] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take in one phase of one test."""
        if report.failed:
            self.tests[report.nodeid] = None

    def deserve_another(self) -> bool:
        """Whether every one of them starts processes, and they are few."""
        return 0 < len(self.tests) <= AT_MOST and all(
            test.startswith(CROWDED) for test in self.tests
        )


def main(arguments: list[str]) -> int:
    """Run pytest; return its exit status, or that of the second run where there is one."""
    failures = Failures()
    within_s = LAST_RESORT_S * float(os.environ.get("ROSIC_PACE", "1"))
    limited = ["-o", f"faulthandler_timeout={within_s:.0f}"]
    status = int(pytest.main([*limited, *arguments], plugins=[failures]))
    if status != pytest.ExitCode.TESTS_FAILED or not failures.deserve_another():
        return status
    names = "".join(f"\n  {test}" for test in failures.tests)
    _say(f"These failed beside others, and are run once more alone:{names}")
    again = [sys.executable, "-m", "pytest", *limited, *failures.tests]
    status = subprocess.run(again, check=False).returncode  # noqa: S603 - our own tests
    verdict = "pass alone: crowded out, to be mended" if status == 0 else "fail alone, too"
    _say(f"These {verdict}:{names}")
    return status


def _say(sentence: str) -> None:
    sys.stdout.write(f"\n{sentence}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
