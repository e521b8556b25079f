"""Numbers in text files."""

import math
from collections.abc import Iterator


def lines_of(data: bytes, comment: str | None = None) -> Iterator[tuple[int, list[str]]]:
    """The words of each line that has any, with its number from 1; without comments."""
    # Latin-1 decodes every byte: names and comments may be in any encoding.
    text = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
    for number, line in enumerate(text.split("\n"), start=1):
        words = (line.partition(comment)[0] if comment else line).split()
        if words:
            yield number, words


def reals(words: list[str]) -> list[float] | None:
    """The finite numbers that these words are; none if one is something else."""
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return None
    # Python's own grouping of digits is no part of a number.
    return numbers if all(map(math.isfinite, numbers)) and not any("_" in word for word in words) else None


def integers(words: list[str]) -> list[int] | None:
    """The integers of up to 18 digits that these words are; none if one is something else."""
    try:
        numbers = [int(word) for word in words]
    except ValueError:
        return None
    return numbers if not any("_" in word or len(word) > 18 for word in words) else None


def quoted(words: list[str]) -> str:
    """Words of a file as errors show them: in short, and in ASCII."""
    text = " ".join(words).encode("ascii", "backslashreplace").decode()
    text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return f"`{text if len(text) <= 60 else text[:57] + '...'}`"
