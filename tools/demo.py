"""`make demo`: the flag with and without the velocity constraint, film, still, both worst stretches."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out"
TAUT = Path(sys.executable).with_name("taut")
RUNS = {"without": "none", "with": "coarse_to_fine"}


def taut(*arguments: str | Path) -> None:
    """Runs one taut command, shown as a user would type it."""
    shown = [str(argument).removeprefix(f"{ROOT}/") for argument in arguments]
    print("$ taut", " ".join(f'"{word}"' if " " in word else word for word in shown), flush=True)
    subprocess.run([TAUT, *arguments], check=True, cwd=ROOT)


def main() -> None:
    """Simulates, renders and reports."""
    OUT.mkdir(exist_ok=True)
    caches = {name: OUT / f"flag-{name}-constraint.zarr" for name in RUNS}
    for name, method in RUNS.items():
        title = f"title=Flag, {name} the velocity constraint"
        taut(
            *("run", "flag", "--out", caches[name], "--overwrite"),
            *("--set", f"solver.filter={method}", "--set", title),
        )
    taut("render", *caches.values(), "--out", OUT / "flag.png", "--frame", "200", "--overwrite")
    taut("render", *caches.values(), "--out", OUT / "flag.mp4", "--overwrite")
    print()
    for name, cache in caches.items():
        command = [TAUT, "info", cache, "--json"]
        report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        print(f"worst stretch {name} the constraint: {100 * report['worst_stretch']:.1f} %")
    print("still: out/flag.png\nfilm: out/flag.mp4")
    print("see it move and pull it, in the browser: .venv/bin/taut view flag")


if __name__ == "__main__":
    main()
