"""`python -m tools.targets`: measures the targets; `make targets` writes the table into the documents."""

import argparse
import sys
from collections.abc import Callable

from tools.targets import chain, limit, momentum, motion, speed
from tools.targets.table import FULL, QUICK, Effort, Row, markdown, write

ROWS: dict[str, Callable[[Effort], Row]] = {
    "bound": limit.bound,
    "cuts": limit.cuts,
    "growth": speed.growth,
    "one-thread": speed.one_thread,
    "two-threads": speed.two_threads,
    "tight": speed.tight,
    "peak-speed": motion.peak_speed,
    "path": motion.path_of_the_centre,
    "tip": motion.heavy_tip,
    "chain": chain.swing,
    "momentum": momentum.drift,
    "mesh": speed.mesh,
}
"""A function a row; the table keeps this order."""


def main() -> None:
    """Measures the rows asked for and prints or writes them."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m tools.targets")
    parser.add_argument(
        "--only", action="append", choices=ROWS, metavar="ROW", help=f"one of {', '.join(ROWS)}"
    )
    parser.add_argument(
        "--quick", action="store_true", help="tiny cloths: to see that it runs, not for figures"
    )
    parser.add_argument("--write", action="store_true", help="into README.md and docs/targets.md")
    given = parser.parse_args()
    if given.write and (given.only or given.quick):
        parser.error("--write needs all rows at full size; leave out --only and --quick")
    rows = {}
    for name in given.only or ROWS:
        rows[name] = ROWS[name](QUICK if given.quick else FULL)
        print(
            f"{name}: {rows[name].reached}: {'met' if rows[name].met else 'not met'}",
            file=sys.stderr,
            flush=True,
        )
    table = markdown(rows, speed.disturbed())
    print(table, end="")
    if given.write:
        write(table)


if __name__ == "__main__":
    main()
