"""Names that an option of a comparison takes."""

from collections.abc import Sequence

from taut.errors import CompareError, did_you_mean


def chosen(
    option: str, names: Sequence[str], allowed: Sequence[str], usual: Sequence[str] | None = None
) -> list[str]:
    """The names that are asked for, in the order given, each once.

    Args:
        option: what is chosen, for errors.
        names: some of those allowed, or `all`.
        allowed: which there are.
        usual: those that `all` stands for; all that are allowed when left out.

    Raises:
        CompareError: a name is unknown, or there is none.
    """
    if not names:
        raise CompareError(f"{option} is empty: name some of {', '.join(allowed)}, or all")
    for name in names:
        if name not in (*allowed, "all"):
            near = did_you_mean(name, allowed)
            raise CompareError(f"{option} = {name!r}: must be some of {', '.join(allowed)}, or all{near}")
    every = allowed if usual is None else usual
    return list(dict.fromkeys(one for name in names for one in (every if name == "all" else (name,))))
