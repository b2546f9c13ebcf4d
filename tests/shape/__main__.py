"""Print the figures of the source: `python -m tests.shape`, with `--names` what they count."""

from __future__ import annotations

import sys

from tests.shape.measures import figures
from tests.shape.tree import source


def main(arguments: list[str]) -> int:
    """Print them; return the exit status."""
    found = figures(source())
    lists = {
        f"modules under 60 lines that at most one other imports: {len(found.small)}": found.small,
        f"circles of imports: {len(found.circles)}": [" ".join(group) for group in found.circles],
        f"attributes set from outside: {len(found.set_from_outside)}": found.set_from_outside,
        f"of these by the composition root: {len(found.wired_late)}": found.wired_late,
        f"class names in more than one module: {len(found.named_twice)}": found.named_twice,
    }
    lines = [
        f"modules: {found.modules}",
        f"lines: {found.lines}",
        f"median: {found.median_lines:.0f} lines",
        f"largest: {found.largest_lines} lines",
        f"import lines: {100 * found.import_share:.1f} %",
    ]
    for heading, names in lists.items():
        lines.append(heading)
        if "--names" in arguments:
            lines.extend(f"  {name}" for name in names)
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
