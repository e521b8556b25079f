"""The plot of a scene: what each method does over time."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from taut.compare.contact.comparing import SceneFound
from taut.compare.contact.methods import NAMES
from taut.compare.plots import LOOK

_COLORS = ("#1d5c9c", "#d1495b", "#7d4f9e", "#e07a1f", "#8a8f98")
_LEAST_GAP = 1e-9  # of the thickness, below which a plot does not go


def draw_plot(scene: SceneFound, out: Path) -> None:
    """Closest distance, worst stretch, crossings and energy over time, into a file."""
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure = Figure(figsize=(7.6, 7.4))
        panels = list(figure.subplots(4 - bool(scene.no_energy), sharex=True))
        for run in scene.runs:
            look: dict[str, Any] = {
                "color": _COLORS[NAMES.index(run.method)],
                "linewidth": 2.2 if run.method == "ours" else 1.3,
                "label": run.method,
            }
            time = [moment.time for moment in run.moments]
            bad = np.array([moment.crossings > 0 or moment.inside > 0 for moment in run.moments])
            gaps = np.array([moment.closest for moment in run.moments])
            panels[0].plot(time, np.where(bad, np.nan, gaps.clip(_LEAST_GAP)), **look)
            panels[1].plot(time, [100 * moment.worst_stretch for moment in run.moments], **look)
            panels[2].plot(time, [moment.crossings for moment in run.moments], **look)
            if not scene.no_energy:
                panels[3].plot(
                    time, [moment.energy - run.moments[0].energy for moment in run.moments], **look
                )
        panels[0].set(yscale="log", ylabel="closest, over\nthe thickness")
        panels[1].set(ylabel="worst stretch [%]")
        panels[1].set_ylim(0, min(panels[1].get_ylim()[1], 1000 * (scene.limit or 1.0)))
        if scene.limit:
            panels[1].axhline(100 * scene.limit, color="#1f2933", linewidth=1.0, linestyle=(0, (5, 3)))
        panels[2].set(ylabel="edges through\ntriangles")
        if not scene.no_energy:
            panels[3].set(ylabel="all energy [J]\nless that at the start")
        panels[-1].set_xlabel("time [s]")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
        FigureCanvasAgg(figure)
        figure.savefig(out, dpi=130)
