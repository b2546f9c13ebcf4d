"""``python -m rosic``: the same as the command ``rosic``."""

from __future__ import annotations

import sys

from rosic.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
