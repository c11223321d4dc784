"""What the tests share: the repository, the program, and scenes."""

from __future__ import annotations

import os
import pathlib
import shutil

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"


@pytest.fixture(scope="session")
def program() -> str:
    """The program, from NEPHROID or from the repository's target folder."""
    given = os.environ.get("NEPHROID", str(ROOT / "target/release/nephroid"))
    found = shutil.which(given)
    if found is None:
        pytest.skip(f"no program to compare with at {given}: cargo build --release, or set NEPHROID")
    return found
