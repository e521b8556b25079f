"""`make compare`: all methods on a sheet and on a chain, and ways to handle contact.

Runs `taut compare`, puts its tables between the markers of docs/methods/compare.md and contact.md, and
pictures of it into docs/pictures.
"""

import subprocess
import sys
from pathlib import Path

from documents import ROOT, keep, rewrite

OUT = ROOT / "out" / "compare"
PAGE = ROOT / "docs" / "methods" / "compare.md"
CONTACT = PAGE.with_name("contact.md")
TAUT = Path(sys.executable).with_name("taut")

SHOWN = {
    "one-corner": ("cost.png", "distribution.png", "passes.png", "motion.png", "strip.jpg"),
    "chain": ("motion.png",),
}
"""Pictures that the page shows, of each scene."""

SHOWN_OF_CONTACT = ("contact-heap.png", "contact-heap-strip.jpg", "contact-twist-strip.jpg")


def tables(page: str) -> str:
    """The part of a comparison's page between its title and its pictures."""
    return page.split("\n", 2)[2].split("\n![", 1)[0]


def main() -> None:
    """Compare, rewrite the page, keep pictures."""
    OUT.mkdir(parents=True, exist_ok=True)
    for scene, pictures in SHOWN.items():
        command = [TAUT, "compare", scene, "--filters", "all", "--out", OUT / scene]
        subprocess.run([*command, "--threads", "1", "--no-film", "--overwrite"], check=True, cwd=ROOT)
        rewrite(PAGE, scene, tables((OUT / scene / "compare.md").read_text()))
        for name in pictures:
            keep(OUT / scene / name, f"compare-{scene}-{Path(name).stem}", widest=1100)
    out = OUT / "contact"
    command = [TAUT, "compare", "--contact", "--out", out, "--threads", "1", "--overwrite"]
    subprocess.run(command, check=True, cwd=ROOT)
    rewrite(CONTACT, "contact", tables((out / "compare.md").read_text()))
    for name in SHOWN_OF_CONTACT:
        keep(out / name, f"compare-{Path(name).stem}", widest=1100)


if __name__ == "__main__":
    main()
