"""The figures of the paper, made again: pictures, measurements and a page with both."""

from taut.figures.making import Options, make_figures
from taut.figures.section import Finding, Picture, Section

__all__ = ["Finding", "Options", "Picture", "Section", "make_figures"]
