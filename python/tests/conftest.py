"""Fixtures of all tests: a scratch folder to work in, and the program of the wheel."""

import csv
import io
import os
import subprocess
import sys

import pytest

import diffract


@pytest.fixture(autouse=True)
def scratch(tmp_path, monkeypatch):
    """Makes a scratch folder the working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def program():
    """Returns a function that runs the program, which must succeed, and returns what it prints."""

    def run(*words, stdin=""):
        command = [sys.executable, "-m", "diffract", *map(str, words)]
        ran = subprocess.run(command, input=stdin, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
        return ran.stdout

    return run


@pytest.fixture
def answers(program):
    """Returns a function that runs the program and returns the rows of the CSV that it prints."""

    def run(*words, stdin=""):
        return list(csv.DictReader(io.StringIO(program(*words, stdin=stdin))))

    return run


@pytest.fixture
def without_vulkan():
    """Returns the environment of a machine whose Vulkan loader finds no driver."""
    return {**os.environ, "VK_DRIVER_FILES": "/nowhere.json", "VK_ICD_FILENAMES": "/nowhere.json"}


@pytest.fixture(scope="session")
def blaze():
    """Returns a grating."""
    return diffract.HeightField.generate("blaze")


@pytest.fixture(scope="session")
def brdf(blaze):
    """Returns its BRDF, ready to answer."""
    made = blaze.brdf()
    made(diffract.direction(30, 0), diffract.direction(46.05, 180), 550e-9)
    return made
