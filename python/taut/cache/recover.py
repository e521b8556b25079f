"""What is checked before a run goes on in a cache that is there."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from taut.cache.header import Header
from taut.cache.layout import CONSTANT
from taut.cache.reader import Cache
from taut.errors import CacheError

FREE = {"title", "duration"}
"""Fields of a scene that may differ: they do not change what a frame holds."""


def check_same_run(cache: Cache, header: Header) -> None:
    """Make sure that new frames would follow from the old ones.

    Raises:
        CacheError: the version, the scene or a mesh differs; the first difference is named.
    """
    old, new = cache.attributes, header.attributes
    remedy = "undo that change, choose another name or overwrite the cache (--overwrite)"
    if old["version"] != new["version"]:
        raise CacheError(
            f"{cache.path} was written by taut {old['version']}; this is {new['version']}; last bits may "
            f"differ; choose another name or overwrite the cache (--overwrite)"
        )
    scenes = [{name: value for name, value in run["scene"].items() if name not in FREE} for run in (old, new)]
    difference = first_difference(scenes[0], scenes[1], "scene")
    if difference:
        raise CacheError(f"{cache.path} belongs to another scene: {difference}; {remedy}")
    for name, digest in new["meshes"].items():
        if old["meshes"].get(name) != digest:
            raise CacheError(
                f"{cache.path} belongs to another scene: the geometry of {name} differs; {remedy}"
            )
    difference = first_difference(old["substeps"], new["substeps"], "substeps")
    if difference or cache.vertices != header.vertices:
        difference = difference or "it has other vertices"
        raise CacheError(f"{cache.path} belongs to another scene: {difference}; {remedy}")
    for name in CONSTANT:
        if not np.array_equal(getattr(cache, name), header.arrays[name]):
            raise CacheError(
                f"{cache.path}: the array {name} is not that of the scene; overwrite it (--overwrite)"
            )


def first_difference(old: Any, new: Any, field: str) -> str | None:
    """Where two JSON values first differ, and how; nothing where they are equal."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for name in [*old, *(name for name in new if name not in old)]:
            found = first_difference(old.get(name), new.get(name), f"{field}.{name}")
            if found:
                return found
        return None
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return next(
            filter(None, (first_difference(a, b, f"{field}[{index}]") for index, (a, b) in pairs)), None
        )
    return None if old == new else f"{field} is {_short(old)} in the cache and {_short(new)} now"


def _short(value: Any) -> str:
    text = "not given" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def last_whole_frame(cache: Cache) -> int:
    """Index of the last frame that reads back as it was written.

    Raises:
        CacheError: there is none, or the numbers of the frames are damaged.
    """
    for frame in reversed(range(cache.frames)):
        if cache.is_whole(frame):
            return frame
    raise CacheError(f"{cache.path}: no frame in it is whole; run it again (--overwrite)")
