"""Pictures of simulations: stills and films, several side by side, made without a display."""

from taut.render.options import RenderError, RenderOptions
from taut.render.rendering import FILM_EXTENSIONS, STILL_EXTENSIONS, render_film, render_still
from taut.render.strip import render_strip

__all__ = [
    "FILM_EXTENSIONS",
    "STILL_EXTENSIONS",
    "RenderError",
    "RenderOptions",
    "render_film",
    "render_still",
    "render_strip",
]
