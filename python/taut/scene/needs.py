"""What a scene takes, before anything of it is built."""

from typing import NamedTuple, Self

_PACKED = 0.85
"""Frames of moving cloth compress to this part [1]; single precision has little to spare."""

_SPRING = 8
"""What the cache has of each spring, compressed: its ends, its length, its limit and its faces [bytes]."""


class Needs(NamedTuple):
    """What a scene takes, to about 30 per cent."""

    vertices: int
    """[1]"""
    springs: int
    """[1]"""
    memory: int
    """Of a simulation while it is built, when it takes most, beside Python and the scene itself [bytes]."""
    disk: int
    """Of the cache of a run [bytes]; less if the cloth comes to rest."""

    @classmethod
    def of(cls, vertices: int, springs: int, memory: int, written: int) -> Self:
        """From what the engine counts: `written` bytes go into all frames."""
        return cls(vertices, springs, memory, round(_PACKED * written) + _SPRING * springs)
