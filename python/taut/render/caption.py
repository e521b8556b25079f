"""Titles above the panels and the colour bar below them, drawn on the finished picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from taut.render.strain import BEYOND, StrainScale

_INK, _FAINT, _ALARM, _PAPER = "#1f2933", "#5c6975", "#b3141f", "#dde4ea"


@dataclass(frozen=True)
class Caption:
    """What stands above a panel."""

    title: str
    time: float
    """[s]"""
    worst_stretch: float | None
    """Largest stretch of this frame; ``None`` if there are no springs."""
    over: bool
    """Whether that breaks the limit."""


class Letterer:
    """Draws captions and the colour bar; knows where they stand in the picture."""

    def __init__(
        self, panel: tuple[int, int], places: Sequence[tuple[int, int]], scale: StrainScale | None
    ) -> None:
        """Prepare the parts that stay the same.

        Args:
            panel: width and height of a panel [pixels].
            places: left upper corner of each panel [pixels].
            scale: what the colour bar shows; none without it.
        """
        self._panel, self._places = panel, places
        self._unit = max(0.35, min(panel[1] / 720, panel[0] / 640))
        width, height = max(x for x, _ in places) + panel[0], max(y for _, y in places) + panel[1]
        self._bar = self._draw_bar(width, scale) if scale else None
        bar_height = self._bar.height if self._bar else 0
        # H.264 wants even numbers of pixels.
        self.size = width + width % 2, (height + bar_height + 1) // 2 * 2
        self._bar_top = height

    def mount(self, image: Image.Image) -> Image.Image:
        """Put rendered panels above the bar."""
        picture = Image.new("RGB", self.size, _PAPER)
        picture.paste(image, (0, 0))
        if self._bar:
            picture.paste(self._bar, (0, self._bar_top))
        return picture

    def write(self, picture: Image.Image, captions: Sequence[Caption | None]) -> None:
        """Put captions on a picture."""
        draw = ImageDraw.Draw(picture)
        for (x, y), caption in zip(self._places, captions, strict=True):
            if caption is not None:
                self._write_caption(draw, x, y, caption)
            if x:
                draw.line(
                    [(x, y), (x, y + self._panel[1])], fill="white", width=max(1, round(2 * self._unit))
                )

    def _write_caption(self, draw: ImageDraw.ImageDraw, x: int, y: int, caption: Caption) -> None:
        left, width = x + self._pixels(26), self._panel[0] - self._pixels(52)
        title = _fitted(" ".join(caption.title.split()), self._font(26, bold=True), width)
        draw.text((left, y + self._pixels(20)), title, fill=_INK, font=self._font(26, bold=True))
        small, line = self._font(18), y + self._pixels(60)
        time = f"t = {caption.time:.2f} s"
        draw.text((left, line), time, fill=_FAINT, font=small)
        if caption.worst_stretch is not None:
            # The time keeps its place while its digits change.
            left += round(small.getlength("t = 00.00 s")) + self._pixels(22)
            finite = np.isfinite(caption.worst_stretch)
            amount = f"{_percent(caption.worst_stretch)} %" if finite else "not finite"
            color = _ALARM if caption.over or not finite else _FAINT
            text = f"worst stretch {amount}{', over the limit' if caption.over and finite else ''}"
            draw.text((left, line), _fitted(text, small, width), fill=color, font=small)

    def _draw_bar(self, width: int, scale: StrainScale) -> Image.Image:
        """The colour bar: up to the top of the scale, then a gap and the colour of what lies beyond."""
        pixels = self._pixels
        strip = Image.new("RGB", (width, pixels(74)), _PAPER)
        draw, font = ImageDraw.Draw(strip), self._font(17)
        length, thick, top = min(pixels(520), width - pixels(220)), pixels(16), pixels(14)
        left = (width - length) // 2
        shares = np.linspace(0, 1, length) * (len(scale.colors()) - 1) / scale.shares[1]
        row = scale.colors()[shares.astype(int), :3]
        strip.paste(Image.fromarray(np.broadcast_to(row, (thick, length, 3)).copy()), (left, top))
        draw.rectangle([left - 1, top - 1, left + length, top + thick], outline=_FAINT)
        right = left + length + pixels(10)
        draw.rectangle([right, top, right + pixels(26), top + thick], fill=BEYOND, outline=_FAINT)
        draw.text((right + pixels(34), top + thick // 2), "more", _INK, font, anchor="lm")
        draw.text((left - pixels(16), top + thick // 2), "stretch", _INK, font, anchor="rm")
        for share, bold in _ticks(scale):
            at = left + round(share * (length - 1))
            draw.line([(at, top + thick), (at, top + thick + pixels(5))], fill=_FAINT)
            label = f"{100 * share * scale.top:.3g} %" + (" limit" if bold else "")
            draw.text((at, top + thick + pixels(8)), label, _INK, self._font(17, bold), anchor="mt")
        return strip

    def _pixels(self, length: float) -> int:
        return max(1, round(length * self._unit))

    def _font(self, size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
        return _load_font(self._pixels(size), bold)


@cache
def _load_font(size: int, bold: bool) -> ImageFont.FreeTypeFont:
    # matplotlib brings a font with Latin, Greek and Cyrillic letters to every system.
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path(), "fonts", "ttf", name)), size)


def _ticks(scale: StrainScale) -> list[tuple[float, bool]]:
    """Places on the bar, as shares, and whether each is the limit."""
    limit = None if scale.limit is None else scale.limit / scale.top
    if limit is None or not 0.2 <= limit <= 0.8:
        ticks = [(share, False) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
    else:
        ticks = [(0.0, False), (limit, True), (1.0, False)]
    return ticks


def _percent(stretch: float) -> str:
    percent = 100 * stretch
    return (
        f"{percent:.2f}"
        if abs(percent) < 10
        else f"{percent:.1f}"
        if abs(percent) < 1000
        else f"{percent:.3g}"
    )


def _fitted(text: str, font: ImageFont.FreeTypeFont, width: int) -> str:
    """Cut a text that is too long for its place."""
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "…") > width:
        text = text[:-1]
    return text.rstrip() + "…"
