"""Dicts mean what files mean."""

from __future__ import annotations

import pathlib
import xml.etree.ElementTree as tree

import numpy as np
import pytest

import nephroid as ne
from conftest import ROOT

PARITY = ROOT / "tests/mitsuba/parity"


class Transform:
    """As mi.ScalarTransform4f shows itself."""

    def __init__(self, matrix):
        self.matrix = np.asarray(matrix, dtype=np.float64)


def numbers(text):
    return [float(one) for one in text.replace(",", " ").split()]


def matrix(element):
    """The matrix of a transform's steps, as Mitsuba documents them."""
    result = np.eye(4)
    for step in element:
        one = np.eye(4)
        if step.tag == "matrix":
            values = numbers(step.get("value"))
            size = 4 if len(values) == 16 else 3
            one = np.reshape(values, (size, size))
            result = np.eye(size) if size == 3 else result
        elif step.tag in ("translate", "scale"):
            is_scale = step.tag == "scale"
            given = numbers(step.get("value")) if step.get("value") else None
            triple = given * 3 if given and len(given) == 1 else given
            triple = triple or [float(step.get(axis, is_scale)) for axis in "xyz"]
            if is_scale:
                one[:3, :3] = np.diag(triple)
            else:
                one[:3, 3] = triple
        elif step.tag == "rotate":
            axis = numbers(step.get("value")) if step.get("value") else [float(step.get(one, 0)) for one in "xyz"]
            x, y, z = np.asarray(axis) / np.linalg.norm(axis)
            angle = np.radians(float(step.get("angle")))
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            one[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        elif step.tag == "lookat":
            origin, target, up = (np.asarray(numbers(step.get(one))) for one in ("origin", "target", "up"))
            ahead = (target - origin) / np.linalg.norm(target - origin)
            left = np.cross(up, ahead)
            left /= np.linalg.norm(left)
            one[:3] = np.stack([left, np.cross(ahead, left), ahead, origin], 1)
        else:
            raise LookupError(step.tag)
        result = one @ result
    return Transform(result)


def as_dict(element):
    """A scene file as a dict. What it does not know raises LookupError."""
    result = {"type": "scene" if element.tag == "scene" else element.get("type")}
    for i, child in enumerate(element):
        name = child.get("name") or child.get("id") or f"{child.tag}_{i}"
        tag, value = child.tag, child.get("value")
        if tag in ("default", "include", "path") or "$" in (value or ""):
            raise LookupError(tag)
        if tag in ("float", "integer"):
            result[name] = float(value) if tag == "float" else int(value)
        elif tag == "boolean":
            result[name] = value.lower() == "true"
        elif tag == "string":
            is_file = name == "filename"
            result[name] = str(PARITY / value) if is_file and (PARITY / value).exists() else value
        elif tag in ("point", "vector"):
            result[name] = numbers(value) if value else [float(child.get(axis, 0)) for axis in "xyz"]
        elif tag == "rgb":
            result[name] = {"type": "rgb", "value": numbers(value)}
        elif tag == "spectrum" and value and ":" not in value:
            result[name] = {"type": "spectrum", "value": float(value)}
        elif tag == "transform":
            result[name] = matrix(child)
        elif tag == "ref":
            result[name] = {"type": "ref", "id": child.get("id")}
        elif child.get("type"):
            result[name] = as_dict(child)
        else:
            raise LookupError(tag)
    return result


def parsed(path):
    """A file's root with its parameters at their defaults."""
    root = tree.parse(path).getroot()
    defaults = {one.get("name"): one.get("value") for one in root.findall("default")}
    for one in root.findall("default"):
        root.remove(one)
    for element in root.iter():
        for key, text in element.attrib.items():
            for name in sorted(defaults, key=len, reverse=True):
                text = text.replace("$" + name, defaults[name])
            element.set(key, text)
    return root


def convertible():
    for path in sorted(PARITY.glob("*.xml")):
        try:
            yield pytest.param(path, as_dict(parsed(path)), id=path.stem)
        except LookupError:
            continue


@pytest.mark.parametrize(("path", "scene"), list(convertible()))
def test_a_dict_is_the_film_of_its_file(path, scene, tmp_path):
    assert path.exists()
    of_file, of_dict = ne.load_file(path), ne.load_dict(scene)
    assert len(of_file.sensors) == len(of_dict.sensors)
    settings = {"method": "path", "spp": 2, "replicates": 2}
    try:
        one = ne.render(of_file, sensor=of_file.sensors[0], **settings)
    except ne.RefusedError:
        settings = {"method": "photons", "photons": 4096, "replicates": 2}
        one = ne.render(of_file, sensor=of_file.sensors[0], **settings)
    two = ne.render(of_dict, sensor=of_dict.sensors[0], **settings)
    assert one.value.max() > 0
    # Matrices differ in their last bits, which may lead a path in a thousand elsewhere.
    same = np.isclose(one.value, two.value, rtol=1e-6, atol=1e-9 * one.value.max())
    assert same.mean() > 0.99


def test_several_files_of_parity_are_among_them():
    assert len(list(convertible())) >= 20


def ball():
    return {
        "type": "scene",
        "lamp": {"type": "point", "position": [0.0, 0.0, 4.0], "intensity": {"type": "rgb", "value": 100.0}},
        "ball": {
            "type": "sphere",
            "center": [0.0, 0.0, 1.2],
            "radius": 1.0,
            "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0},
        },
        "floor": {
            "type": "rectangle",
            "to_world": np.diag([3.0, 3.0, 1.0, 1.0]),
            "meter": {"type": "irradiancemeter", "film": {"type": "hdrfilm", "width": 16, "height": 16}},
        },
    }


def test_ids_are_paths_and_updates_change_values():
    scene = ne.load_dict(ball())
    assert scene.sensors == ["floor.meter"]
    film = ne.render(scene, photons=16384)
    brighter = ne.load_dict(ball(), update={"lamp.intensity.value": 200.0})
    np.testing.assert_allclose(ne.render(brighter, photons=16384).value, 2 * film.value, rtol=1e-9)
    with pytest.raises(ne.LoadError, match="there are lamp, ball, floor"):
        ne.load_dict(ball(), update={"lens.bsdf.int_ior": 1.4})


def test_errors_name_the_dicts_path():
    for path, value in [("ball.bsdf.int_ior", -1.0), ("ball.bsdf.colour", 1.0), ("ball.bsdf.int_ior", "nothing")]:
        with pytest.raises(ne.LoadError) as caught:
            ne.load_dict(ball(), update={path: value})
        assert caught.value.path in (path, "ball.bsdf") and caught.value.path in str(caught.value)
    with pytest.raises(ne.LoadError, match="dielectric") as caught:
        ne.load_dict(ball(), update={"ball.bsdf.type": "dielectrik"})
    assert caught.value.path == "ball.bsdf" and "did you mean" in caught.value.hint
    with pytest.raises(ne.LoadError) as caught:
        ne.load_dict(ball(), update={"ball.center": object()})
    assert caught.value.path == "ball.center"
    with pytest.raises(TypeError):
        ne.load_dict("scene.xml")


def heightfield(bump):
    n = 9
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    height = 2 + bump * np.exp(-4 * (u * u + v * v))
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1)
    faces = np.concatenate([np.stack([corner, corner + 1, corner + n + 1], 1), np.stack([corner, corner + n + 1, corner + n], 1)])
    return np.stack([u, v, height], 2).reshape(-1, 3), faces


def test_arrays_are_meshes_and_are_updated():
    positions, faces = heightfield(0.1)
    scene = ball()
    scene["ball"] = {
        "type": "mesh",
        "vertex_positions": positions,
        "faces": faces,
        "face_normals": True,
        "bsdf": {"type": "dielectric"},
    }
    one = ne.render(ne.load_dict(scene), photons=16384)
    other, _ = heightfield(0.3)
    two = ne.render(ne.load_dict(scene, update={"ball.vertex_positions": other.astype(np.float32)}), photons=16384)
    assert one.value.max() > 0 and not np.array_equal(one.value, two.value)
    with pytest.raises(ne.LoadError, match="vertex 80|names vertex") as caught:
        ne.load_dict(scene, update={"ball.faces": faces + 50})
    assert caught.value.path == "ball"


def test_pictures_are_arrays(tmp_path):
    scene = ball()
    data = np.full((4, 4, 3), 0.25)
    scene["floor"]["bsdf"] = {"type": "diffuse", "reflectance": {"type": "bitmap", "data": data, "raw": True}}
    scene["view"] = {
        "type": "perspective",
        "to_world": np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 6], [0, 0, 0, 1.0]]),
        "film": {"type": "hdrfilm", "width": 8, "height": 8},
    }
    plain = {**scene, "floor": {**scene["floor"], "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.25}}}}
    one, two = (ne.render(ne.load_dict(d), sensor="view", method="path", spp=16) for d in (scene, plain))
    assert one.value.max() > 0
    np.testing.assert_allclose(one.value, two.value, rtol=1e-6)


def test_dollars_ids_and_colours_of_refs_are_what_they_are():
    scene = ball()
    scene["$glass"] = {"type": "dielectric", "id": "g$", "int_ior": 1.5}
    scene["white"] = {"type": "rgb", "value": 0.8}
    scene["floor"]["bsdf"] = {"type": "diffuse", "reflectance": {"type": "ref", "id": "white"}}
    for goal in ("$glass", "g$"):
        scene["ball"]["bsdf"] = {"type": "ref", "id": goal}
        assert ne.load_dict(scene).sensors == ["floor.meter"]


def test_wrong_values_name_their_path():
    for wrong in ({"type": "rgb", "value": "red"}, {1: 2, "type": "uniform"}, object()):
        scene = ball()
        scene["ball"]["bsdf"]["specular_reflectance"] = wrong
        with pytest.raises(ne.LoadError) as caught:
            ne.load_dict(scene)
        assert caught.value.path.startswith("ball.bsdf.specular_reflectance")
    positions, faces = heightfield(0.1)
    for arrays, said in [
        ({"vertex_positions": positions.T, "faces": faces}, "vertex_positions is an array of shape"),
        ({"vertex_positions": positions, "faces": faces - 1}, "faces names vertex -1"),
        ({"vertex_positions": positions, "faces": faces + 0.5}, "allowed are whole numbers"),
    ]:
        scene = ball()
        scene["ball"] = {"type": "mesh", **arrays, "bsdf": {"type": "dielectric"}}
        with pytest.raises(ne.LoadError, match=said):
            ne.load_dict(scene)


def test_a_medium_is_on_the_side_that_its_key_names():
    ink = {"type": "homogeneous", "albedo": 0.0, "sigma_t": 2.0}

    def light(**media):
        scene = ball()
        scene["ball"].update(media)
        return ne.render(ne.load_dict(scene), method="photons", photons=1 << 16).value.sum()

    # Much goes through the ball, and some is mirrored by it.
    assert light(interior=ink) < light(exterior=ink) < light()
    with pytest.raises(ne.LoadError, match='neither its "interior" nor its "exterior"'):
        light(medium=ink)
