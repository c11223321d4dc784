"""Values of Mitsuba in dicts."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

import nephroid as ne
from conftest import ROOT
from test_dicts import ball, heightfield

mi = pytest.importorskip("mitsuba", reason="Mitsuba is not installed: nothing of it can be passed")


@pytest.fixture(params=["scalar_rgb", "llvm_ad_rgb"])
def variant(request):
    try:
        mi.set_variant(request.param)
    except Exception as error:  # A machine without LLVM.
        pytest.skip(str(error))


def test_a_loaded_scene_is_refused():
    mi.set_variant("scalar_rgb")
    loaded = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
    for refuse in (ne.load_dict, ne.render):
        with pytest.raises(TypeError, match="pass the dict"):
            refuse(loaded)


def test_mitsubas_values_are_understood(variant):
    scene = ball()
    scene["floor"]["to_world"] = mi.ScalarTransform4f().scale([3, 3, 1])
    scene["lamp"]["position"] = mi.ScalarPoint3f(0, 0, 4)
    scene["ball"]["bsdf"]["int_ior"] = 1.5
    plain, of_mitsuba = ne.load_dict(ball()), ne.load_dict(scene)
    one, two = (ne.render(one, photons=16384) for one in (plain, of_mitsuba))
    assert np.array_equal(one.value, two.value)


def test_mitsubas_meshes_and_bitmaps_are_understood(variant):
    positions, faces = heightfield(0.1)
    mesh = mi.Mesh("lens", len(positions), len(faces))
    params = mi.traverse(mesh)
    params["vertex_positions"] = positions.astype(np.float32).ravel()
    params["faces"] = faces.astype(np.uint32).ravel()
    params.update()
    scene = ball()
    scene["ball"] = {"type": "mesh", "mesh": mesh, "bsdf": {"type": "dielectric"}}
    arrays = {"type": "mesh", "vertex_positions": positions.astype(np.float32), "faces": faces, "bsdf": {"type": "dielectric"}}
    one = ne.render(ne.load_dict(scene), photons=16384)
    two = ne.render(ne.load_dict({**scene, "ball": arrays}), photons=16384)
    assert one.value.max() > 0 and np.array_equal(one.value, two.value)
    bitmap = mi.Bitmap(np.full((4, 4, 3), 0.25, dtype=np.float32))
    scene["floor"]["bsdf"] = {"type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": bitmap, "raw": True}}
    assert ne.load_dict(scene).sensors == ["floor.meter"]


def test_a_mesh_with_a_surface_of_its_own_is_refused(variant):
    for bsdf in ({"type": "diffuse", "reflectance": 0.9}, {"type": "dielectric"}):
        loaded = mi.load_dict({"type": "cube", "bsdf": bsdf})
        for form in (loaded, {"type": "mesh", "mesh": loaded}):
            scene = ball()
            scene["ball"] = form
            with pytest.raises(ne.LoadError, match="bsdf"):
                ne.load_dict(scene)


def test_a_film_becomes_a_bitmap(variant):
    film = ne.render(ne.load_dict(ball()), photons=4096)
    np.testing.assert_allclose(np.array(film.bitmap()), film.value, rtol=1e-6)


def test_the_example_fits_a_heightfield_and_says_which_steps_are_better(capsys):
    found = importlib.util.spec_from_file_location("heightfield", ROOT / "python/examples/heightfield.py")
    example = importlib.util.module_from_spec(found)
    found.loader.exec_module(example)
    steps = example.fit(32)
    assert "step 6" in capsys.readouterr().out
    # From the start on, each of three steps is better: their intervals do not overlap.
    for (_, (least, _)), (_, (_, most)) in zip(steps[:3], steps[1:4], strict=True):
        assert most < least
    # The goal's own distance from itself is not above zero, and what the bounds leave open is less than any of those steps.
    judge = example.Judge(32)
    least, most = judge.l1(example.GOAL)
    assert least == 0.0 and 0.0 < most < 0.01
    # The optimiser's images have a noise of 3 % a square, so that it ends near the goal, and not at it.
    assert 5 * steps[-1][1][1] < steps[0][1][0]
