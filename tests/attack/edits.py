"""Bytes with mistakes in them: what disks, editors and strangers do to files."""

from __future__ import annotations

from random import Random
from typing import Any

Edit = list[Any]
"""What, where (as a part of the length, so that edits mean something in shorter bytes, too), and how."""


def edit(random: Random, words: list[bytes]) -> Edit:
    """One mistake; `words` may be put in."""
    where = round(random.random(), 9)
    kinds = ["flip", "cut", "drop", "zero", "double", "noise", *(["word"] * 4 if words else [])]
    match random.choice(kinds):
        case "flip":
            return ["flip", where, 1 << random.randrange(8)]
        case "noise":
            return ["put", where, random.randbytes(random.randint(1, 8))]
        case "word":
            return ["put", where, random.choice(words)]
        case kind:
            return [kind, where, int(10 ** random.uniform(0, 3))]


def edited(content: bytes, edits: list[Edit]) -> bytes:
    """The bytes with these mistakes, one after the other."""
    for kind, where, how in edits:
        at = int(where * len(content))
        before, after = content[:at], content[at:]
        match kind:
            case "flip" if after:
                content = before + bytes([after[0] ^ how]) + after[1:]
            case "cut":
                content = before
            case "drop":
                content = before + after[how:]
            case "zero":
                content = before + bytes(len(after[:how])) + after[how:]
            case "double":
                content = before + after[:how] + after
            case "put":
                content = before + how + after
    return content
