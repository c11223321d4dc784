"""What Mitsuba says of emitters, ray by ray: writes emitter_oracle.txt and environment.{exr,png} beside itself.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/emitter_oracle.py

Variant scalar_rgb. Each case is the inside of a scene with one emitter. Then rays from places:

    ray    x y z  dx dy dz  radiance r g b  pdf     what a ray meets, and the density of its direction [1/sr] seen from there
    delta  x y z  dx dy dz  distance  r g b         the one direction to a light, and radiance by density (irradiance)
"""
import pathlib
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent
RNG = np.random.default_rng(5)

AREA = '<emitter type="area"><rgb name="radiance" value="2, 3, 5"/></emitter>'
TURN = '<rotate x="1" angle="40"/><rotate z="1" angle="-25"/><translate x="0.2" y="-0.3" z="0.1"/>'


def shape(kind, parameters="", transform=TURN):
    to_world = f'<transform name="to_world">{transform}</transform>' if transform else ""
    return f'<shape type="{kind}">{parameters}{to_world}{AREA}</shape>'


def textured(kind, transform=TURN):
    radiance = ('<texture name="radiance" type="bitmap"><string name="filename" value="color.png"/>'
                '<boolean name="raw" value="true"/><string name="format" value="variant"/></texture>')
    return (f'<shape type="{kind}"><transform name="to_world">{transform}</transform>'
            f'<emitter type="area">{radiance}</emitter></shape>')


def envmap(name, rest=""):
    return f'<emitter type="envmap"><string name="filename" value="{name}"/>{rest}</emitter>'


FLIP = '<boolean name="flip_normals" value="true"/>'
CASES = [
    shape("rectangle", transform='<scale x="0.5" y="0.8"/>' + TURN),
    shape("rectangle", FLIP),
    shape("disk", transform='<scale value="0.7"/>' + TURN),
    shape("sphere", '<float name="radius" value="0.8"/>', ""),
    shape("sphere", '<float name="radius" value="5"/>' + FLIP, ""),
    shape("cylinder", '<float name="radius" value="0.4"/>'),
    shape("cube", transform='<scale value="0.6"/>' + TURN),
    '<emitter type="constant"><rgb name="radiance" value="2, 3, 5"/></emitter>',
    envmap("environment.exr"),
    envmap("environment.exr", '<float name="scale" value="2.5"/><boolean name="mis_compensation" value="false"/>'),
    envmap("environment.png"),
    envmap("environment.exr", '<transform name="to_world"><rotate x="1" angle="77"/><rotate z="1" angle="30"/></transform>'),
    envmap("environment.exr", '<transform name="to_world"><rotate y="1" angle="100"/><scale value="1, 1, -1"/></transform>'),
]
# The density of a textured light is another: Mitsuba chooses bright texels.
TEXTURED = [textured(kind) for kind in ("rectangle", "sphere", "cube")]
DELTA = [
    '<emitter type="point"><point name="position" x="0.5" y="1" z="-1"/><rgb name="intensity" value="8, 4, 2"/></emitter>',
    '<emitter type="directional"><vector name="direction" x="1" y="-2" z="0.5"/><rgb name="irradiance" value="8, 4, 2"/></emitter>',
    '<emitter type="spot"><transform name="to_world"><lookat origin="3, 0, 0" target="0, 0, 0.2" up="0, 0, 1"/></transform>'
    '<rgb name="intensity" value="8, 4, 2"/><float name="cutoff_angle" value="50"/><float name="beam_width" value="12"/></emitter>',
]


def write_images():
    # Rows of very different light, a black column, and black neighbours.
    image = RNG.random((5, 8, 3)) ** 4 * 3
    image[:, 3] = 0
    image[2, 4] = 0
    image = image.astype(np.float32)
    bitmap = mi.Bitmap(image)
    bitmap.write(str(FOLDER / "environment.exr"))
    mi.Bitmap(RNG.integers(0, 256, (4, 6, 3), dtype=np.uint8)).write(str(FOLDER / "environment.png"))


def direction():
    while True:
        d = RNG.normal(size=3)
        if np.linalg.norm(d) > 0.1:
            return d / np.linalg.norm(d)


def numbers(*values):
    return " ".join(f"{float(x):.9g}" for value in values for x in np.ravel(value))


def rays(scene, file, with_pdf):
    lit = 0
    emitter = scene.emitters()[0]
    around = emitter.is_environment()
    for _ in range(4000):
        if lit == 40:
            break
        origin = mi.Point3f(RNG.uniform(-2, 2, 3))
        aim = direction() if around else np.array([0.2, -0.3, 0.1]) + RNG.uniform(-0.8, 0.8, 3) - np.array(origin)
        d = mi.Vector3f(aim / np.linalg.norm(aim))
        ray = mi.Ray3f(origin, d)
        si = scene.ray_intersect(ray)
        # Grazing hits turn rounding into anything.
        if si.is_valid() and abs(np.dot(np.array(si.n), np.array(d))) < 0.2:
            continue
        met = si.emitter(scene)
        if met is None:
            continue
        radiance = np.array(met.eval(si))
        reference = mi.Interaction3f()
        reference.p = origin
        pdf = scene.pdf_emitter_direction(reference, mi.DirectionSample3f(scene, si, reference))
        if radiance.max() == 0 and RNG.random() < 0.7:
            continue
        lit += radiance.max() > 0
        print("ray", numbers(origin, d, radiance), numbers(pdf) if with_pdf else "", file=file)


def deltas(scene, file):
    for _ in range(20):
        reference = mi.Interaction3f()
        reference.p = mi.Point3f(RNG.uniform(-2, 2, 3))
        sample, weight = scene.sample_emitter_direction(reference, mi.Point2f(0.3, 0.6), False)
        far = scene.emitters()[0].class_name() == "DirectionalEmitter"
        distance = np.inf if far else sample.dist
        print("delta", numbers(reference.p, sample.d, distance, weight), file=file)


# Vertex normals that oppose the winding decide which side shines. Their density is Mitsuba's only if they are along the face.
OPPOSED = [shape("obj", '<string name="filename" value="opposed.obj"/>' + flip) for flip in ("", FLIP)]


def image(name, **more):
    more = "".join(f'<string name="{key}" value="{value}"/>' for key, value in more.items())
    return (f'<texture name="{name}" type="bitmap"><string name="filename" value="color.png"/>'
            f'<boolean name="raw" value="true"/><string name="format" value="variant"/>{more}</texture>')


LOOK = '<transform name="to_world"><lookat origin="3, 0, 0.5" target="0, 0, 0.2" up="0, 0, 1"/></transform>'
# Points that shine through an image: bilinear, nearest, a cone of more than a half space, and the axes of a field of view.
THROWN = [
    f'<emitter type="spot">{LOOK}{image("texture")}<rgb name="intensity" value="8, 4, 2"/><float name="cutoff_angle" value="50"/></emitter>',
    f'<emitter type="spot">{LOOK}{image("texture", wrap_mode="mirror")}<float name="cutoff_angle" value="130"/><float name="beam_width" value="120"/></emitter>',
    f'<emitter type="projector">{LOOK}{image("irradiance")}<float name="fov" value="70"/></emitter>',
    f'<emitter type="projector">{LOOK}{image("irradiance", filter_type="nearest")}<float name="scale" value="2.5"/>'
    '<float name="fov" value="60"/><string name="fov_axis" value="y"/></emitter>',
]

def sunsky(*inside):
    return f'<emitter type="sunsky">{"".join(inside)}</emitter>'


# Wide suns, which rays meet by chance. The density of directions is another: Mitsuba has a mixture of Gaussians.
SUNSKY = [
    sunsky('<vector name="sun_direction" x="0.3" y="-0.5" z="0.6"/><float name="sun_aperture" value="50"/>'),
    sunsky('<vector name="sun_direction" x="-0.5" y="0.5" z="0.05"/><float name="turbidity" value="5.5"/><float name="sun_scale" value="0"/>'),
    sunsky('<vector name="sun_direction" x="0.2" y="0.9" z="-0.3"/><transform name="to_world"><rotate x="1" angle="-90"/></transform>'
           '<float name="turbidity" value="9.3"/><rgb name="albedo" value="0.1, 0.5, 0.9"/><float name="sky_scale" value="3"/>'
           '<float name="sun_scale" value="0.1"/><float name="sun_aperture" value="90"/>'),
    sunsky('<vector name="sun_direction" x="1" y="0" z="0.4"/><float name="turbidity" value="1"/><float name="albedo" value="1"/>'
           '<float name="sky_scale" value="0"/><float name="sun_aperture" value="120"/>'),
]


def main():
    write_images()
    mi.file_resolver().prepend(str(FOLDER))
    with open(FOLDER / "emitter_oracle.txt", "w") as file:
        print(f"# Mitsuba {mi.__version__}, scalar_rgb, by emitter_oracle.py", file=file)
        for case in CASES + TEXTURED + DELTA + OPPOSED + THROWN + SUNSKY:
            scene = mi.load_string(f'<scene version="3.0.0">{case}</scene>')
            print("case", case, file=file)
            if case in DELTA + THROWN:
                deltas(scene, file)
            else:
                rays(scene, file, case not in TEXTURED + SUNSKY)


if __name__ == "__main__":
    main()
