"""Builds the wheel for `pip install ./python`: gets what compiling needs, as `make wheel` does, and leaves the rest to maturin."""

import os
import pathlib
import subprocess

from maturin import *  # noqa: F403: the hooks of a build backend
from maturin import build_editable as _build_editable
from maturin import build_wheel as _build_wheel

SETUP = pathlib.Path(__file__).resolve().parents[1] / "tools" / "setup.sh"


def _prepare():
    if os.name == "posix" and SETUP.exists():
        subprocess.run([SETUP, "build", "python"], check=True)


def build_wheel(*arguments, **settings):
    _prepare()
    return _build_wheel(*arguments, **settings)


def build_editable(*arguments, **settings):
    _prepare()
    return _build_editable(*arguments, **settings)
