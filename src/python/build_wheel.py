"""The build backend of pyproject.toml: cargo builds the program, maturin the module, and one wheel has both.

NEARMISS_PROFILE names cargo's profile; release is the default.
"""

import json
import os
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import build_sdist, get_requires_for_build_sdist, get_requires_for_build_wheel  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "src/python/nearmiss_av.data/scripts"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    profile = os.environ.get("NEARMISS_PROFILE", "release")
    _build_program(profile)
    os.environ.setdefault("MATURIN_PEP517_ARGS", f"--profile {profile}")
    try:
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    finally:
        shutil.rmtree(SCRIPTS.parent)


def _build_program(profile):
    """Builds the program and puts it where wheels have their scripts."""
    command = ["cargo", "build", "--locked", "--profile", profile, "--package", "nearmiss", "--bin", "nearmiss"]
    # The module beside it, so that both are built of the same parts, once.
    command += ["--package", "nearmiss-python", "--message-format", "json-render-diagnostics"]
    built = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
    artifacts = [json.loads(line) for line in built.stdout.splitlines() if line.startswith("{")]
    programs = [one["executable"] for one in artifacts if one.get("executable")]
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    shutil.copy2(programs[-1], SCRIPTS)
