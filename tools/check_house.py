"""Checks that the tree keeps its rules: who may import whom, what the engine avoids, which paths exist.

Run by `make lint`; prints one line for each broken rule and fails if there is any.
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENGINE = ROOT / "crates" / "taut" / "src"
PACKAGE = ROOT / "python" / "taut"

# A room of the engine may use the rooms named here and itself.
ENGINE_RULES: dict[str, set[str]] = {
    "geometry": set(),
    "scene": set(),
    "model": {"scene", "geometry"},
    "inputs": {"scene", "model", "geometry"},
    "schedule": {"scene", "model", "inputs", "geometry"},
    "state": {"schedule", "model", "inputs", "geometry"},
    "forces": {"scene", "model", "inputs", "schedule", "state", "geometry"},
    "integrate": {"forces", "scene", "model", "inputs", "schedule", "state", "geometry"},
    "contact": {"model", "geometry"},
    "filter": {"contact", "scene", "model", "inputs", "schedule", "state", "geometry"},
    "diagnostics": {"model", "inputs", "state", "geometry", "forces", "filter"},
    "prepare": {"scene", "model", "inputs", "schedule", "contact"},
    "step": {
        "model",
        "inputs",
        "schedule",
        "state",
        "geometry",
        "forces",
        "integrate",
        "filter",
        "diagnostics",
    },
    "advance": {"model", "inputs", "schedule", "state", "diagnostics", "step"},
    "world": {"geometry", "scene", "model", "inputs", "state", "prepare", "step", "advance"},
}

# What the engine never touches: files, clocks, the network, printing.
FORBIDDEN_IN_ENGINE = re.compile(
    r"\bstd::(fs|net|time|process|env)\b|\be?print(ln)?!|\bdbg!|\bSystemTime\b|\bInstant\b|\bfmul_add|\.mul_add\("
)

# Functions whose last bits the platform chooses; geometry/functions.rs has others. Tests may use them.
FROM_THE_PLATFORM = re.compile(
    r"\.(a?(sin|cos|tan)h?|atan2|sin_cos|exp|exp2|exp_m1|ln|ln_1p|log|log2|log10|powf|powi|hypot|cbrt)\("
    r"|\b(to_radians|to_degrees|from_euler|to_euler|from_axis_angle|from_scaled_axis|to_axis_angle)\b"
    r"|\b(from_rotation_\w+|from_angle|angle_between|angle_to|to_angle|slerp|rotate_towards)\b"
)

# Modules of the package that may not import the ones on the right.
PACKAGE_RULES: dict[str, set[str]] = {
    "formats": {"bench", "cli", "cache", "compare", "figures", "render", "run", "simulation", "view"},
    "render": {"bench", "cli", "cache", "compare", "figures", "formats", "run", "simulation", "view"},
    "cache": {"bench", "cli", "compare", "figures", "render", "formats", "run", "view"},
    "scene": {"bench", "cli", "cache", "compare", "figures", "render", "run", "simulation", "view"},
    "simulation": {"bench", "cli", "compare", "figures", "render", "view"},
    "simulated": {"bench", "cli", "compare", "figures", "render", "simulation", "view"},
    "run": {"bench", "cli", "compare", "figures", "render", "view"},
    "bench": {"cli", "cache", "render", "run", "compare", "figures", "view"},
    "compare": {"cli", "formats", "figures", "view"},
    "figures": {"cli", "formats", "view"},
    "doctor": {"cli", "cache", "compare", "figures", "formats", "run", "view"},
    "laboratory": {"bench", "cli", "cache", "compare", "figures", "render", "formats", "run", "view"},
    "view": {"bench", "cli", "compare", "figures", "render", "run"},
}

LONGEST_FILE = 450


def engine_imports() -> list[str]:
    """Imports between the rooms of the engine that its rules do not allow."""
    broken = []
    for path in sorted(ENGINE.rglob("*.rs")):
        room = path.relative_to(ENGINE).parts[0].removesuffix(".rs")
        if room == "lib":
            continue
        if room not in ENGINE_RULES:
            broken.append(f"{path.relative_to(ROOT)}: no rule for the room `{room}`; add it to ENGINE_RULES")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for other in re.findall(r"\bcrate::(\w+)", line):
                if other != room and other not in ENGINE_RULES[room]:
                    broken.append(f"{path.relative_to(ROOT)}:{number}: `{room}` must not use `{other}`")
            if FORBIDDEN_IN_ENGINE.search(line.split("//")[0]):
                broken.append(f"{path.relative_to(ROOT)}:{number}: the engine must not use `{line.strip()}`")
    return broken


def platform_functions() -> list[str]:
    """Calls of functions that differ between machines, before the tests of a file begin."""
    broken = []
    for path in sorted(ENGINE.rglob("*.rs")):
        for number, line in enumerate(path.read_text().partition("#[cfg(test)]")[0].splitlines(), 1):
            if found := FROM_THE_PLATFORM.search(line.split("//")[0]):
                broken.append(
                    f"{path.relative_to(ROOT)}:{number}: `{found[0].strip('.(')}` differs between machines; "
                    "use that of geometry/functions.rs"
                )
    return broken


def tests_of_the_engine() -> list[str]:
    """Files of tests that are neither a program nor a module of one, so that nothing runs them."""
    crate = ENGINE.parent
    manifest = tomllib.loads((crate / "Cargo.toml").read_text())
    programs = {test["name"] for test in manifest["test"]}
    texts = [(crate / "tests" / f"{program}.rs").read_text() for program in programs]
    modules = {module for text in texts for module in re.findall(r"^mod (\w+);", text, re.MULTILINE)}
    return [
        f"{path.relative_to(ROOT)}: nothing runs it; name it in crates/taut/tests/suite.rs"
        for path in sorted((crate / "tests").glob("*.rs"))
        if path.stem not in programs | modules
    ]


def package_imports() -> list[str]:
    """Imports between the modules of the package that its rules do not allow."""
    broken = []
    for path in sorted(PACKAGE.rglob("*.py")):
        module = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for other in re.findall(r"(?:from|import) taut\.(\w+)", line):
                if other in PACKAGE_RULES.get(module, set()):
                    broken.append(f"{path.relative_to(ROOT)}:{number}: `{module}` must not import `{other}`")
    return broken


def paths_in_documents() -> list[str]:
    """Paths that a document names in backticks and that are not there."""
    broken = []
    for document in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]:
        for path in re.findall(
            r"`((?:crates|python|scenes|docs|tests|tools|benches)/[\w./-]*)`", document.read_text()
        ):
            if not (ROOT / path).exists():
                broken.append(f"{document.relative_to(ROOT)}: names `{path}`, which does not exist")
    return broken


def long_files() -> list[str]:
    """Files that have grown out of their room."""
    broken = []
    for folder in ("benches", "crates", "python", "tests", "tools"):
        for path in sorted((ROOT / folder).rglob("*")):
            if (
                path.suffix in {".rs", ".py", ".js", ".css"}
                and (lines := len(path.read_text().splitlines())) > LONGEST_FILE
            ):
                broken.append(f"{path.relative_to(ROOT)}: {lines} lines; split it (at most {LONGEST_FILE})")
    return broken


def main() -> None:
    """Prints every broken rule."""
    checks = (
        engine_imports,
        platform_functions,
        tests_of_the_engine,
        package_imports,
        paths_in_documents,
        long_files,
    )
    broken = [line for check in checks for line in check()]
    print("\n".join(broken))
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
