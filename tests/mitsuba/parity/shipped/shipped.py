"""Renders the references of tests/mitsuba/shipped.rs with Mitsuba: the shipped scenes, and light that starts at emitters.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/parity/shipped/shipped.py [NAME ...]

Variant scalar_rgb. Four kinds of images, each with its standard error over seeds, as render.py writes them:

- path-NAME.exr, NAME a scene of scenes/: what its camera sees, by `path`, 32 x 24 pixels;
- ptracer-NAME.exr: the same by `ptracer`, 16 x 12 pixels;
- the same of the scenes here, whose XML this script writes;
- floor-NAME.exr: what a pinhole camera just over the receiver sees of it, by `ptracer`, 32 x 32 pixels, one for each texel. It
  sees nothing of rough glass, metal and coats, which cannot be dimmed.

For `ptracer` lamps are hidden, every diffuse reflectance is divided by DIMMING and the image multiplied by it: what is left is
light that one matt surface scatters, L S* D E, and a part 1/DIMMING of what two scatter.
"""
import math
import pathlib
import sys
import mitsuba as mi
import numpy as np

FOLDER = pathlib.Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent))
import render  # noqa: E402
import scenes  # noqa: E402

SCENES = FOLDER.parents[3] / "scenes"
DEPTH = 16
SIDE = 32
DIMMING = 65536.0
# Photons a seed. More where emitters shine all round and few photons meet anything.
PHOTONS = 1 << 18
MORE_PHOTONS = {"glass-ball": 8, "glass-ball-mesh": 8, "floor-glass-ball": 8, "mirror-ring": 4, "pebble": 4, "lamp-in-glass": 2, "floor-water": 4, "floor-rough-plate": 8,
                "floor-coat": 16, "floor-rough-coat": 16,
                "floor-lamps-along-normals": 6, "floor-lamps-textured": 8}
SAMPLES = 64
# Light by way of the ball is found by chance; the lens leaves little light that paths find at all. One matt surface lights others in the box.
MORE_SAMPLES = {"cornell-caustics": 256, "cornell-glass": 512, "lens": 256}
SHIPPED = ["coffee-cup", "cornell-caustics", "cornell-glass", "cube", "diamond", "glass-ball", "glass-ball-mesh", "lens", "mirror-ring",
           "parabolic-mirror", "pool", "prism", "turntable-ball", "turntable-bumpy", "turntable-cube", "turntable-prism", "turntable-ring",
           "turntable-terrain", "water"]
# Of the pinhole: its place, and how far it sees on either side.
FLOORS = {"glass-ball": ([0, 0, 0.3], 2.0), "water": ([0, 0, 0.3], 0.9),
          "rough-ball": ([0, 0, 0.3], 1.0), "rough-pebble": ([0, 0, 0.3], 1.0), "rough-plate": ([0, 0, 0.3], 1.0),
          "coat": ([0, 0, 0.3], 1.0), "rough-coat": ([0, 0, 0.3], 1.0),
          "lamps-along-normals": ([0, 0, 0.3], 1.0), "lamps-textured": ([0, 0, 0.3], 1.0)}


def pebble_ply():
    """An icosahedron of smooth normals, divided once: 80 triangles, longer than high."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [(s, t * golden, 0) for s in (-1, 1) for t in (-1, 1)]
    corners = [point[k:] + point[:k] for k in (0, 1, 2) for point in corners]
    corners = np.array(corners, dtype=float) / math.hypot(1, golden)
    edge = min(np.linalg.norm(a - b) for i, a in enumerate(corners) for b in corners[:i])
    near = [[np.linalg.norm(a - b) < 1.01 * edge for b in corners] for a in corners]
    faces = [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i][j] and near[j][k] and near[i][k]]
    points, index, divided = [tuple(point) for point in corners], {}, []

    def middle(i, j):
        key = (min(i, j), max(i, j))
        if key not in index:
            point = corners[i] + corners[j]
            index[key] = len(points)
            points.append(tuple(point / np.linalg.norm(point)))
        return index[key]

    for i, j, k in faces:
        if np.dot(np.cross(corners[j] - corners[i], corners[k] - corners[i]), corners[i]) < 0:
            j, k = k, j
        a, b, c = middle(i, j), middle(j, k), middle(k, i)
        divided += [(i, a, c), (j, b, a), (k, c, b), (a, b, c)]
    head = ["ply", "format ascii 1.0", "comment written by shipped.py", f"element vertex {len(points)}"]
    head += [f"property float {name}" for name in "x y z nx ny nz".split()]
    head += [f"element face {len(divided)}", "property list uchar int vertex_indices", "end_header"]
    axes = np.array([1.0, 0.8, 0.6])
    rows = []
    for point in np.array(points):
        normal = point / axes
        rows.append(" ".join(f"{value:.6g}" for value in [*(point * axes), *(normal / np.linalg.norm(normal))]))
    return "\n".join(head + rows + [f"3 {i} {j} {k}" for i, j, k in divided]) + "\n"


def own_scenes():
    """Scenes that scenes/ has none of: coarse smooth glass, and a lamp within glass."""
    floor = scenes.shape("rectangle", scenes.to_world('<scale value="3"/><translate z="-0.8"/>'),
                         scenes.bsdf("diffuse", scenes.rgb("reflectance", 0.5, 0.4, 0.3)))
    glass = scenes.bsdf("dielectric", scenes.number("int_ior", 1.5))
    by = scenes.integrator("ptracer", scenes.integer("max_depth", DEPTH))
    camera = scenes.sensor("perspective", scenes.number("fov", 55), film=scenes.film(16, 12),
                           look='<lookat origin="0.2, -2.6, 3" target="0, 0, -0.6" up="0, 0, 1"/>')

    def point(x, y, z):
        return (f'<emitter type="point"><point name="position" x="{x}" y="{y}" z="{z}"/>'
                f'{scenes.rgb("intensity", 9, 6, 4)}</emitter>')

    pebble = scenes.shape("ply", scenes.string("filename", "pebble.ply"), glass)
    ball = scenes.shape("sphere", scenes.number("radius", 0.6), glass)
    for name, lamp, thing in [("pebble", point(0.2, 0.3, 2), pebble), ("lamp-in-glass", point(0.2, 0.1, 0.15), ball)]:
        yield name, f'<scene version="3.0.0">{by}{camera}{lamp}{floor}{thing}</scene>'


def rough_scenes():
    """A floor with a meter, and rough glass and metal over it: a ball, a mesh of smooth normals, a brushed plate, and two
    with coats."""
    film = scenes.film("$size", "$size")
    meter = f'<sensor type="irradiancemeter" id="floor"><sampler type="independent"/>{film}</sensor>'
    floor = scenes.shape("rectangle", scenes.bsdf("diffuse", scenes.rgb("reflectance", 0.8)), meter)

    def spot(origin, target, angle):
        return (f'<emitter type="spot">{scenes.rgb("intensity", 90, 60, 40)}{scenes.number("cutoff_angle", angle)}'
                + scenes.to_world(f'<lookat origin="{origin}" target="{target}" up="0, 1, 0"/>') + "</emitter>")

    def glass(alpha, distribution):
        return scenes.bsdf("roughdielectric", scenes.number("int_ior", 1.5), scenes.number("alpha", alpha),
                           scenes.string("distribution", distribution))

    copper = scenes.bsdf("roughconductor", scenes.string("material", "Cu"), scenes.number("alpha_u", 0.08),
                         scenes.number("alpha_v", 0.2), scenes.string("distribution", "beckmann"))
    ball = scenes.shape("sphere", scenes.to_world('<scale value="0.5"/><translate x="0.1" z="1"/>'), glass(0.1, "ggx"))
    pebble = scenes.shape("ply", scenes.string("filename", "pebble.ply"),
                          scenes.to_world('<scale value="0.6"/><translate x="0.1" z="1"/>'), glass(0.25, "beckmann"))
    coat = [scenes.rgb("diffuse_reflectance", 0.5), scenes.rgb("specular_reflectance", 1, 0.8, 0.6)]
    gloss = scenes.bsdf("roughplastic", *coat, scenes.number("alpha", 0.15), scenes.string("distribution", "ggx"))

    def plate(material):
        return scenes.shape("rectangle", scenes.to_world('<scale x="0.5" y="0.4"/><rotate y="1" angle="98"/>'
                                                         '<translate x="-1.15" z="0.9"/>'), material)

    for name, lamp, thing in [("rough-ball", spot("0.6, 0.2, 4", "0.1, 0, 1", 15), ball),
                              ("rough-pebble", spot("0.6, 0.2, 4", "0.1, 0, 1", 16), pebble),
                              ("rough-plate", spot("1.2, 0.2, 3", "-1.15, 0, 0.9", 14), plate(copper)),
                              ("coat", spot("1.2, 0.2, 3", "-1.15, 0, 0.9", 14), plate(scenes.bsdf("plastic", *coat))),
                              ("rough-coat", spot("1.2, 0.2, 3", "-1.15, 0, 0.9", 14), plate(gloss))]:
        default = '<default name="size" value="32"/>'
        yield name, f'<scene version="3.0.0">{default}{lamp}{floor}{thing}</scene>'


def lamp_scenes():
    """A floor with a meter, and glass under surfaces that shine along their normals, or by a texture."""
    film = scenes.film("$size", "$size")
    meter = f'<sensor type="irradiancemeter" id="floor"><sampler type="independent"/>{film}</sensor>'
    floor = scenes.shape("rectangle", scenes.bsdf("diffuse", scenes.rgb("reflectance", 0.8)), meter)
    glass = scenes.bsdf("dielectric", scenes.number("int_ior", 1.5))
    ball = scenes.shape("sphere", scenes.to_world('<scale value="0.4"/><translate x="0.1" z="0.9"/>'), glass)

    def picture(filter_type, to_uv=""):
        turn = f'<transform name="to_uv">{to_uv}</transform>' if to_uv else ""
        return ('<texture name="radiance" type="bitmap"><string name="filename" value="../../color.exr"/>'
                f'<boolean name="raw" value="true"/>{scenes.string("filter_type", filter_type)}{turn}</texture>')

    def lamp(kind, plugin, radiance, place):
        return scenes.shape(kind, scenes.to_world(place), f'<emitter type="{plugin}">{radiance}</emitter>')

    turn = '<scale x="1.3" y="0.7"/><rotate z="1" angle="33"/><translate x="0.2" y="-0.4"/>'
    down = '<rotate x="1" angle="180"/>'
    along = [
        lamp("rectangle", "directionalarea", scenes.rgb("radiance", 9, 6, 4),
             f'<scale x="0.5" y="0.3"/>{down}<rotate y="1" angle="20"/><translate x="0.7" y="-0.15" z="2.2"/>'),
        lamp("rectangle", "directionalarea", picture("bilinear", turn), f'<scale value="0.55"/>{down}<translate x="-0.2" z="2"/>'),
        lamp("disk", "directionalarea", scenes.rgb("radiance", 2, 3, 5), f'<scale value="0.6"/>{down}<translate x="0.3" y="-0.2" z="2.1"/>'),
        lamp("sphere", "directionalarea", scenes.rgb("radiance", 90, 60, 40), '<scale value="0.1"/><translate x="-0.6" y="0.5" z="1.8"/>'),
    ]
    textured = [
        lamp("rectangle", "area", picture("bilinear", turn), f'<scale x="0.5" y="0.3"/>{down}<rotate y="1" angle="20"/><translate x="0.7" z="2"/>'),
        lamp("rectangle", "area", picture("nearest"), f'<scale value="0.3"/>{down}<rotate x="1" angle="25"/><translate x="-0.6" y="0.5" z="1.5"/>'),
        lamp("sphere", "area", picture("bilinear"), '<scale value="0.2"/><rotate x="1" angle="70"/><translate x="-0.5" y="-0.6" z="1.6"/>'),
    ]
    default = '<default name="size" value="32"/>'
    for name, lamps in [("lamps-along-normals", along), ("lamps-textured", textured)]:
        yield name, f'<scene version="3.0.0">{default}{"".join(lamps)}{floor}{ball}</scene>'


def pinhole(place, half_side):
    """A camera that looks down from a place over the floor z = 0: x to the right, y upwards."""
    view = mi.ScalarTransform4f().look_at(origin=place, target=[place[0], place[1], 0], up=[0, 1, 0])
    return mi.load_dict({
        "type": "perspective", "fov": 2 * math.degrees(math.atan(half_side / place[2])), "to_world": view,
        "near_clip": 1e-3, "sampler": {"type": "independent"},
        "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}})


def dim(scene):
    params = mi.traverse(scene)
    for key in params.keys():
        if key.endswith("reflectance.value") and "specular" not in key:
            params[key] = params[key] / DIMMING
    params.update()


def camera_of(scene, width, height):
    """The camera of a scene, or the first of several, its film made small."""
    cameras = [it for it in scene.sensors() if "irradiancemeter" not in str(it).lower()]
    sensor = next((it for it in cameras if it.id() == "camera"), cameras[0])
    params = mi.traverse(sensor)
    params["film.size"] = params["film.crop_size"] = [width, height]
    params.update()
    return sensor


def save(name, file, mean, error, samples):
    render.write(FOLDER / f"{name}.exr", file, mean, error, samples, command="python tests/mitsuba/parity/shipped/shipped.py")
    print(f"{name}: mean {mean.mean():.4g}, its pixels' error {np.sqrt((error**2).mean()):.2g}", flush=True)


def by_path(name):
    file = SCENES / f"{name}.xml"
    scene = mi.load_file(str(file))
    by = mi.load_dict({"type": "path", "max_depth": DEPTH})
    samples = MORE_SAMPLES.get(name, SAMPLES)
    save(f"path-{name}", file, *render.mean_and_error(scene, camera_of(scene, 32, 24), samples, integrator=by), samples)


def by_ptracer(name, image, file, sensor=None):
    scene = mi.load_file(str(file))
    dim(scene)
    sensor = sensor or camera_of(scene, 16, 12)
    width, height = sensor.film().crop_size()
    samples = MORE_PHOTONS.get(name, 1) * PHOTONS // (width * height)
    by = mi.load_dict({"type": "ptracer", "max_depth": DEPTH, "hide_emitters": True})
    mean, error = render.mean_and_error(scene, sensor, samples, integrator=by)
    if image.startswith("floor-"):
        # Row 0 of a receiver's map is where v = 0: the lowest y.
        mean, error = mean[::-1], error[::-1]
    save(image, file, DIMMING * mean, DIMMING * error, samples)


def written(name, text):
    file = FOLDER / f"{name}.xml"
    file.write_text(scenes.pretty(name, text).replace("scenes.py", "shipped.py"))
    return file


def main():
    chosen = sys.argv[1:]
    (FOLDER / "pebble.ply").write_text(pebble_ply())
    own = {}
    for name, text in own_scenes():
        own[name] = written(name, text)
    metered = {name: written(name, text) for name, text in [*rough_scenes(), *lamp_scenes()]}
    for name in SHIPPED:
        if not chosen or f"path-{name}" in chosen:
            by_path(name)
    for name in [*own, *SHIPPED]:
        if not chosen or f"ptracer-{name}" in chosen:
            by_ptracer(name, f"ptracer-{name}", own.get(name, SCENES / f"{name}.xml"))
    for name, view in FLOORS.items():
        if not chosen or f"floor-{name}" in chosen:
            by_ptracer(f"floor-{name}", f"floor-{name}", metered.get(name, SCENES / f"{name}.xml"), pinhole(*view))


if __name__ == "__main__":
    main()
