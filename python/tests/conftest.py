"""What the tests share: the repository, the program, and scenes."""

from __future__ import annotations

import os
import pathlib
import shutil

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"

#: A glass ball between a point light and a floor, and a camera of 20 by 40 pixels: three bands of rows.
SMALL_VIEW = """
<scene version="3.0.0">
    <sensor type="perspective" id="eye">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, -3, 1" target="0, 0, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="40"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-0.5"/></transform></shape>
    <shape type="sphere"><float name="radius" value="0.4"/><bsdf type="dielectric"/></shape>
    <emitter type="point"><point name="position" value="0, 0, 3"/></emitter>
</scene>
"""


def assert_same(a, b):
    """Films are the same to the last bit."""
    assert a is not None and a.layers == b.layers and a.complete == b.complete
    for name in a.layers:
        for part in ("value", "lo", "hi", "stderr"):
            one, other = getattr(a[name], part), getattr(b[name], part)
            assert (one is None) == (other is None), (name, part)
            assert one is None or one.tobytes() == other.tobytes(), (name, part)
    assert (a.ledger, a.report, a.relative_error) == (b.ledger, b.report, b.relative_error)
    assert a.warnings == b.warnings


@pytest.fixture(scope="session")
def program() -> str:
    """The program, from NEPHROID or from the repository's target folder."""
    given = os.environ.get("NEPHROID", str(ROOT / "target/release/nephroid"))
    found = shutil.which(given)
    if found is None:
        pytest.skip(f"no program to compare with at {given}: cargo build --release, or set NEPHROID")
    return found
