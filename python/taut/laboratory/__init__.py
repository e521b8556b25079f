"""Textile tests on simulated cloth: pull a strip, drape a circle over a disc."""

from taut.laboratory.cusick import Drape, drape
from taut.laboratory.strip import Pull, pull

__all__ = ["Drape", "Pull", "drape", "pull"]
