"""Scenes as Mitsuba's dicts: they become the text of a scene file, without Mitsuba.

Each element stands on a line of its own, so that the place of an error is a path in the dict. Meshes, bitmaps and
tensors become files in memory.
"""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Mapping
from typing import Any
from xml.sax import saxutils

import numpy as np

from . import _nephroid
from ._errors import LoadError
from ._mesh import ARRAYS, arrays_of, ply, written
from ._nephroid import Scene
from ._text import is_of_mitsuba

#: The tag of each plugin.
TAGS = {
    "shape": "sphere rectangle disk cube cylinder obj ply serialized mesh shapegroup instance merge",
    "bsdf": "diffuse dielectric thindielectric roughdielectric conductor roughconductor plastic roughplastic twosided "
    "mask bumpmap normalmap blendbsdf null principled principledthin pplastic measured hair",
    "emitter": "area point spot directional directionalarea constant envmap sun sky sunsky projector",
    "sensor": "perspective thinlens orthographic irradiancemeter radiancemeter distant batch",
    "film": "hdrfilm specfilm ldrfilm",
    "sampler": "independent stratified multijitter orthogonal ldsampler",
    "integrator": "path direct aov depth ptracer volpath volpathmis prb prb_basic prbvolpath stokes moment",
    "rfilter": "box tent gaussian mitchell catmullrom lanczos",
    "texture": "bitmap checkerboard mesh_attribute rawconstant volume",
    "spectrum": "srgb uniform d65 blackbody regular irregular",
    "medium": "homogeneous heterogeneous",
    "phase": "isotropic hg",
}
TAG = {plugin: tag for tag, plugins in TAGS.items() for plugin in plugins.split()}

#: Objects whose name says what they are for; the others are found by their kind.
NAMED = ("medium", "spectrum", "texture")


def quoteattr(text: str) -> str:
    """An attribute's value in quotes. A dict has no parameters, so that a $ is one."""
    return saxutils.quoteattr(text.replace("$", "\\$"))


class _Writer:
    def __init__(self, root: Mapping[str, Any]) -> None:
        self.root = root
        self.lines: list[str] = []
        self.paths: list[str] = []
        self.files: list[tuple[str, bytes]] = []

    def fail(self, path: str, message: str) -> LoadError:
        return LoadError([(message, "<dict>", 0, 0)], path)

    def line(self, path: str, text: str) -> None:
        self.lines.append(text)
        self.paths.append(path)

    def leaf(self, path: str, tag: str, name: str, **attributes: str) -> None:
        named = {"name": name, **attributes}
        self.line(path, f"<{tag} " + " ".join(f"{key}={quoteattr(value)}" for key, value in named.items()) + "/>")

    def hold(self, path: str, suffix: str, contents: bytes) -> str:
        name = f"<dict>/{path}{suffix}"
        self.files.append((name, contents))
        return name

    def scene(self) -> None:
        if self.root.get("type") != "scene":
            raise self.fail("", f'type is {self.root.get("type")!r}; allowed is "scene"')
        self.line("", '<scene version="3.0.0">')
        for key, value in self.root.items():
            # A colour is written where it is used.
            is_color = isinstance(value, Mapping) and value.get("type") in ("rgb", "spectrum")
            if key != "type" and not is_color:
                self.checked(key, key, value)
        self.line("", "</scene>")

    def checked(self, path: str, name: object, value: Any) -> None:
        if not isinstance(name, str):
            raise self.fail(path, f"the key {name!r}; allowed are texts")
        try:
            self.value(path, name, value)
        except (TypeError, ValueError) as error:
            raise self.fail(path, str(error)) from None
        except RecursionError:
            raise self.fail(name, "a dict in this one holds itself, or nests too deeply") from None

    def value(self, path: str, name: str, value: Any) -> None:
        if isinstance(value, Mapping):
            self.nested(path, name, value)
        elif isinstance(value, (bool, np.bool_)):
            self.leaf(path, "boolean", name, value="true" if value else "false")
        elif isinstance(value, (int, np.integer)):
            self.leaf(path, "integer", name, value=str(int(value)))
        elif isinstance(value, (float, np.floating)):
            self.leaf(path, "float", name, value=repr(float(value)))
        elif isinstance(value, (str, os.PathLike)):
            text = os.fspath(value)
            # Names of files are relative to the working folder, as in Mitsuba.
            is_file = name == "filename" and os.path.exists(text)
            self.leaf(path, "string", name, value=os.path.abspath(text) if is_file else text)
        elif is_of_mitsuba(value, "Mesh"):
            self.mesh(path, name, value)
        elif is_of_mitsuba(value, "Bitmap"):
            self.leaf(path, "string", "filename", value=self.bitmap(path, value))
        elif is_of_mitsuba(value, "Object"):
            message = "this is an object that Mitsuba has loaded, which does not tell what it was made from; pass its dict"
            raise self.fail(path, message)
        elif "Transform" in type(value).__name__ and hasattr(value, "matrix"):  # Arrays of drjit have it, too.
            self.transform(path, name, value.matrix)
        else:
            self.array(path, name, value)

    def array(self, path: str, name: str, value: Any) -> None:
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            allowed = "dicts, numbers, texts, arrays, transforms, meshes and bitmaps"
            raise self.fail(path, f"a value of type {type(value).__name__}; allowed are {allowed}") from None
        # One value of a variant that holds many at once has a last axis of its own.
        if array.ndim > 1 and array.shape[-1] == 1 and name != "data":
            array = array[..., 0]
        if name == "data":
            planes = array[:, :, None] if array.ndim == 2 else array
            self.leaf(path, "string", "filename", value=self.image(path, planes))
        elif array.shape in ((4, 4), (3, 3)):
            self.transform(path, name, array)
        elif array.size == 1:
            self.leaf(path, "float", name, value=repr(float(array.reshape(-1)[0])))
        elif array.shape == (3,):
            tag = "rgb" if "Color3" in type(value).__name__ else "vector"
            self.leaf(path, tag, name, value=_list(array))
        else:
            raise self.fail(path, f"an array of shape {array.shape}; allowed are (3,), (3, 3) and (4, 4)")

    def transform(self, path: str, name: str, matrix: Any) -> None:
        array = np.asarray(matrix, dtype=np.float64)
        array = array[..., 0] if array.ndim == 3 and array.shape[-1] == 1 else array
        if array.shape not in ((4, 4), (3, 3)):
            raise self.fail(path, f"a matrix of shape {array.shape}; allowed are (3, 3) and (4, 4)")
        self.line(path, f'<transform name={quoteattr(name)}><matrix value="{_list(array)}"/></transform>')

    def image(self, path: str, planes: Any) -> str:
        planes = np.asarray(planes, dtype=np.float64)
        if planes.ndim != 3 or planes.shape[2] not in (1, 3, 4):
            raise self.fail(path, f"an image of shape {planes.shape}; allowed are 1, 3 and 4 channels")
        planes = np.ascontiguousarray(planes[:, :, :3] if planes.shape[2] == 4 else planes)
        return self.hold(path, ".exr", _nephroid.exr(planes))

    def bitmap(self, path: str, bitmap: Any) -> str:
        array = np.asarray(bitmap)
        if array.dtype.kind == "f":
            return self.image(path, array[:, :, None] if array.ndim == 2 else array)
        return self.hold(path, ".png", written(bitmap, "write", ".png"))

    def mesh(self, path: str, name: str, mesh: Any) -> None:
        if not _is_plain(mesh):
            message = (
                "a mesh does not tell what its surface, light or sensor was made from; pass "
                '{"type": "mesh", "mesh": mesh, "bsdf": {...}}'
            )
            raise self.fail(path, message)
        self.nested(path, name, {"type": "mesh", "mesh": mesh})

    def nested(self, path: str, name: str, value: Mapping[str, Any]) -> None:
        plugin = value.get("type")
        if not isinstance(plugin, str):
            raise self.fail(path, f"type is {plugin!r}; allowed is the name of a plugin")
        if plugin == "ref":
            self.reference(path, name, value)
        elif plugin == "rgb":
            numbers = np.asarray(value.get("value"), dtype=np.float64).reshape(-1)
            self.leaf(path, "rgb", name, value=_list(np.repeat(numbers, 3) if numbers.size == 1 else numbers))
        elif plugin == "spectrum":
            self.spectrum(path, name, value)
        else:
            self.plugin(path, name, plugin, value)

    def reference(self, path: str, name: str, value: Mapping[str, Any]) -> None:
        goal = str(value.get("id"))
        objects = {key: one for key, one in self.root.items() if isinstance(one, Mapping)}
        key = next((key for key, one in objects.items() if goal in (key, one.get("id"))), None)
        meant = None if key is None else objects[key]
        if meant is None:
            known = [key for key, one in self.root.items() if isinstance(one, Mapping)]
            raise self.fail(path, f'no object is called "{goal}"; there are {", ".join(known)}')
        goal = str(meant.get("id", key))
        plugin = meant.get("type", "")
        if plugin in ("rgb", "spectrum"):
            # It has no id in a scene file: it is written where it is used.
            self.nested(path, name, meant)
            return
        if TAG.get(plugin) in NAMED:
            self.leaf(path, "ref", name, id=goal)
        else:
            self.line(path, f"<ref id={quoteattr(goal)}/>")

    def spectrum(self, path: str, name: str, value: Mapping[str, Any]) -> None:
        if "filename" in value:
            self.leaf(path, "spectrum", name, filename=os.path.abspath(value["filename"]))
            return
        numbers = np.asarray(value.get("value"), dtype=np.float64)
        if numbers.ndim == 2 and numbers.shape[1] == 2:
            pairs = ", ".join(f"{wave!r}:{one!r}" for wave, one in numbers.tolist())
            self.leaf(path, "spectrum", name, value=pairs)
        elif numbers.size == 1:
            self.leaf(path, "spectrum", name, value=repr(float(numbers.reshape(-1)[0])))
        else:
            raise self.fail(path, "a spectrum's value; allowed are a number and pairs of wavelength and value")

    def plugin(self, path: str, name: str, plugin: str, value: Mapping[str, Any]) -> None:
        tag = TAG.get(plugin)
        if tag is None:
            near = difflib.get_close_matches(plugin, TAG, 1)
            hint = f'; did you mean "{near[0]}"?' if near else f"; there are {', '.join(sorted(TAG))}"
            raise self.fail(path, f'no plugin is called "{plugin}"{hint}')
        value = dict(value)
        identity = str(value.pop("id", path))
        del value["type"]
        side: str | None = None
        if tag == "shape" and ("mesh" in value or "vertex_positions" in value or plugin == "mesh"):
            plugin = "ply"
            side = self.vertices(path, value)
        named = f" name={quoteattr(name)}" if tag in NAMED else ""
        self.line(path, f"<{tag} type={quoteattr(plugin)} id={quoteattr(identity)}{named}>")
        if side is not None:
            self.leaf(path, "string", "filename", value=side)
        for key, one in value.items():
            self.checked(f"{path}.{key}", key, one)
        self.line(path, f"</{tag}>")

    def vertices(self, path: str, value: dict[str, Any]) -> str:
        """Takes a mesh or its arrays out of a shape, and makes a file of them."""
        mesh = value.pop("mesh", None)
        if mesh is not None and "bsdf" not in value and not any(
            isinstance(one, Mapping) for one in value.values()
        ) and not _is_plain(mesh):
            raise self.fail(path, 'a mesh does not tell what its surface, light or sensor was made from; give a "bsdf"')
        given = {name: value.pop(name) for name in ARRAYS if name in value}
        value.pop("filename", None)
        if mesh is not None and not given:
            return self.hold(path, ".ply", written(mesh, "write_ply", ".ply"))
        arrays = {**(arrays_of(mesh) if mesh is not None else {}), **given}
        for needed in ("vertex_positions", "faces"):
            if needed not in arrays:
                raise self.fail(path, f"a mesh without {needed}; allowed are both vertex_positions and faces, or a mesh")
        if mesh is not None and "vertex_positions" in given and "vertex_normals" not in given:
            # Those of the mesh belong to where its vertices were.
            arrays.pop("vertex_normals", None)
        try:
            return self.hold(path, ".ply", ply(arrays))
        except (TypeError, ValueError) as error:
            raise self.fail(path, str(error)) from None


def _is_plain(mesh: Any) -> bool:
    """True if all that a mesh of Mitsuba has is its form: no light, no sensor, and the surface of a shape without one."""
    if mesh.is_emitter() or mesh.is_sensor():
        return False
    surface = mesh.bsdf()
    if surface is None:
        return True
    params = sys.modules["mitsuba"].traverse(surface)
    default = "reflectance.value"
    return list(params.keys()) == [default] and bool(np.allclose(np.asarray(params[default]), 0.5, atol=1e-6))


def _list(array: Any) -> str:
    return ", ".join(repr(float(one)) for one in np.asarray(array).reshape(-1))


def _updated(scene: Mapping[str, Any], update: Mapping[str, Any]) -> dict[str, Any]:
    def copied(value: Any) -> Any:
        return {key: copied(one) for key, one in value.items()} if isinstance(value, Mapping) else value

    root: dict[str, Any] = copied(scene)
    for path, value in update.items():
        *way, last = path.split(".")
        place: Any = root
        for step in way:
            if step not in place:
                there = ", ".join(key for key in place if key != "type")
                raise LoadError([(f'update: no object is called "{step}"; there are {there}', "<dict>", 0, 0)], path)
            if is_of_mitsuba(place[step], "Mesh"):
                place[step] = {"type": "mesh", "mesh": place[step]}
            place = place[step]
            if not isinstance(place, dict):
                message = f'update: "{step}" is a value; allowed are objects before the last dot'
                raise LoadError([(message, "<dict>", 0, 0)], path)
        place[last] = value
    return root


def load_dict(scene: Mapping[str, Any], /, *, update: Mapping[str, Any] | None = None, lenient: bool = False) -> Scene:
    """Makes a scene of a dict, as ``mitsuba.load_dict`` takes it. Mitsuba itself is not needed.

    Nested dicts, numbers, texts, transforms, arrays of NumPy and drjit, ``mi.Mesh`` and ``mi.Bitmap`` are understood. A
    shape may also be ``{"type": "mesh", "vertex_positions": ..., "faces": ...}``. Objects have their path as id, as
    ``"floor.meter"``.

    ``update`` changes values by path before the scene is made, as ``{"lens.vertex_positions": a}``.

    Raises :class:`LoadError`, whose ``path`` is the place in the dict.
    """
    if is_of_mitsuba(scene, "Scene"):
        raise TypeError(
            "this is a scene that Mitsuba has loaded, which does not tell what it was made from: pass the dict"
        )
    if not isinstance(scene, Mapping):
        raise TypeError(f"a dict is needed, not {type(scene).__name__}")
    writer = _Writer(_updated(scene, update) if update else scene)
    writer.scene()
    held = [("<dict>.xml", "\n".join(writer.lines).encode()), *writer.files]
    try:
        return _nephroid.load("<dict>.xml", [], held, lenient)
    except LoadError as error:
        paths = writer.paths
        raise LoadError(error.problems, paths[error.line - 1] if 0 < error.line <= len(paths) else "") from None
