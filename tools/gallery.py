"""`make gallery`: films of the shipped scenes in out/gallery, and the stills of the gallery page.

The next `make docs` takes the films into the site. With names behind it, only those: `tools/gallery.py flag`.
"""

import subprocess
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "gallery"
PICTURES = ROOT / "docs" / "pictures" / "gallery"
TAUT = Path(sys.executable).with_name("taut")

STILLS = {
    "flag": 200,
    "flag-strong": 120,
    "one-corner": 60,
    "two-corners": 45,
    "curtain": 200,
    "cape": 150,
    "net": 100,
    "ball": 150,
    "table-cloth": 150,
    "stack": 60,
    "net-ball": 60,
    "box-corner": 60,
    "twist": 250,
    "skirt-walk": 150,
}
"""Frame of each scene's still."""
COMPARED = {"one-corner"}
"""Shown beside the same scene without the constraint."""
WIDTH = 800
"""Of a still [pixels]."""


def taut(*arguments: str | Path) -> None:
    """Run one command."""
    subprocess.run([TAUT, *arguments], check=True)


def caches(scene: str) -> list[Path]:
    """Simulate a scene; where it is compared, first without the constraint."""
    made = []
    for method in ("none", "coarse_to_fine") if scene in COMPARED else ("coarse_to_fine",):
        cache = OUT / f"{scene}-{method}.zarr"
        settings = ["--set", f"solver.filter={method}"]
        if scene in COMPARED:
            word = "without" if method == "none" else "with"
            settings += [
                "--set",
                f"title={scene.replace('-', ' ').capitalize()}, {word} the velocity constraint",
            ]
        taut("run", scene, "--out", cache, "--overwrite", *settings)
        made.append(cache)
    return made


def main() -> None:
    """Simulate, render, shrink."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    OUT.mkdir(parents=True, exist_ok=True)
    for scene in sys.argv[1:] or STILLS:
        made = caches(scene)
        still = OUT / f"{scene}.png"
        taut("render", *made, "--out", still, "--frame", str(STILLS[scene]), "--overwrite")
        with Image.open(still) as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
        small.save(PICTURES / f"{scene}.jpg", quality=85, optimize=True)
        taut("render", *made, "--out", OUT / f"{scene}.mp4", "--overwrite")


if __name__ == "__main__":
    main()
