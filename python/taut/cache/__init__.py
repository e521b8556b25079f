"""Frames on disk: a Zarr group that any Zarr reader can open, safe against a kill at any moment."""

from taut.cache.header import Frame, Header, mesh_hash
from taut.cache.place import check_free
from taut.cache.reader import Cache
from taut.cache.summary import Summary, cloth_of, summarize
from taut.cache.writer import CacheWriter

__all__ = [
    "Cache",
    "CacheWriter",
    "Frame",
    "Header",
    "Summary",
    "check_free",
    "cloth_of",
    "mesh_hash",
    "summarize",
]
