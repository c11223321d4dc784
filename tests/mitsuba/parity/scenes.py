"""Writes the scenes of the parity suite, one small XML file each, beside itself.

    python tests/mitsuba/parity/scenes.py

Each scene tries one plugin, or one parameter that changes an image, on the same stage: a ball and a floor under
a broad lamp and a dim sky. The stage is bright on all sides, so that few samples make an image without outliers:
what is tested is what plugins mean, not how well light is found. render.py renders them with Mitsuba.
"""
import math
import pathlib
import xml.etree.ElementTree as ET

FOLDER = pathlib.Path(__file__).parent


def rgb(name, *values):
    return f'<rgb name="{name}" value="{", ".join(map(str, values))}"/>'


def number(name, value):
    return f'<float name="{name}" value="{value}"/>'


def integer(name, value):
    return f'<integer name="{name}" value="{value}"/>'


def string(name, value):
    return f'<string name="{name}" value="{value}"/>'


def boolean(name, value):
    return f'<boolean name="{name}" value="{str(value).lower()}"/>'


def to_world(inside):
    return f'<transform name="to_world">{inside}</transform>'


def bsdf(kind, *inside):
    return f'<bsdf type="{kind}">{"".join(inside)}</bsdf>'


def shape(kind, *inside):
    return f'<shape type="{kind}">{"".join(inside)}</shape>'


def bitmap(name, file="../color.png", raw=True, *rest):
    # Mitsuba would keep 8-bit images as half floats: 11 bits.
    return (f'<texture type="bitmap" name="{name}">{string("filename", file)}{boolean("raw", raw)}'
            f'{string("format", "variant")}{"".join(rest)}</texture>')


def checkerboard(name):
    return (f'<texture type="checkerboard" name="{name}">{rgb("color0", 0.2, 0.3, 0.6)}{rgb("color1", 0.9, 0.8, 0.5)}'
            '<transform name="to_uv"><scale x="5" y="3"/></transform></texture>')


DIFFUSE = bsdf("diffuse", rgb("reflectance", 0.7, 0.4, 0.2))
GOLD = string("material", "Au")
GGX, BECKMANN = string("distribution", "ggx"), string("distribution", "beckmann")
RED = rgb("diffuse_reflectance", 0.7, 0.2, 0.1)
TINTS = rgb("specular_reflectance", 0.9, 0.5, 0.2) + rgb("specular_transmittance", 0.3, 0.6, 0.8)
AREA = f'<emitter type="area">{rgb("radiance", 4, 3, 2)}</emitter>'

FLOOR = shape("rectangle", to_world('<scale value="3"/><translate z="-0.8"/>'), bsdf("diffuse", rgb("reflectance", 0.5, 0.45, 0.4)))
LAMP = shape("rectangle", to_world('<scale value="1.5"/><rotate x="1" angle="180"/><translate x="0.5" y="-0.5" z="2.5"/>'), AREA)
SKY = f'<emitter type="constant">{rgb("radiance", 0.6, 0.7, 0.9)}</emitter>'
LIGHT = LAMP + SKY
LOOK = '<lookat origin="0.3, -4, 1.2" target="0, 0, -0.1" up="0, 0, 1"/>'
BOX = '<rfilter type="box"/>'


HUE = rgb("base_color", 0.8, 0.3, 0.1)


def ball(material):
    return shape("sphere", number("radius", 0.7), to_world('<rotate x="1" angle="30"/><rotate z="1" angle="40"/>'), material)


def square(material):
    """A square that leans towards the camera; its uv go from 0 to 1."""
    return shape("rectangle", to_world('<scale value="0.8"/><rotate x="1" angle="60"/><rotate z="1" angle="20"/>'), material)


def quilt(material):
    """A bent mesh with normals, uv and colours at its vertices, where the square stands."""
    return shape("ply", string("filename", "quilt.ply"),
                 to_world('<scale value="0.8"/><rotate x="1" angle="60"/><rotate z="1" angle="20"/>'), material)


def quilt_ply(cells=6):
    """z = 0.2 cos 2x cos 2y over [-1, 1]^2, its normals, uv in [0, 1]^2, and colours that follow x and y."""
    head = ["ply", "format ascii 1.0", "comment z = 0.2 cos 2x cos 2y: written by scenes.py",
            f"element vertex {(cells + 1) ** 2}"]
    head += [f"property float {name}" for name in "x y z nx ny nz u v r g b".split()]
    head += [f"element face {2 * cells * cells}", "property list uchar int vertex_indices", "end_header"]
    vertices, faces = [], []
    for j in range(cells + 1):
        for i in range(cells + 1):
            u, v = i / cells, j / cells
            x, y = 2 * u - 1, 2 * v - 1
            z = 0.2 * math.cos(2 * x) * math.cos(2 * y)
            nx, ny = 0.4 * math.sin(2 * x) * math.cos(2 * y), 0.4 * math.cos(2 * x) * math.sin(2 * y)
            length = math.sqrt(nx * nx + ny * ny + 1)
            row = [x, y, z, nx / length, ny / length, 1 / length, u, v, 0.2 + 0.6 * u, 0.8 - 0.5 * v, 0.3 + 0.4 * u * v]
            vertices.append(" ".join(f"{value:.6g}" for value in row))
            if i < cells and j < cells:
                k = j * (cells + 1) + i
                faces += [f"3 {k} {k + 1} {k + cells + 2}", f"3 {k} {k + cells + 2} {k + cells + 1}"]
    return "\n".join(head + vertices + faces) + "\n"


def film(width=32, height=32, rest=BOX):
    return f'<film type="hdrfilm">{integer("width", width)}{integer("height", height)}{rest}</film>'


def sensor(kind, *inside, film=film(), look=LOOK):
    return f'<sensor type="{kind}">{"".join(inside)}{to_world(look)}<sampler type="independent"/>{film}</sensor>'


CAMERA = sensor("perspective", number("fov", 35))


def integrator(kind, *inside):
    return f'<integrator type="{kind}">{"".join(inside)}</integrator>'


PATH = integrator("path", integer("max_depth", 6))


def scene(objects, light=LIGHT, camera=CAMERA, by=PATH):
    return f'<scene version="3.0.0">{by}{camera}{light}{FLOOR}{objects}</scene>'


def bsdfs():
    def rough(kind, distribution, alpha_u, alpha_v, *rest):
        if alpha_u == alpha_v:
            return bsdf(kind, distribution, number("alpha", alpha_u), *rest)
        return bsdf(kind, distribution, number("alpha_u", alpha_u), number("alpha_v", alpha_v), *rest)

    def blend(weight, *parts):
        return bsdf("blendbsdf", weight if isinstance(weight, str) else number("weight", weight), *parts)

    height = bitmap("map", "../height.png")
    normals = bitmap("normalmap")
    on_ball = {
        "diffuse": DIFFUSE,
        "dielectric": bsdf("dielectric"),
        "dielectric-tinted": bsdf("dielectric", TINTS, number("int_ior", 1.2), number("ext_ior", 1.5)),
        "thindielectric": bsdf("thindielectric", TINTS),
        "conductor": bsdf("conductor", GOLD),
        "conductor-eta-k": bsdf("conductor", rgb("eta", 1.5, 0.4, 2), rgb("k", 3, 2, 0.1)),
        "roughconductor-ggx": rough("roughconductor", GGX, 0.3, 0.3, GOLD),
        "roughconductor-ggx-anisotropic": rough("roughconductor", GGX, 0.4, 0.15, GOLD),
        "roughconductor-beckmann": rough("roughconductor", BECKMANN, 0.2, 0.2),
        "roughconductor-beckmann-anisotropic": rough("roughconductor", BECKMANN, 0.1, 0.5),
        "roughdielectric-ggx": rough("roughdielectric", GGX, 0.3, 0.3),
        "roughdielectric-ggx-anisotropic": rough("roughdielectric", GGX, 0.5, 0.2, TINTS),
        "roughdielectric-beckmann": rough("roughdielectric", BECKMANN, 0.25, 0.25, number("int_ior", 1.8)),
        "plastic": bsdf("plastic", RED),
        "plastic-nonlinear": bsdf("plastic", RED, boolean("nonlinear", True), number("int_ior", 1.9)),
        "roughplastic-ggx": rough("roughplastic", GGX, 0.3, 0.3, RED),
        "roughplastic-beckmann-nonlinear": rough("roughplastic", BECKMANN, 0.1, 0.1, RED, boolean("nonlinear", True)),
        "principled": bsdf("principled", HUE, number("roughness", 0.4), number("sheen", 0.7), number("sheen_tint", 0.5),
                           number("flatness", 0.5), number("clearcoat", 0.8), number("clearcoat_gloss", 0.3)),
        "principled-metal": bsdf("principled", HUE, number("roughness", 0.5), number("metallic", 0.8), number("anisotropic", 0.7),
                                 number("spec_tint", 0.5)),
        "principled-glass": bsdf("principled", HUE, number("roughness", 0.5), number("spec_trans", 0.9), number("eta", 1.5)),
        "principledthin": bsdf("principledthin", HUE, number("roughness", 0.4), number("sheen", 0.7), number("sheen_tint", 0.5),
                               number("flatness", 0.5), number("diff_trans", 0.8)),
        "principledthin-glass": bsdf("principledthin", HUE, number("roughness", 0.6), number("spec_trans", 0.8), number("eta", 1.4),
                                     number("anisotropic", 0.6), number("spec_tint", 0.5)),
        # Without smooth mirrors beside a density, which Mitsuba 3.9.1 darkens: see bsdf_oracle.py.
        "blendbsdf": blend(0.4, DIFFUSE, rough("roughconductor", GGX, 0.3, 0.3, GOLD)),
        "blendbsdf-smooth": blend(0.4, bsdf("thindielectric", TINTS), bsdf("conductor", GOLD)),
        "blendbsdf-nested": blend(0.7, rough("roughdielectric", GGX, 0.5, 0.5),
                                  blend(0.4, rough("roughplastic", GGX, 0.3, 0.3, RED), bsdf("twosided", DIFFUSE))),
        "null": bsdf("null"),
        "mask": bsdf("mask", number("opacity", 0.3), DIFFUSE),
        "texture-checkerboard": bsdf("diffuse", checkerboard("reflectance")),
    }
    on_square = {
        "mask-texture": bsdf("mask", bitmap("opacity"), bsdf("twosided", DIFFUSE)),
        "twosided": bsdf("twosided", DIFFUSE),
        "blendbsdf-texture": blend(bitmap("weight"), DIFFUSE, rough("roughplastic", GGX, 0.2, 0.2)),
        "blendbsdf-turned-away": blend(0.6, bsdf("twosided", bsdf("diffuse"), bsdf("bumpmap", height, number("scale", 0.3), DIFFUSE)),
                                       bsdf("twosided", rough("roughconductor", GGX, 0.3, 0.1, GOLD))),
        "twosided-turned-away": bsdf("twosided", bsdf("diffuse"), rough("roughconductor", GGX, 0.3, 0.1, GOLD)),
        "bumpmap": bsdf("bumpmap", height, number("scale", 0.3), DIFFUSE),
        "bumpmap-roughplastic": bsdf("bumpmap", height, number("scale", 0.3), rough("roughplastic", GGX, 0.3, 0.3)),
        "normalmap": bsdf("normalmap", normals, DIFFUSE),
        "normalmap-roughconductor": bsdf("normalmap", normals, rough("roughconductor", GGX, 0.3, 0.3)),
        "texture-bitmap-srgb": bsdf("diffuse", bitmap("reflectance", "../color.png", False)),
        "texture-bitmap-nearest-mirror": bsdf("diffuse", bitmap(
            "reflectance", "../color.png", True, string("filter_type", "nearest"), string("wrap_mode", "mirror"),
            '<transform name="to_uv"><scale x="2" y="2.5"/></transform>')),
        "texture-roughness": bsdf("roughconductor", bitmap("alpha", "../height.png")),
        "texture-specular": rough("roughdielectric", GGX, 0.4, 0.4, bitmap("specular_transmittance")),
    }
    on_mesh = {
        "diffuse": DIFFUSE,
        "roughconductor": rough("roughconductor", GGX, 0.4, 0.2, GOLD),
        "conductor": bsdf("conductor", GOLD),
        "roughplastic": rough("roughplastic", GGX, 0.2, 0.2, RED),
        "bumpmap": bsdf("bumpmap", height, number("scale", 0.3), DIFFUSE),
        "normalmap": bsdf("normalmap", normals, DIFFUSE),
        "mesh-attribute": bsdf("diffuse", '<texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_color"/></texture>'),
    }
    for name, material in on_ball.items():
        yield f"bsdf-{name}", scene(ball(material))
    for name, material in on_square.items():
        stands = square(material)
        if name.endswith("turned-away"):
            stands = stands.replace('angle="60"', 'angle="-120"')
        yield f"bsdf-{name}", scene(stands)
    for name, material in on_mesh.items():
        yield f"mesh-{name}", scene(quilt(material))


def emitters():
    down = '<rotate x="1" angle="160"/><translate x="0.4" y="-0.6" z="2.2"/>'
    lamps = {
        "rectangle": shape("rectangle", to_world('<scale x="0.5" y="0.8"/>' + down), AREA),
        "disk": shape("disk", to_world('<scale value="0.7"/>' + down), AREA),
        "sphere": shape("sphere", number("radius", 0.4), '<point name="center" x="0.5" y="-1" z="1.2"/>', AREA),
        "sphere-around": shape("sphere", number("radius", 9), boolean("flip_normals", True), AREA),
        "cylinder": shape("cylinder", number("radius", 0.2), to_world('<rotate x="1" angle="70"/><translate y="0.4" z="1.4"/>'), AREA),
        "mesh": shape("cube", to_world('<scale value="0.3"/><rotate x="1" angle="30"/><translate x="0.6" y="-1" z="1.2"/>'), AREA),
        "textured": shape("rectangle", to_world('<scale value="0.7"/>' + down),
                          f'<emitter type="area">{bitmap("radiance")}</emitter>'),
        "reflecting": shape("rectangle", to_world(down), bsdf("twosided", DIFFUSE), AREA),
    }
    for name, lamp in lamps.items():
        yield f"emitter-area-{name}", scene(ball(DIFFUSE), lamp)

    def envmap(file, *rest):
        return f'<emitter type="envmap">{string("filename", file)}{"".join(rest)}</emitter>'

    others = {
        "point": f'<emitter type="point"><point name="position" x="1" y="-2" z="2"/>{rgb("intensity", 8, 4, 2)}</emitter>',
        "spot": '<emitter type="spot"><transform name="to_world"><lookat origin="1, -2, 2" target="0, 0, 0" up="0, 0, 1"/></transform>'
                f'{rgb("intensity", 8, 4, 2)}{number("cutoff_angle", 25)}{number("beam_width", 12)}</emitter>',
        "directional": f'<emitter type="directional"><vector name="direction" x="-1" y="2" z="-3"/>{rgb("irradiance", 3, 2, 1)}</emitter>',
        "constant": SKY,
        "envmap": envmap("../environment.exr"),
        "envmap-turned": envmap("../environment.exr", number("scale", 2.5),
                                to_world('<rotate x="1" angle="77"/><rotate z="1" angle="30"/>')),
        "envmap-8-bit": envmap("../environment.png"),
        "sunsky": f'<emitter type="sunsky"><vector name="sun_direction" x="0.4" y="-0.5" z="0.7"/>{number("sky_scale", 30)}</emitter>',
        "sunsky-wide": '<emitter type="sunsky"><vector name="sun_direction" x="-0.6" y="-0.6" z="0.25"/>'
                       f'{number("sun_aperture", 25)}{number("turbidity", 6.5)}{rgb("albedo", 0.1, 0.4, 0.8)}{number("sky_scale", 10)}</emitter>',
        "of-many-kinds": SKY + LAMP
            + f'<emitter type="point"><point name="position" x="1" y="-2" z="2"/>{rgb("intensity", 3, 2, 1)}</emitter>'
            + f'<emitter type="directional"><vector name="direction" x="1" y="2" z="-3"/>{rgb("irradiance", 0.5, 1, 1)}</emitter>',
    }
    for name, light in others.items():
        yield f"emitter-{name}", scene(ball(DIFFUSE), light)


# Something to see in sharp and in blurred pieces, sparing with noise.
SUBJECT = ball(bsdf("plastic", checkerboard("diffuse_reflectance")))


def sensors():
    wide = film(40, 24)
    cameras = {
        "perspective-fov-axis-y": sensor("perspective", number("fov", 30), string("fov_axis", "y"), film=wide),
        "perspective-fov-axis-diagonal": sensor("perspective", number("fov", 40), string("fov_axis", "diagonal"), film=wide),
        "perspective-fov-axis-smaller": sensor("perspective", number("fov", 30), string("fov_axis", "smaller"), film=wide),
        "perspective-fov-axis-larger": sensor("perspective", number("fov", 40), string("fov_axis", "larger"), film=film(24, 40)),
        "perspective-focal-length": sensor("perspective", string("focal_length", "50mm"), film=wide),
        "perspective-principal-point": sensor("perspective", number("fov", 35), number("principal_point_offset_x", 0.15),
                                              number("principal_point_offset_y", -0.1)),
        "perspective-clipped": sensor("perspective", number("fov", 35), number("near_clip", 3.7), number("far_clip", 4.8)),
        "perspective-cropped": sensor("perspective", number("fov", 35), film=film(
            64, 48, integer("crop_offset_x", 20) + integer("crop_offset_y", 9) + integer("crop_width", 32)
            + integer("crop_height", 28) + BOX)),
        "thinlens": sensor("thinlens", number("fov", 35), number("aperture_radius", 0.2), number("focus_distance", 3.4)),
        "orthographic": sensor("orthographic", look='<scale value="1.4"/>' + LOOK),
    }
    for name, camera in cameras.items():
        yield f"sensor-{name}", scene(SUBJECT, camera=camera)


def filters():
    plugins = {
        "box": BOX,
        "tent": '<rfilter type="tent"/>',
        "gaussian": '<rfilter type="gaussian"/>',
        "mitchell": '<rfilter type="mitchell"/>',
        "catmullrom": '<rfilter type="catmullrom"/>',
        "lanczos": '<rfilter type="lanczos"/>',
    }
    for name, plugin in plugins.items():
        # Large enough for a hundred pixels that share no sample: tests/support/parity.rs takes no others.
        size = 66 if name == "lanczos" else 48
        yield f"filter-{name}", scene(SUBJECT, camera=sensor("perspective", number("fov", 35), film=film(size, size, plugin)))


def integrators():
    glass = ball(bsdf("dielectric"))
    lamp = shape("sphere", number("radius", 0.25), '<point name="center" x="-0.8" y="-0.3" z="0.5"/>', AREA)
    kinds = {
        "direct": integrator("direct"),
        "path-depth-1": integrator("path", integer("max_depth", 1)),
        "path-depth-2": integrator("path", integer("max_depth", 2)),
        "path-depth-3": integrator("path", integer("max_depth", 3)),
        "path-roulette": integrator("path", integer("rr_depth", 2)),
        "path-hidden-emitters": integrator("path", integer("max_depth", 6), boolean("hide_emitters", True)),
        "volpath": integrator("volpath", integer("max_depth", 6)),
        "aov": integrator("aov", string("aovs", "depth:depth"), integrator("path", integer("max_depth", 6))),
    }
    for name, by in kinds.items():
        yield f"integrator-{name}", scene(glass + lamp, SKY, by=by)


def refraction():
    """Radiance grows by the square of the index on its way into glass, and falls on its way out."""
    def glass_around(kind, *inside):
        # The camera, the ball and the floor are in it; shallow rays are reflected within.
        return shape("sphere", number("radius", 9), bsdf(kind, number("int_ior", 1.5), *inside))

    lamp = shape("sphere", number("radius", 0.4), AREA)
    yield "refraction-into-glass", scene(ball(DIFFUSE) + glass_around("dielectric"), SKY)
    yield "refraction-into-rough-glass", scene(ball(DIFFUSE) + glass_around("roughdielectric", GGX, number("alpha", 0.3)), SKY)
    # Seen from outside: the lamp through the ball, and a dim sky.
    yield "refraction-out-of-glass", scene(ball(bsdf("dielectric", number("int_ior", 1.5))), lamp + SKY)
    yield "refraction-out-of-rough-glass", scene(ball(bsdf("roughdielectric", GGX, number("alpha", 0.3))), lamp + SKY)


def media():
    """Light that is absorbed on its way: within glass, behind nothing, and around the camera."""
    def medium(*inside):
        return f'<medium type="homogeneous" {inside[0]}>{"".join(inside[1:])}{number("albedo", 0)}</medium>'

    by = integrator("volpathmis", integer("max_depth", 8))
    ink = (rgb("sigma_t", 0.3, 0.8, 0.5), number("scale", 1.5))
    yield "medium-in-glass", scene(ball(bsdf("dielectric", number("int_ior", 1.5)) + medium('name="interior"', *ink)), by=by)
    # Light passes the border straight on; a ball and a lamp are in it.
    cloud = shape("sphere", number("radius", 1.2), bsdf("null"), medium('name="interior"', *ink))
    lamp = shape("sphere", number("radius", 0.15), '<point name="center" x="-0.6" y="-0.6" z="0.6"/>', AREA)
    small = shape("sphere", number("radius", 0.4), bsdf("diffuse", rgb("reflectance", 0.7, 0.6, 0.5)))
    yield "medium-in-nothing", scene(cloud + lamp + small, by=by)
    # A bubble of clear air, and a camera that is told what it is in.
    water = medium('id="water"', rgb("sigma_t", 0.15, 0.05, 0.02))
    sea = shape("sphere", number("radius", 9), bsdf("dielectric", number("int_ior", 1.33)), '<ref name="interior" id="water"/>')
    bubble = ball(bsdf("dielectric", number("int_ior", 1.0), number("ext_ior", 1.33)) + '<ref name="exterior" id="water"/>')
    camera = sensor("perspective", number("fov", 35), '<ref id="water"/>')
    yield "medium-around-camera", scene(sea + bubble, SKY, camera, by + water)
    # Nothing but its surface bounds the pool: what the camera says it is in counts.
    surface = shape("rectangle", to_world('<scale value="3"/><translate z="1.6"/>'), bsdf("null"), '<ref name="interior" id="water"/>')
    yield "medium-below-open-water", scene(surface + ball(DIFFUSE), LAMP, camera, by + water)


def pretty(name, text):
    root = ET.fromstring(text)
    ET.indent(root)
    return f"<!-- {name}: written by scenes.py -->\n{ET.tostring(root, encoding='unicode')}\n"


def all_scenes():
    for group in (bsdfs, emitters, sensors, filters, integrators, refraction, media):
        yield from group()


def main():
    (FOLDER / "quilt.ply").write_text(quilt_ply())
    for name, text in all_scenes():
        (FOLDER / f"{name}.xml").write_text(pretty(name, text))


if __name__ == "__main__":
    main()
