"""`make figures`: the table and the pictures of the README, from runs made now.

`taut compare` measures the scenes, `taut figures` makes the figures of the paper; here both are put into
README.md and docs/pictures.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from documents import ROOT, keep, rewrite

OUT = ROOT / "out" / "readme"
TAUT = Path(sys.executable).with_name("taut")

SCENES = ["flag", "flag-strong", "one-corner", "two-corners", "curtain", "cape"]
METHODS = ["none", "sequential", "sweeps", "coarse_to_fine"]
SHOWN = {"fig5.jpg": "flag", "fig6-7.jpg": "one-corner"}
"""Figures of the paper that the README shows, and their names in docs/pictures."""


def measured(scene: str) -> dict[str, Any]:
    """What `taut compare` finds for a scene."""
    out = OUT / scene
    options = ["--filters", ",".join(METHODS), "--no-equal-stretch", "--no-film", "--overwrite"]
    subprocess.run([TAUT, "compare", scene, "--out", out, *options], check=True, cwd=ROOT)
    found: dict[str, Any] = json.loads((out / "compare.json").read_text())
    return found


def main() -> None:
    """Run, render, rewrite."""
    OUT.mkdir(parents=True, exist_ok=True)
    subprocess.run([TAUT, "figures", "--out", OUT / "paper", "--overwrite"], check=True, cwd=ROOT)
    for picture, name in SHOWN.items():
        keep(OUT / "paper" / "pictures" / picture, name)
    rows = ["| scene | vertices | limit | " + " | ".join(f"`{method}`" for method in METHODS) + " |"]
    rows.append("|---|---|---|" + "---|" * len(METHODS))
    for scene in SCENES:
        found = measured(scene)
        cells = [f"{100 * run['worst_stretch']:.2f} %, {run['ms_per_frame']:.1f} ms" for run in found["runs"]]
        limit = f"{100 * found['scene']['strain_limit']:g} %"
        size = found["scene"]["vertices"]
        rows.append(f"| `{scene}` | {size} | {limit} | " + " | ".join(cells) + " |")
    machine = f"{found['threads']} threads on {found['machine']}"
    rows += [
        "",
        f"Worst stretch of any spring in any frame, and median time to simulate a frame ({machine}).",
    ]
    rewrite(ROOT / "README.md", "figures", "\n".join(rows))


if __name__ == "__main__":
    main()
