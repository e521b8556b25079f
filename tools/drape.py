"""`make drape`: Cusick's drape test on every fabric preset, for docs/fabrics.md.

Rewrites the table between the markers of that page and its picture. With `--only wool` one fabric, to the
terminal.
"""

import argparse
from pathlib import Path

import numpy as np
import pyvista as pv
from PIL import Image, ImageDraw, ImageFont
from taut.laboratory import Drape, drape

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "fabrics.md"
PICTURE = ROOT / "docs" / "pictures" / "drape.jpg"
BEGIN, END = "<!-- drape: begin -->\n", "<!-- drape: end -->"

BANDS: dict[str, tuple[float, float] | None] = {
    "silk": (20, 40),
    "cotton": (60, 76),
    "wool": (40, 70),
    "denim": (70, 90),
    "nylon": None,
    "leather": (47, 70),
}
"""Published drape coefficients [%]; docs/fabrics.md says where."""

COARSE, FINE = 7.5e-3, 5e-3
"""Meshes [m]: the fine one is shown."""
STARTS = (1, 2, 3)

TILE = 300
COLOURS = {
    "silk": "#b4553f",
    "cotton": "#d9d4c4",
    "wool": "#66707f",
    "denim": "#3f5f8f",
    "nylon": "#c9a227",
    "leather": "#7a4b2f",
}


def row(fabric: str) -> tuple[str, Drape]:
    """Drape a fabric several times: a row of the table, and the first of the drapes on the fine mesh."""
    cloth = {"fabric": fabric, "bending": "fabric"}
    coarse, fine = ([drape(cloth, edge, start) for start in STARTS] for edge in (COARSE, FINE))
    found, other = (float(np.mean([test.coefficient for test in tests])) for tests in (fine, coarse))
    band = BANDS[fabric]
    cells = [
        f"`{fabric}`",
        f"{found:.0f}",
        span([round(test.coefficient) for test in fine]),
        f"{other:.0f}",
        "none found" if band is None else f"{band[0]:g} – {band[1]:g}",
        "" if band is None else "yes" if band[0] <= found <= band[1] else "**no**",
        span([test.folds for test in [*coarse, *fine]]),
    ]
    return "| " + " | ".join(cells) + " |", fine[0]


def span(numbers: list[int]) -> str:
    """The least and the greatest of some numbers."""
    least, most = min(numbers), max(numbers)
    return f"{least}" if least == most else f"{least} – {most}"


def picture(drapes: dict[str, Drape]) -> None:
    """All drapes, from the side and from above."""
    plotter = pv.Plotter(
        off_screen=True, shape=(2, len(drapes)), window_size=[2 * TILE * len(drapes), 4 * TILE], border=False
    )
    for column, (fabric, test) in enumerate(drapes.items()):
        faces = np.hstack([np.full((len(test.faces), 1), 3), test.faces]).ravel()
        cloth = pv.PolyData(test.positions, faces).compute_normals(split_vertices=False)
        rim = np.hypot(test.positions[:, 0], test.positions[:, 1]).min() * 1.02
        for line in range(2):
            plotter.subplot(line, column)
            plotter.set_background("#f4f5f6")
            plotter.add_mesh(cloth, color=COLOURS[fabric], smooth_shading=True, ambient=0.15, specular=0.05)
            plotter.add_mesh(pv.Disc(inner=0, outer=rim, c_res=90), color=COLOURS[fabric], ambient=0.15)
            eye = (0.0, -0.62, 0.26) if line == 0 else (0.0, -1e-3, 0.68)
            plotter.camera_position = [eye, (0.0, 0.0, -0.035), (0.0, 0.0, 1.0)]
            plotter.camera.view_angle = 28.0
    image = Image.fromarray(np.asarray(plotter.screenshot(return_img=True))).reduce(2)
    plotter.close()
    pen, font = ImageDraw.Draw(image), ImageFont.load_default(18)
    for column, (fabric, test) in enumerate(drapes.items()):
        pen.text((column * TILE + 12, 10), f"{fabric}  {test.coefficient:.0f} %", "#2b3440", font)
    image.save(PICTURE, quality=85)


def main() -> None:
    """Measure, rewrite the page, draw."""
    parser = argparse.ArgumentParser(description="Cusick's drape test on the fabric presets")
    parser.add_argument("--only", choices=BANDS, help="one fabric, to the terminal")
    only = parser.parse_args().only
    rows = [
        "| preset | drape coefficient [%], mean of three starts | least – greatest | coarser mesh, mean "
        "| published | inside | folds |",
        "|---|---|---|---|---|---|---|",
    ]
    drapes = {}
    for fabric in [only] if only else BANDS:
        line, drapes[fabric] = row(fabric)
        print(line, flush=True)
        rows.append(line)
    if not only:
        head, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(head + BEGIN + "\n".join(rows) + "\n" + END + rest.split(END)[1])
        picture(drapes)


if __name__ == "__main__":
    main()
