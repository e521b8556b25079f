"""`python -m tools.targets`: measures the targets; `make targets` writes the table into docs/targets.md."""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from tools.targets import across, chain, far, hand, held, limit, mesh, momentum, motion, rest, settled, speed
from tools.targets.contact import chance, drapes, friction, garments, heaps, pulled, shots
from tools.targets.contact import speed as cost
from tools.targets.table import FULL, QUICK, ROOT, Effort, Row, details, markdown, write

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
    "raw-momentum": momentum.raw,
    "mesh": mesh.beside_a_grid,
    "mesh-threads": mesh.threads,
    "mesh-growth": mesh.growth,
    "cycles": mesh.cycles,
    "mesh-motion": settled.mesh_motion,
    "rest": rest.rest,
    "swing": settled.swing,
    "taut-sheet": across.taut_sheet,
    "far": far.far,
    "scales": settled.scales,
    "tips": settled.tips,
    "hand": hand.hand,
    "held": held.held,
    "contact-drapes": drapes.drapes,
    "contact-heaps": heaps.heaps,
    "contact-pulled": pulled.pulled,
    "contact-shots": shots.shots,
    "contact-random": chance.chance,
    "contact-garments": garments.garments,
    "contact-friction": friction.friction,
    "contact-speed": cost.speed,
}
"""A function a row; the table keeps this order."""
DETAIL = ROOT / "docs" / "targets-detail.md"
HEAD = """# Targets in full

What stands in one line in [the table](targets.md), case by case. `make targets` writes this page.

"""


def main() -> None:
    """Measures the rows asked for and prints or writes them."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m tools.targets")
    parser.add_argument(
        "--only", action="append", choices=ROWS, metavar="ROW", help=f"one of {', '.join(ROWS)}"
    )
    parser.add_argument(
        "--quick", action="store_true", help="tiny cloths: to see that it runs, not for figures"
    )
    parser.add_argument("--write", action="store_true", help="into docs/targets.md and its details")
    parser.add_argument("--runs", type=int, default=FULL.runs, help="of what depends on time or chance")
    parser.add_argument(
        "--sizes", type=_sizes, default=(), help="of meshes, as 65,129: vertices along a side"
    )
    parser.add_argument("--case", default="", help="of rows about contact: cases with this in their name")
    parser.add_argument("--detail", type=Path, metavar="FILE", help="tables of all that was measured")
    given = parser.parse_args()
    if given.write and (given.only or given.quick or given.sizes or given.case or given.runs != FULL.runs):
        parser.error(
            "--write needs all rows at full size; leave out --only, --quick, --sizes, --case, --runs"
        )
    effort = replace(QUICK if given.quick else FULL, sizes=given.sizes, case=given.case)
    if given.runs != FULL.runs:
        effort = replace(effort, runs=given.runs)
    rows = {}
    for name in given.only or ROWS:
        rows[name] = ROWS[name](effort)
        print(
            f"{name}: {rows[name].reached}: {'met' if rows[name].met else 'not met'}",
            file=sys.stderr,
            flush=True,
        )
    table = markdown(rows, speed.disturbed())
    print(table, end="")
    if given.detail:
        given.detail.write_text(details(rows))
    if given.write:
        write(table)
        DETAIL.write_text(HEAD + details(rows))
    missed = [name for name, row in rows.items() if not row.met]
    if missed and not given.quick:
        sys.exit(f"not met: {', '.join(missed)}")


def _sizes(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(","))


if __name__ == "__main__":
    main()
