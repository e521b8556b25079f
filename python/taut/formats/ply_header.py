"""What the head of a PLY file promises."""

from dataclasses import dataclass, field

from taut.formats.polygons import MeshError, refusal
from taut.formats.text import integers, quoted

_KINDS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    """A number of each row of an element, or a list of numbers."""

    name: str
    kind: str
    """As NumPy writes types."""
    count_kind: str | None = None
    """Of a list: the type of the number of its numbers."""


@dataclass(frozen=True)
class Element:
    """A table of a PLY file."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)

    def names(self) -> list[str]:
        """Of its properties."""
        return [one.name for one in self.properties]


@dataclass(frozen=True)
class Header:
    """All tables, in the order of the file, and how and where they are written."""

    elements: list[Element]
    order: str
    """Of bytes, as NumPy writes it; nothing for text."""
    size: int
    """Bytes before the first row."""
    lines: int
    """Lines before the first row."""


def read_header(name: str, data: bytes) -> Header:
    """Read the head of a PLY file, up to the line ``end_header``.

    Raises:
        MeshError: the file and line, what is wrong there and what is allowed.
    """
    begin = data[:5].removeprefix(b"ply")
    if begin == data[:5] or begin[:1] not in (b"\r", b"\n"):
        what = f"is no PLY file, it begins with {quoted([data[:12].decode('latin-1')])}"
        raise refusal(name, what, "the first line must be `ply`")
    end = b"\n" if b"\n" in begin else b"\r"
    size, number, order = 0, 0, None
    elements: list[Element] = []
    while True:
        stop = data.find(end, size)
        if stop < 0:
            raise refusal(name, "is cut short: its head has no line `end_header`")
        words, where = data[size:stop].decode("latin-1").split(), f"{name}:{number + 1}"
        size, number = stop + len(end), number + 1
        match words:
            case ["end_header"]:
                break
            case [] | ["ply" | "comment" | "obj_info", *_]:
                pass
            case ["format", kind, "1.0"] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", title, count] if title not in (one.name for one in elements):
                elements.append(Element(title, _rows(where, words, count)))
            case ["property", *_, title] if elements and title not in elements[-1].names():
                elements[-1].properties.append(_property(where, words))
            case _:
                raise _strange(where, words)
    if order is None:
        known = ", ".join(f"`format {kind} 1.0`" for kind in _ORDERS)
        raise refusal(name, f"does not say its format in its head: must be one of {known}")
    for element in elements:
        if element.rows and not element.properties:
            raise refusal(
                name, f"its head gives {quoted([element.name])} {element.rows} rows without a property"
            )
    return Header(elements, order, size, number)


def _rows(where: str, words: list[str], count: str) -> int:
    rows = integers([count])
    if rows is None or rows[0] < 0:
        raise refusal(where, f"{quoted(words)} must end with a number of rows")
    return rows[0]


def _property(where: str, words: list[str]) -> Property:
    match words:
        case ["property", kind, title] if kind in _KINDS:
            return Property(title, _KINDS[kind])
        case ["property", "list", count, kind, title] if kind in _KINDS and _KINDS.get(count, "f")[0] != "f":
            return Property(title, _KINDS[kind], _KINDS[count])
    raise refusal(where, f"{quoted(words)} is no property: known types are {', '.join(_KINDS)}")


def _strange(where: str, words: list[str]) -> MeshError:
    known = "format, element, property, comment, obj_info and end_header"
    return refusal(
        where,
        f"{quoted(words)} does not belong there in the head: allowed are {known}, each name once",
    )
