"""An environment of its own for each engine, under ``out/peers/env``."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from engines import RUNNING_PYTHON, Engine

ADAPTERS = Path(__file__).resolve().parent / "adapters"
TOOLS = {"node": "Node.js 20 or newer", "npm": "Node.js 20 or newer", "cargo": "Rust 1.90 or newer"}
"""Programs that some engines need, and what they are part of."""


class UnavailableError(Exception):
    """An engine cannot be installed here; the message says why, in one sentence."""


def prepare(engine: Engine, folder: Path) -> list[str]:
    """Install an engine unless that is done.

    Args:
        engine: what to install.
        folder: where its environment belongs.

    Returns:
        The command that runs its adapter; the job file is to be added.

    Raises:
        UnavailableError: it cannot be installed here.
    """
    adapter = str(ADAPTERS / engine.adapter)
    if not engine.packages:
        return [sys.executable, adapter]
    if adapter.endswith(".toml"):
        return [_build(engine, adapter, folder)]
    stamp = folder / "installed.json"
    wanted = json.dumps([engine.python, *engine.packages])
    if not stamp.exists() or stamp.read_text() != wanted:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        print(f"{engine.title}: installing {' '.join(engine.packages)}", flush=True)
        (_install_npm if adapter.endswith(".mjs") else _install_pip)(engine, folder)
        stamp.write_text(wanted)
    return [_tool(engine, "node") if adapter.endswith(".mjs") else str(_python_in(folder)), adapter]


def _build(engine: Engine, manifest: str, folder: Path) -> str:
    """Build an adapter that is a program in Rust; `cargo` knows itself what is built already."""
    folder.mkdir(parents=True, exist_ok=True)
    options = ["--quiet", "--release", "--locked", "--manifest-path", manifest, "--target-dir", str(folder)]
    _run(engine, [_tool(engine, "cargo"), "build", *options], folder)
    return str(folder / "release" / f"{engine.name}-adapter")


def _install_npm(engine: Engine, folder: Path) -> None:
    (folder / "package.json").write_text('{"private": true}\n')
    npm = _tool(engine, "npm")
    _run(engine, [npm, "install", "--silent", "--no-audit", "--no-fund", *engine.packages], folder)


def _install_pip(engine: Engine, folder: Path) -> None:
    _run(engine, [_interpreter(engine), "-m", "venv", "."], folder)
    # Only wheels: building an engine from its sources is another matter.
    options = ["--quiet", "--disable-pip-version-check", "--only-binary", ":all:"]
    _run(engine, [str(_python_in(folder)), "-m", "pip", "install", *options, *engine.packages], folder)


def _python_in(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _tool(engine: Engine, name: str) -> str:
    path = shutil.which(name)
    if path is None:
        raise UnavailableError(f"{engine.title} is left out: it needs `{name}` ({TOOLS[name]}) on the PATH.")
    return path


def _interpreter(engine: Engine) -> str:
    """A Python that an engine's packages are made for: this one, or one on the PATH, of pyenv or of uv."""
    if engine.python in ("", RUNNING_PYTHON):
        return sys.executable
    name = f"python{engine.python}"
    finders = [
        [name],
        ["pyenv", "exec", name],
        ["uv", "run", "--no-project", "--python", engine.python, "python"],
    ]
    environment = {**os.environ, "PYENV_VERSION": engine.python}
    for finder in finders:
        if shutil.which(finder[0]) is None:
            continue
        command = [*finder, "-c", "import sys; print(sys.executable)"]
        found = subprocess.run(command, env=environment, capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.strip()
    raise UnavailableError(
        f"{engine.title} is left out: its package needs Python {engine.python}, which is not here; "
        f"install it (for example `uv python install {engine.python}`) and run again."
    )


def _run(engine: Engine, command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["no message"]
        raise UnavailableError(
            f"{engine.title} is left out: `{' '.join(engine.packages)}` could not be installed ({lines[-1]})."
        )
