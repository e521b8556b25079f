"""`taut doctor` finds what is here, and what is not."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import imageio_ffmpeg
import pytest
from taut import _taut, doctor

Command = Callable[..., Any]


def test_a_machine_that_passes_the_tests_lacks_nothing(taut: Command) -> None:
    done = taut("doctor", "--json")
    findings = {finding["name"]: finding for finding in json.loads(done.out)}
    assert [finding for finding in findings.values() if finding["remedy"] and finding["name"] != "disk"] == []
    assert _taut.__version__ in findings["taut"]["text"]
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    assert f", {cores} threads" in findings["processor"]["text"]
    assert "6305 vertices" in findings["speed"]["text"]
    assert "through" in findings["pictures"]["text"]
    assert "H.264" in findings["films"]["text"]
    assert "GB free" in findings["disk"]["text"]


def test_the_registers_are_those_of_the_processor() -> None:
    lanes = _taut.simd_lanes()
    assert lanes in (1, 4, 8, 16)
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    if "flags" in flags:  # x86 under Linux
        assert lanes == (16 if "avx512f" in flags else 8 if "avx2" in flags else 1) or "hypervisor" in flags


def test_what_is_lacking_is_told_with_a_remedy_and_a_status(
    taut: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [doctor.Finding("sun", "shines"), doctor.Finding("rain", "none", "water the plants")]
    monkeypatch.setattr(doctor, "examine", lambda folder: found)
    done = taut("doctor")
    assert done.status == 1
    assert [line.split() for line in done.out.splitlines()] == [
        ["ok", "sun", "shines"],
        ["!!", "rain", "none"],
        ["water", "the", "plants"],
    ]


def test_slow_registers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_taut, "simd_lanes", lambda: 1)
    assert "AVX2 or NEON" in doctor.vector_registers().remedy
    monkeypatch.setattr(_taut, "simd_lanes", lambda: 8)
    assert doctor.vector_registers().text == "AVX2: 8 numbers at once"


def test_no_encoder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def missing() -> str:
        raise RuntimeError("No ffmpeg exe could be found.\nMore.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", missing)
    found = doctor.film_encoder()
    assert found.text == "there is no ffmpeg that runs: No ffmpeg exe could be found."
    assert "pip install" in found.remedy
    poor = tmp_path / "ffmpeg"
    poor.write_text("#!/bin/sh\necho 'Encoders: mpeg4'\n")
    poor.chmod(0o755)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(poor))
    assert "no encoder for H.264" in doctor.film_encoder().text


def test_no_renderer(monkeypatch: pytest.MonkeyPatch) -> None:
    def dies(*_: object, **__: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], -11, "", "")

    def hangs(*_: object, **__: object) -> subprocess.CompletedProcess[str]:
        raise subprocess.TimeoutExpired("probe", 120)

    monkeypatch.setattr(subprocess, "run", dies)
    assert doctor.rendering().text == "cannot be rendered: no message (status -11)"
    monkeypatch.setattr(subprocess, "run", hangs)
    assert "libegl1" in doctor.rendering().remedy


class Usage(NamedTuple):
    total: int
    used: int
    free: int


def test_a_full_or_locked_disk(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda _: Usage(10**12, 10**12, 10**8))
    found = doctor.disk(tmp_path)
    assert found.text == f"0.1 GB free in {tmp_path}"
    assert "make room" in found.remedy
    monkeypatch.setattr("os.access", lambda *_: False)
    assert "cannot be written to" in doctor.disk(tmp_path).text
