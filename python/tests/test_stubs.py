"""The stubs say what the compiled module has."""

from __future__ import annotations

import subprocess
import sys

import pytest


def test_stubs_have_the_modules_names_arguments_and_bases(tmp_path):
    pytest.importorskip("mypy")
    # In a folder without a source of the package: what is installed is asked.
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "nephroid"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "no issues found in" in done.stdout, done.stdout
