"""Whether an error speaks in taut's own words."""

from __future__ import annotations

LONGEST = 500
"""Letters that an error may have."""


def leak(error: BaseException) -> str | None:
    """What a message has from others: from Python or a library; `None` if all of it is taut's own.

    An error is raised in place of others, which Python keeps as its cause or context. None of what those say,
    nor their names, may stand in its text. An error that replaces none and comes out of Python or a library
    itself is not asked for here: callers ask for its type.
    """
    said = str(error)
    if len(said) > LONGEST or "\n" in said or not said.isprintable():
        return f"no single, short line: {said[:LONGEST]!r}"
    for other in _replaced(error):
        for words in (str(other), type(other).__name__):
            # A word or a number may stand in both: what was given is quoted.
            if " " in words.strip() and words in said or words == type(other).__name__ and words in said:
                return words
    return None


def _replaced(error: BaseException) -> list[BaseException]:
    found: list[BaseException] = []
    following = [error.__cause__, error.__context__]
    while following:
        other = following.pop()
        # An error of taut that another one quotes is its own text.
        if other is None or other in found:
            continue
        if not type(other).__module__.startswith("taut"):
            found.append(other)
        following += [other.__cause__, other.__context__]
    return found
