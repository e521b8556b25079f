"""`make figures`: the figures and pictures of the README, from runs made now.

Runs scenes with and without the velocity constraint, rewrites the table between the markers in README.md
and the pictures in docs/pictures.
"""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "figures"
PICTURES = ROOT / "docs" / "pictures"
TAUT = Path(sys.executable).with_name("taut")

SCENES = ["flag", "flag-strong", "one-corner", "two-corners", "curtain", "cape"]
METHODS = ["none", "sequential", "sweeps", "coarse_to_fine"]
STILLS = {"flag": "200", "one-corner": "60"}
BEGIN, END = "<!-- figures: begin -->\n", "<!-- figures: end -->"


def run(scene: str, method: str) -> tuple[Path, dict[str, Any]]:
    """Simulate a scene to its end; return the cache and its report."""
    cache = OUT / f"{scene}-{method}.zarr"
    settings = ["--set", f"solver.filter={method}"]
    if scene in STILLS:
        words = f"{'without' if method == 'none' else 'with'} the velocity constraint"
        settings += ["--set", f"title={scene.replace('-', ' ').capitalize()}, {words}"]
    subprocess.run(
        [TAUT, "run", scene, "--out", cache, "--overwrite", "--quiet", *settings],
        check=True,
        cwd=ROOT,
    )
    report = subprocess.run([TAUT, "info", cache, "--json"], check=True, capture_output=True).stdout
    return cache, json.loads(report)


def machine() -> str:
    """What the times were measured on."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return f"{os.cpu_count()} threads of {names[0] if names else platform.processor() or platform.machine()}"


def main() -> None:
    """Run, render, rewrite."""
    OUT.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    rows = ["| scene | vertices | limit | " + " | ".join(f"`{method}`" for method in METHODS) + " |"]
    rows.append("|---|---|---|" + "---|" * len(METHODS))
    for scene in SCENES:
        results = {method: run(scene, method) for method in METHODS}
        reports = [report for _, report in results.values()]
        cells = [f"{100 * r['worst_stretch']:.2f} %, {r['ms_per_frame']:.1f} ms" for r in reports]
        limit = f"{100 * reports[0]['limit']:g} %"
        rows.append(f"| `{scene}` | {reports[0]['vertices']} | {limit} | " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
        if scene in STILLS:
            caches = [results[method][0] for method in ("none", METHODS[-1])]
            picture = PICTURES / f"{scene}.jpg"
            arguments = ["--out", picture, "--frame", STILLS[scene], "--overwrite"]
            subprocess.run([TAUT, "render", *caches, *arguments], check=True)
    rows.append("")
    rows.append(
        f"Worst stretch of any spring in any frame, and median time to simulate a frame ({machine()})."
    )
    readme = ROOT / "README.md"
    head, rest = readme.read_text().split(BEGIN)
    readme.write_text(head + BEGIN + "\n".join(rows) + "\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
