"""`python -m tools.targets`: measures the targets; with `--write` into docs/targets.md and its details."""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from taut.bench import this_machine

from tools.targets import (
    across,
    chain,
    far,
    film,
    grids,
    hand,
    held,
    limit,
    mesh,
    momentum,
    motion,
    pages,
    rest,
    settled,
    speed,
)
from tools.targets.contact import chance, drapes, friction, garments, heaps, pulled, shots
from tools.targets.contact import speed as cost
from tools.targets.table import FULL, QUICK, ROOT, Effort, Row

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
    "grids": grids.grids,
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
    "film": film.film,
}
"""A function a row; the table keeps this order."""
TABLE, DETAIL = ROOT / "docs" / "targets.md", ROOT / "docs" / "targets-detail.md"


def main() -> None:
    """Measures the rows asked for and prints or writes them."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m tools.targets")
    parser.add_argument(
        "--only", action="append", choices=ROWS, metavar="ROW", help=f"one of {', '.join(ROWS)}"
    )
    parser.add_argument(
        "--quick", action="store_true", help="tiny cloths: to see that it runs, not for figures"
    )
    parser.add_argument(
        "--write", action="store_true", help="each row, once measured, into docs/targets.md and its details"
    )
    parser.add_argument("--runs", type=int, default=FULL.runs, help="of what depends on time or chance")
    parser.add_argument(
        "--sizes", type=_sizes, default=(), help="of meshes, as 65,129: vertices along a side"
    )
    parser.add_argument("--case", default="", help="of rows about contact: cases with this in their name")
    parser.add_argument("--detail", type=Path, metavar="FILE", help="tables of all that was measured")
    given = parser.parse_args()
    if given.write and (given.quick or given.sizes or given.case or given.runs != FULL.runs):
        parser.error("--write needs rows at full size; leave out --quick, --sizes, --case, --runs")
    effort = replace(QUICK if given.quick else FULL, sizes=given.sizes, case=given.case)
    if given.runs != FULL.runs:
        effort = replace(effort, runs=given.runs)
    machine = this_machine()  # before pages are written: they are part of the revision
    lines, sections, missed = {}, {}, []
    for name in given.only or ROWS:
        row = ROWS[name](effort)
        print(f"{name}: {row.reached}: {'met' if row.met else 'not met'}", file=sys.stderr, flush=True)
        busy = ", busy with something else: times are too long" if speed.disturbed() else ""
        lines[name] = pages.line(name, row, f"{machine.version} {machine.revision} on {machine}{busy}")
        sections[name] = pages.section(name, row)
        missed += [] if row.met else [name]
        if given.write:
            TABLE.write_text(pages.with_lines(TABLE.read_text("utf-8"), {name: lines[name]}, ROWS), "utf-8")
            DETAIL.write_text(
                pages.with_sections(DETAIL.read_text("utf-8"), {name: sections[name]}, ROWS), "utf-8"
            )
    print(pages.table(lines), end="")
    if given.detail:
        given.detail.write_text("\n".join(filter(None, sections.values())))
    if missed and not given.quick:
        sys.exit(f"not met: {', '.join(missed)}")


def _sizes(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(","))


if __name__ == "__main__":
    main()
