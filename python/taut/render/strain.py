"""Colours for stretch: cool up to the limit, warm above it, and one more beyond the scale."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.frames import Frames

_WITHIN = ((0.0, "#c3d0d8"), (0.4, "#98c3da"), (0.75, "#4f97c8"), (1.0, "#1d5c9c"))
_OVER = ((0.0, "#ffd75e"), (0.35, "#fb9a2b"), (0.7, "#e4432d"), (1.0, "#a3102e"))
_NO_LIMIT = ((0.0, "#c3d0d8"), (0.25, "#9fd0d8"), (0.5, "#f9dd7d"), (0.75, "#ef7b3a"), (1.0, "#a3102e"))
BEYOND = "#671a80"
"""Colour of stretch above the scale."""

_LEVELS = 1024
_BEYOND_SHARE = 0.05  # of the scale's length, kept for what lies above it
_LARGEST_SHARE = 900.0  # of VTK, which looks colours up in a texture
# Springs at their limit are over it by rounding; that is not yet a violation.
_ROUNDING = 1.002


@dataclass(frozen=True)
class StrainScale:
    """One scale for all panels, so that equal colours mean equal stretch."""

    top: float
    """Stretch at the upper end; the lower end is 0."""
    limit: float | None
    """The largest strain limit of all panels, if there is one."""

    def share(self, stretch: NDArray[np.floating]) -> NDArray[np.float32]:
        """Place stretch on the scale: 0 at the lower end, 1 at the top, more beyond it."""
        share = np.where(np.isnan(stretch), np.inf, stretch).astype(np.float64) / self.top
        shown: NDArray[np.float32] = np.clip(share, 0, _LARGEST_SHARE).astype(np.float32)
        return shown

    @property
    def shares(self) -> tuple[float, float]:
        """The range of :meth:`share` that has colours; what lies beyond has the last one."""
        return 0.0, 1 + _BEYOND_SHARE

    def colors(self) -> NDArray[np.uint8]:
        """Colours over the range :attr:`shares`, evenly spaced, shape (levels, 4)."""
        shares = np.linspace(*self.shares, _LEVELS)
        if self.limit is None or self.limit >= self.top:
            rgb = _ramp(_NO_LIMIT if self.limit is None else _WITHIN, shares)
        else:
            split = self.limit / self.top * _ROUNDING
            within, over = shares / split, (shares - split) / (1 - split)
            rgb = np.where((shares <= split)[:, None], _ramp(_WITHIN, within), _ramp(_OVER, over))
        rgb[shares > 1] = _rgb(BEYOND)
        return np.concatenate([rgb, np.full((_LEVELS, 1), 255)], axis=1).round().astype(np.uint8)

    def is_over(self, stretch: float) -> bool:
        """Whether a stretch breaks the limit by more than rounding."""
        return self.limit is not None and not stretch <= self.limit * _ROUNDING


def strain_scale(panels: Sequence[Frames], top: float | None) -> StrainScale:
    """Choose the scale: up to ``top``, or twice the largest limit, or where there is none what occurs."""
    limits = np.concatenate([np.asarray(panel.strain_limit, dtype=np.float64) for panel in panels])
    limits = limits[np.isfinite(limits)]
    limit = float(limits.max()) if limits.size else None
    if top is None:
        top = 2 * limit if limit else _round_up(max(0.01, *map(_usual_stretch, panels)))
    return StrainScale(top, limit)


def _usual_stretch(frames: Frames) -> float:
    """The stretch that 99 in 100 springs stay below, over frames spread evenly over the time."""
    chosen = np.unique(np.linspace(0, frames.frames - 1, 12).astype(int))
    values = np.concatenate([frames.stretch(int(frame)) for frame in chosen])
    values = values[np.isfinite(values)]
    return min(10.0, float(np.percentile(values, 99))) if values.size else 0.0


def _round_up(value: float) -> float:
    """The next number with one digit other than zero."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(np.ceil(value / power - 1e-9) * power)


def _ramp(stops: Sequence[tuple[float, str]], at: NDArray[np.float64]) -> NDArray[np.float64]:
    places = [place for place, _ in stops]
    channels = np.array([_rgb(color) for _, color in stops]).T
    return np.stack([np.interp(at, places, channel) for channel in channels], axis=-1)


def _rgb(color: str) -> tuple[int, int, int]:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
