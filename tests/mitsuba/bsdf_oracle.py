"""What Mitsuba says of bsdfs, direction by direction: writes bsdf_oracle.txt beside itself.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/bsdf_oracle.py

Variant scalar_rgb. Each case is a bsdf as in a scene file, on the square [-1, 1]^2 with normal +z at
uv = (0.3, 0.7). Then, for pairs of directions away from the surface (theta and phi in degrees):

    eval  wi wo  f cos r g b (radiance)  f cos r g b (importance)  pdf
    delta wi u   wo x y z  weight r g b (radiance)  weight r g b (importance)  pdf  eta
"""
import pathlib
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent

IMAGES = {
    # name: (rows, columns, channels), values drawn once
    "color.png": (3, 4, 3),
    "height.png": (4, 4, 1),
}


def write_images():
    rng = np.random.default_rng(7)
    for name, shape in IMAGES.items():
        texels = rng.integers(30, 226, shape, dtype=np.uint8)
        mi.Bitmap(texels).write(str(FOLDER / name))


def bitmap(name, parameter, raw=True):
    # Half floats, Mitsuba's default for 8-bit images, would round to 11 bits.
    return (f'<texture type="bitmap" name="{parameter}"><string name="filename" value="{name}"/>'
            f'<boolean name="raw" value="{str(raw).lower()}"/><string name="format" value="variant"/></texture>')


def rough(kind, distribution, alpha, rest=""):
    if isinstance(alpha, tuple):
        alphas = f'<float name="alpha_u" value="{alpha[0]}"/><float name="alpha_v" value="{alpha[1]}"/>'
    else:
        alphas = f'<float name="alpha" value="{alpha}"/>'
    return f'<bsdf type="{kind}"><string name="distribution" value="{distribution}"/>{alphas}{rest}</bsdf>'


GOLD = '<string name="material" value="Au"/>'
TINTS = ('<rgb name="specular_reflectance" value="0.9, 0.5, 0.2"/>'
         '<rgb name="specular_transmittance" value="0.3, 0.6, 0.8"/>')
RED = '<rgb name="diffuse_reflectance" value="0.7, 0.2, 0.1"/>'
DIFFUSE = '<bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.4, 0.2"/></bsdf>'

RAW_ALPHA = '<texture type="rawconstant" name="alpha"><float name="value" value="0.2"/></texture>'
RAW_RED = '<texture type="rawconstant" name="reflectance"><vector name="value" x="0.7" y="0.2" z="0.1"/></texture>'

CASES = [
    DIFFUSE,
    f'<bsdf type="twosided">{DIFFUSE}</bsdf>',
    f'<bsdf type="twosided">{DIFFUSE}{rough("roughconductor", "ggx", (0.3, 0.1), GOLD)}</bsdf>',
    f'<bsdf type="mask"><float name="opacity" value="0.3"/>{rough("roughdielectric", "ggx", 0.3)}</bsdf>',
    f'<bsdf type="mask">{bitmap("color.png", "opacity")}{DIFFUSE}</bsdf>',
    f'<bsdf type="diffuse">{bitmap("color.png", "reflectance", raw=False)}</bsdf>',
    f'<bsdf type="diffuse">{RAW_RED}</bsdf>',
    rough("roughconductor", "ggx", 0.05, GOLD),
    rough("roughconductor", "ggx", (0.4, 0.15), GOLD + '<rgb name="specular_reflectance" value="0.9, 0.5, 0.2"/>'),
    rough("roughconductor", "beckmann", 0.3),
    f'<bsdf type="roughconductor">{RAW_ALPHA}<rgb name="eta" value="0.2, -0.1, 1"/><rgb name="k" value="3, 3, -1"/></bsdf>',
    rough("roughconductor", "beckmann", (0.1, 0.5), '<rgb name="eta" value="1.5, 0.4, 2"/><rgb name="k" value="3, 2, 0.1"/>'),
    f'<bsdf type="roughconductor">{bitmap("height.png", "alpha")}</bsdf>',
    rough("roughdielectric", "ggx", 0.1),
    rough("roughdielectric", "ggx", (0.5, 0.2), TINTS),
    rough("roughdielectric", "beckmann", 0.4, '<float name="int_ior" value="1"/><float name="ext_ior" value="1.33"/>'),
    rough("roughdielectric", "beckmann", (0.2, 0.6), '<float name="int_ior" value="2.4"/>'),
    '<bsdf type="plastic"/>',
    f'<bsdf type="plastic">{RED}<boolean name="nonlinear" value="true"/><float name="int_ior" value="1.9"/></bsdf>',
    f'<bsdf type="plastic">{RED}<float name="int_ior" value="1"/><float name="ext_ior" value="1.3"/></bsdf>',
    rough("roughplastic", "ggx", 0.3, RED),
    rough("roughplastic", "beckmann", 0.1, RED + '<boolean name="nonlinear" value="true"/>'),
    rough("roughplastic", "beckmann", 0.6, '<float name="int_ior" value="1.9"/><rgb name="specular_reflectance" value="0.9, 0.5, 0.2"/>'),
    f'<bsdf type="bumpmap">{bitmap("height.png", "map")}<float name="scale" value="0.8"/>{DIFFUSE}</bsdf>',
    f'<bsdf type="bumpmap">{bitmap("height.png", "map")}<float name="scale" value="3"/>{rough("roughplastic", "ggx", 0.3)}</bsdf>',
    f'<bsdf type="normalmap">{bitmap("color.png", "normalmap")}{rough("roughconductor", "ggx", (0.3, 0.1))}</bsdf>',
    f'<bsdf type="normalmap">{bitmap("color.png", "normalmap")}<boolean name="flip_invalid_normals" value="false"/>'
    f'<boolean name="use_shadowing_function" value="false"/>{DIFFUSE}</bsdf>',
    f'<bsdf type="twosided"><bsdf type="normalmap">{bitmap("color.png", "normalmap")}{rough("roughplastic", "ggx", 0.2)}</bsdf></bsdf>',
    f'<bsdf type="normalmap">{bitmap("color.png", "normalmap")}{rough("roughdielectric", "ggx", 0.3)}</bsdf>',
    rough("roughconductor", "ggx", 0.3, GOLD + bitmap("color.png", "specular_reflectance")),
    rough("roughdielectric", "ggx", 0.4, bitmap("color.png", "specular_transmittance")),
]

def principled(rest="", **numbers):
    floats = "".join(f'<float name="{name}" value="{value}"/>' for name, value in numbers.items())
    return f'<bsdf type="principled">{floats}{rest}</bsdf>'


HUE = '<rgb name="base_color" value="0.8, 0.3, 0.1"/>'
# Appended: what comes before keeps its numbers.
LATER_CASES = [
    principled(),
    principled(HUE, roughness=0.4, flatness=0.6, sheen=0.8, sheen_tint=0.5, specular=0.9),
    principled(HUE, roughness=0.5, metallic=0.7, anisotropic=0.8, spec_tint=0.6),
    principled(HUE, roughness=0.6, clearcoat=0.9, clearcoat_gloss=0.2, eta=1.2),
    principled(HUE, roughness=0.5, spec_trans=1, eta=1.7),
    principled(HUE, roughness=0.7, spec_trans=0.6, metallic=0.3, anisotropic=0.4, spec_tint=0.5, sheen=0.4, clearcoat=0.5, eta=0.8),
    f'<bsdf type="twosided">{principled(bitmap("color.png", "base_color"), roughness=0.3)}</bsdf>',
    principled(bitmap("height.png", "roughness") + bitmap("height.png", "spec_trans")),
    principled(HUE, roughness=0.5, metallic=1, anisotropic=1),
    principled(roughness=0.5, spec_trans=1, eta=1),
    principled(roughness=0.5, spec_trans=0.5, specular=0),
    f'<bsdf type="bumpmap">{bitmap("height.png", "map")}<float name="scale" value="0.8"/>{principled(HUE, clearcoat=1)}</bsdf>',
]


def blend(weight, first, second):
    weight = weight if isinstance(weight, str) else f'<float name="weight" value="{weight}"/>'
    return f'<bsdf type="blendbsdf">{weight}{first}{second}</bsdf>'


def thin(rest="", **numbers):
    return principled(rest, **numbers).replace("principled", "principledthin")


def wrapped(kind, inside, rest=""):
    return f'<bsdf type="{kind}">{rest}{inside}</bsdf>'


MATT = '<bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.5, 0.8"/></bsdf>'
ROUGH_GOLD = rough("roughconductor", "ggx", 0.3, GOLD)
CHECKERBOARD = ('<texture type="checkerboard" name="weight"><rgb name="color0" value="0.2, 0.2, 0.2"/>'
                '<rgb name="color1" value="0.9, 0.9, 0.9"/></texture>')
HEIGHT = bitmap("height.png", "map") + '<float name="scale" value="0.8"/>'
# Appended once more.
BLEND_CASES = [
    blend(0.3, DIFFUSE, ROUGH_GOLD),
    blend(0.7, rough("roughconductor", "ggx", (0.4, 0.15), GOLD), rough("roughplastic", "ggx", 0.3, RED)),
    blend(bitmap("color.png", "weight"), DIFFUSE, f'<bsdf type="plastic">{RED}</bsdf>'),
    blend(CHECKERBOARD, DIFFUSE, rough("roughplastic", "beckmann", 0.2)),
    blend(0.6, DIFFUSE, rough("roughdielectric", "ggx", 0.4)),
    blend(0.25, blend(0.4, DIFFUSE, ROUGH_GOLD), rough("roughplastic", "ggx", 0.2)),
    blend(0.25, rough("roughplastic", "ggx", 0.2), blend(0.4, DIFFUSE, ROUGH_GOLD)),
    blend(1.7, DIFFUSE, MATT),
    blend(-0.5, DIFFUSE, MATT),
    blend(0.35, '<bsdf type="conductor"/>', DIFFUSE),
    wrapped("twosided", blend(0.3, DIFFUSE, ROUGH_GOLD)),
    blend(0.3, f'<bsdf type="twosided">{DIFFUSE}{MATT}</bsdf>', wrapped("twosided", ROUGH_GOLD)),
    blend(0.3, wrapped("twosided", DIFFUSE), rough("roughplastic", "ggx", 0.3)),
    blend(0.3, wrapped("twosided", DIFFUSE), rough("roughdielectric", "ggx", 0.4)),
    wrapped("mask", blend(0.3, DIFFUSE, ROUGH_GOLD), '<float name="opacity" value="0.6"/>'),
    blend(0.3, '<bsdf type="null"/>', DIFFUSE),
    wrapped("bumpmap", blend(0.3, DIFFUSE, ROUGH_GOLD), HEIGHT),
    blend(0.3, wrapped("bumpmap", DIFFUSE, HEIGHT), ROUGH_GOLD),
    blend(0.3, wrapped("twosided", wrapped("bumpmap", DIFFUSE, HEIGHT)), wrapped("normalmap", ROUGH_GOLD, bitmap("color.png", "normalmap"))),
    wrapped("normalmap", blend(0.5, '<bsdf type="conductor"/>', DIFFUSE), bitmap("color.png", "normalmap")),
    thin(),
    thin(HUE, roughness=0.4, flatness=0.6, sheen=0.8, sheen_tint=0.5, diff_trans=0.7),
    thin(HUE, roughness=0.6, spec_trans=1, eta=1.7),
    thin(HUE, roughness=0.5, spec_trans=0.6, diff_trans=1.2, anisotropic=0.8, spec_tint=0.6, eta=1.3),
    thin(HUE, roughness=0.7, spec_trans=0.5, eta=0.8, sheen=0.4, spec_tint=0.5),
    thin(roughness=0.5, diff_trans=2),
    thin(bitmap("color.png", "base_color") + bitmap("height.png", "spec_trans") + bitmap("height.png", "diff_trans")),
    wrapped("bumpmap", thin(HUE, spec_trans=0.5, diff_trans=1), HEIGHT),
    blend(0.4, thin(HUE, spec_trans=0.5, diff_trans=1), DIFFUSE),
]
# Of delta lobes alone: beside a density Mitsuba 3.9.1 weighs a delta lobe by (w + w' f') / (w + w' p'), with f' and p'
# the density's value and probability in that direction. It should be 1.
BLEND_DELTA_CASES = [
    blend(0.5, f'<bsdf type="dielectric">{TINTS}</bsdf>', '<bsdf type="conductor"/>'),
    blend(0.2, wrapped("twosided", f'<bsdf type="conductor">{GOLD}</bsdf>'), '<bsdf type="conductor"/>'),
    blend(0.4, wrapped("normalmap", '<bsdf type="dielectric"/>', bitmap("color.png", "normalmap")), '<bsdf type="thindielectric"/>'),
    blend(0.3, '<bsdf type="conductor"/>', blend(0.6, f'<bsdf type="dielectric">{TINTS}</bsdf>', '<bsdf type="thindielectric"/>')),
]

DELTA_CASES = [
    '<bsdf type="dielectric"/>',
    f'<bsdf type="dielectric">{TINTS}<float name="int_ior" value="1.2"/><float name="ext_ior" value="1.7"/></bsdf>',
    f'<bsdf type="thindielectric">{TINTS}</bsdf>',
    f'<bsdf type="conductor">{GOLD}</bsdf>',
    '<bsdf type="conductor"><rgb name="eta" value="0.2, -0.1, 1"/><rgb name="k" value="3, 3, -1"/></bsdf>',
    '<bsdf type="plastic"/>',
    '<bsdf type="null"/>',
    '<bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="conductor"/></bsdf>',
    f'<bsdf type="normalmap">{bitmap("color.png", "normalmap")}<bsdf type="dielectric"/></bsdf>',
    f'<bsdf type="twosided"><bsdf type="normalmap">{bitmap("color.png", "normalmap")}<bsdf type="conductor"/></bsdf></bsdf>',
    f'<bsdf type="dielectric">{bitmap("color.png", "specular_reflectance")}{bitmap("color.png", "specular_transmittance")}</bsdf>',
    f'<bsdf type="thindielectric">{bitmap("color.png", "specular_transmittance")}</bsdf>',
    f'<bsdf type="conductor">{GOLD}{bitmap("color.png", "specular_reflectance")}</bsdf>',
]

WI = [(0, 0), (35, 20), (60, 200), (85, 310), (120, 75), (160, 260)]
WO = [(3, 10), (30, 205), (40, 100), (62, 30), (80, 330), (100, 250), (140, 60), (155, 200), (177, 300)]


def direction(angles):
    theta, phi = np.radians(angles)
    return [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]


def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.t = 1
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Normal3f(0, 0, 1))
    si.dp_du = mi.Vector3f(2, 0, 0)
    si.dp_dv = mi.Vector3f(0, 2, 0)
    si.uv = mi.Point2f(0.3, 0.7)
    si.wi = mi.Vector3f(direction(wi))
    return si


def load(text):
    mi.file_resolver().prepend(str(FOLDER))
    head, rest = text.split(" ", 1)
    return mi.load_string(f'{head} version="3.0.0" {rest}')


def numbers(*values):
    return " ".join(f"{float(x):.8g}" for value in values for x in np.ravel(value))


def main():
    write_images()
    radiance, importance = mi.BSDFContext(), mi.BSDFContext(mi.TransportMode.Importance)
    with open(FOLDER / "bsdf_oracle.txt", "w") as file:
        print(f"# Mitsuba {mi.__version__}, scalar_rgb, by bsdf_oracle.py", file=file)
        def evals(text):
            bsdf = load(text)
            print("case", text, file=file)
            for wi in WI:
                for wo in WO:
                    si, to = interaction(wi), mi.Vector3f(direction(wo))
                    value = bsdf.eval(radiance, si, to)
                    flux = bsdf.eval(importance, si, to)
                    # An opaque principled material has a density behind it, where it samples nothing.
                    samples_nothing = bsdf.sample(radiance, si, 0.5, mi.Point2f(0.3, 0.6))[0].pdf == 0 and np.max(np.array(value)) == 0
                    pdf = 0 if 'type="principled"' in text and wi[0] > 90 and samples_nothing else bsdf.pdf(radiance, si, to)
                    print("eval", *wi, *wo, numbers(value, flux, pdf), file=file)

        for text in CASES:
            evals(text)
        def deltas(text):
            bsdf = load(text)
            print("case", text, file=file)
            for wi in WI:
                for u in (0.01, 0.99):
                    si = interaction(wi)
                    sample, weight = bsdf.sample(radiance, si, u, mi.Point2f(0.3, 0.6))
                    other, flux = bsdf.sample(importance, si, u, mi.Point2f(0.3, 0.6))
                    if not mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta) and not mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null):
                        continue
                    if np.max(np.array(weight)) == 0:
                        continue
                    print("delta", *wi, u, numbers(sample.wo, weight, flux, sample.pdf, sample.eta), file=file)

        for text in DELTA_CASES:
            deltas(text)
        for text in LATER_CASES + BLEND_CASES:
            evals(text)
        for text in BLEND_DELTA_CASES:
            deltas(text)


if __name__ == "__main__":
    main()
