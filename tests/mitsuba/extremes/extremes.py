"""Mitsuba 3 in single precision at the extremes of docs/accuracy.md, sections 1 to 5.

    pip install mitsuba==3.9.1 numpy
    python tests/mitsuba/extremes/extremes.py            # all sections; a few minutes
    python tests/mitsuba/extremes/extremes.py offset     # one

Maps are `ptracer`'s, of a floor under a glass ball, seen by a camera between the two (a plane across a camera's axis has pixels of one
size). The truth is the closed form of the round scene, dealt to texels in numpy with 64-bit floats. "bias" is the error that
more photons do not take away: of two independent halves A and B of the photons, the root of the mean of (A - T)(B - T) over the lit
texels, relative to their mean; where that is within its own noise it is said to be.
"""

import math
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)

SIDE = 64
HALF = 2.0
PHOTONS = 1 << 20
RENDERS = 3  # for each half


def fresnel(cos, eta):
    """F of a smooth interface, without cancellation."""
    a = (eta - 1) * (eta + 1)
    w = np.sqrt(np.maximum(a + cos * cos, 0))
    s = a / (cos + w) ** 2
    p = (a / (eta * eta * cos + w)) * (((eta * eta + 1) * cos * cos - 1) / (eta * eta * cos + w))
    return np.minimum(np.where(a + cos * cos > 0, 0.5 * (s * s + p * p), 1.0), 1.0)


def truth(radii=(1.0,), indices=(1.0, 1.5), lamp=4.0, center=1.4, intensity=100.0, reflections=6):
    """All light on the floor [W/m^2]: direct, reflected, and through all surfaces with up to some reflections inside the innermost."""
    rings, around = 12000, 256
    u = (np.arange(rings) + 0.5) / rings
    widest = min(indices[m] * r for i, r in enumerate(radii) for m in (i, i + 1)) / (indices[0] * radii[0])
    i = math.asin(min(widest, 1.0)) * u
    width = math.asin(min(widest, 1.0)) / rings
    ratio = radii[0] / (lamp - center)
    theta = np.arcsin(ratio * np.sin(i))
    flux = 2 * math.pi * intensity * ratio**2 * np.sin(i) * np.cos(i) / np.cos(theta) * width
    b = indices[0] * radii[0] * np.sin(i)
    angle = lambda medium, surface: np.arcsin(np.minimum(b / (indices[medium] * radii[surface]), 1))
    swept, turned, passed = 0.0, 0.0, 1.0
    for k in range(len(radii)):
        arrives, leaves = angle(k, k), angle(k + 1, k)
        turned = turned + 2 * (arrives - leaves)
        last = k + 1 == len(radii)
        swept = swept + (math.pi - 2 * leaves if last else 2 * (angle(k + 1, k + 1) - leaves))
        inner = fresnel(np.cos(arrives), indices[k + 1] / indices[k])
        passed = passed * (1 - inner) ** 2
    chord = math.pi - 2 * angle(len(radii), len(radii) - 1)
    # Light is reflected up to grazing incidence, whether any gets through there or not.
    all_i = 0.5 * math.pi * u
    all_theta = np.arcsin(ratio * np.sin(all_i))
    sent = 2 * math.pi * intensity * ratio**2 * np.sin(all_i) * np.cos(all_i) / np.cos(all_theta) * (0.5 * math.pi / rings)
    back = fresnel(np.cos(all_i), indices[1] / indices[0])
    paths = [(all_i - all_theta, all_theta + math.pi - 2 * all_i, sent * back)]
    # Reflections are followed inside one ball only.
    for k in range(reflections + 1 if len(radii) == 1 else 1):
        paths.append((i - theta + swept + k * chord, theta - turned - k * chord, flux * passed * inner**k))
    grid = np.zeros((SIDE, SIDE))
    phi = 2 * math.pi * (np.arange(around) + 0.5) / around
    for place, direction, power in paths:
        r = radii[0] * np.sin(place) + (center + radii[0] * np.cos(place)) * np.tan(direction)
        lands = (np.cos(direction) > 0) & (np.abs(r) < 1.5 * HALF)
        # Every ring is turned by its own part of a step, so that no texel's border runs along a spoke.
        turn = phi[None, :] + (np.arange(rings)[lands, None] * 0.6180339887) % 1.0 * (2 * math.pi / around)
        x, y = r[lands, None] * np.cos(turn), r[lands, None] * np.sin(turn)
        weight = np.broadcast_to(power[lands, None] / around, x.shape)
        bins = np.linspace(-HALF, HALF, SIDE + 1)
        grid += np.histogram2d(y.ravel(), x.ravel(), bins=(bins, bins), weights=weight.ravel())[0]
    caustic = grid / (2 * HALF / SIDE) ** 2
    fine = 16
    p = (np.arange(SIDE * fine) + 0.5) / (SIDE * fine) * 2 * HALF - HALF
    x, y = np.meshgrid(p, p)
    direct = intensity * lamp / (x * x + y * y + lamp * lamp) ** 1.5
    direct[np.hypot(x, y) < lamp * math.tan(math.asin(ratio))] = 0
    return caustic + direct.reshape(SIDE, fine, SIDE, fine).mean(axis=(1, 3))


def scene(scale=1.0, offset=(0.0, 0.0, 0.0), radii=(1.0,), indices=(1.0, 1.5), lamp=4.0, center=1.4, intensity=100.0):
    T = mi.ScalarTransform4f
    at = lambda x, y, z: [scale * x + offset[0], scale * y + offset[1], scale * z + offset[2]]
    eye = 0.3
    camera = {
        "type": "perspective",
        "fov": 2 * math.degrees(math.atan(HALF / eye)),
        "near_clip": 1e-3 * scale,
        "far_clip": 1e3 * scale,
        "to_world": T().look_at(origin=at(0, 0, eye), target=at(0, 0, 0), up=[0, 1, 0]),
        "film": {
            "type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"},
            "pixel_format": "luminance", "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": max(1, PHOTONS // SIDE**2)},
    }
    parts = {
        "type": "scene",
        "integrator": {"type": "ptracer", "max_depth": 16},
        "camera": camera,
        "lamp": {"type": "point", "position": at(0, 0, lamp),
                 "intensity": {"type": "rgb", "value": [intensity * scale**2] * 3}},
        "floor": {"type": "rectangle", "to_world": T().translate(list(offset)).scale([HALF * scale] * 3),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5] * 3}}},
    }
    for k, radius in enumerate(radii):
        parts[f"ball{k}"] = {
            "type": "sphere", "center": at(0, 0, center), "radius": radius * scale,
            "bsdf": {"type": "dielectric", "int_ior": indices[k + 1], "ext_ior": indices[k]},
        }
    return mi.load_dict(parts)


def halves(parts):
    """Two independent maps [W/m^2], as texels of the floor: E = pi L / reflectance."""
    maps = []
    for half in range(2):
        total = np.zeros((SIDE, SIDE))
        for part in range(RENDERS):
            image = np.array(mi.render(parts, seed=1000 * half + part))
            total += image[..., 0] * (math.pi / 0.5)
        # The camera looks down with y up: columns run against x, rows against y.
        maps.append(total[::-1, ::-1] / RENDERS)
    return maps


def bias(parts, known):
    """The bias within the caustic, relative to its mean; its noise; the flux on the floor by the truth's."""
    # The lamp's shadow and the ring in it.
    p = (np.arange(SIDE) + 0.5) / SIDE * 2 * HALF - HALF
    x, y = np.meshgrid(p, p)
    lit = (np.hypot(x, y) < 1.6) & (known > 0)
    a, b = (half[lit] for half in halves(parts))
    t = known[lit]
    products = (a - t) * (b - t)
    noise = products.std() / math.sqrt(len(products))
    squared = products.mean()
    return (math.sqrt(max(squared, 0)) / t.mean(), math.sqrt(noise) / t.mean(), (a.sum() + b.sum()) / (2 * t.sum()) - 1)


def report(name, parts, known):
    try:
        off, noise, flux = bias(parts, known)
        print(f"  {name:24} bias {off:8.2%} (noise {noise:.2%}), flux {flux:+.2%}", flush=True)
    except Exception as error:  # what Mitsuba refuses is a result, too
        print(f"  {name:24} refused: {error}", flush=True)


def scale_section():
    print("1 scale: glass ball in other units")
    known = truth()
    for exponent in (-6, -4, -2, 0, 2, 4, 6):
        report(f"x 1e{exponent:+d}", scene(scale=10.0**exponent), known)


def offset_section():
    print("2 offset: glass ball away from the origin, by (x, -x, x)")
    known = truth()
    for x in (0, 10, 100, 2**10, 2**14, 2**18, 2**24):
        report(f"{x} m", scene(offset=(x, -x, x)), known)


def distance_section():
    print("3 distance: a unit sphere hit from afar, errors of the distance in f32 ulps of it; and lamps over the ball")
    rng = np.random.default_rng(3)
    parts = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
    for exponent in range(0, 9):
        worst, missed = 0.0, 0
        for _ in range(2000):
            outward = rng.normal(size=3)
            outward /= np.linalg.norm(outward)
            across = np.cross(outward, [0.3, -0.5, 0.8])
            across *= 0.6 * rng.random() / np.linalg.norm(across)
            start = np.float32(outward * (1 + 10.0**exponent))
            d = np.float32((across - start) / np.linalg.norm(across - start))
            # The same numbers, taken as exact; f64 has 29 bits to spare.
            o, v = start.astype(np.longdouble), d.astype(np.longdouble)
            a, f = v @ v, -(o @ v)
            foot = o + v * (f / a)
            discriminant = 1 - foot @ foot
            if discriminant <= 0:
                continue
            exact = float(f / a - np.sqrt(discriminant / a))
            hit = parts.ray_intersect_preliminary(mi.Ray3f(mi.Point3f(*start.tolist()), mi.Vector3f(*d.tolist())))
            if not hit.is_valid():
                missed += 1
                continue
            worst = max(worst, abs(hit.t - exact) / float(np.spacing(np.float32(exact))))
        print(f"  {10.0**exponent:.0e} radii: {worst:.1f} ulps, {missed} of 2000 missed", flush=True)
    for gap in (1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6):
        intensity, lamp = 100 * (1 + gap) ** 2, 2.4 + gap
        report(f"lamp {gap:.0e} radii off", scene(lamp=lamp, intensity=intensity), truth(lamp=lamp, intensity=intensity))


def angle_section():
    print("4 angle: relative error of mi.fresnel, worst of a family (from the same f32 arguments)")
    indices = [1.33, 1.5, 2.418, 100.0, 1 / 1.33, 1 / 1.5, 1 / 2.418, 0.01]
    families = {
        "ordinary angles": [(c / 200, e) for c in range(1, 201) for e in indices],
        "grazing, to 90 - 1e-12": [(10 ** (-k / 4), e) for k in range(4, 57) for e in indices],
        "critical angle - 1e-12": [(math.cos(math.asin(e) - 10 ** (-k / 4)), e) for k in range(4, 49) for e in indices if e < 1],
        "eta = 1 +- 1e-15": [(c / 50, 1 + s * 10.0**-k) for c in range(1, 51) for k in range(1, 16) for s in (1, -1)],
    }
    for name, cases in families.items():
        worst, total, as_asked = 0.0, 0, 0.0
        for cos, eta in cases:
            if cos > 1:
                continue
            c, e = np.float32(cos), np.float32(eta)
            found = float(mi.fresnel(float(c), float(e))[0])
            exact = float(fresnel(np.float64(c), np.float64(e)))
            asked = float(fresnel(np.float64(cos), np.float64(eta)))
            if exact > 0:
                worst = max(worst, abs(found / exact - 1))
            as_asked = max(as_asked, abs(found / asked - 1)) if asked > 0 else as_asked
            total += (found == 1.0) != (exact == 1.0)
        print(f"  {name:24} {worst:.1e}; of what was asked for in f64 {as_asked:.1e}; {total} on the wrong side of total reflection")


def index_section():
    print("5 index: balls of an index, and a film of water on a ball")
    for indices in ((1.0, 1 + 1e-12), (1.0, 1 + 1e-6), (1.0, 2.418), (1.5, 1.0)):
        report(f"{indices[1]} in {indices[0]}", scene(indices=indices), truth(indices=indices))
    for gap in (1e-1, 1e-2, 1e-3, 4e-5, 1e-7):
        film = {"radii": (1.0, 1.0 - gap), "indices": (1.0, 1.33, 1.5)}
        report(f"film {gap:.0e}", scene(**film), truth(**film))


SECTIONS = {"scale": scale_section, "offset": offset_section, "distance": distance_section, "angle": angle_section, "index": index_section}

if __name__ == "__main__":
    print(f"Mitsuba {mi.__version__} {mi.variant()}, {2 * RENDERS * PHOTONS} photons a map of {SIDE} x {SIDE} texels")
    for name in sys.argv[1:] or SECTIONS:
        SECTIONS[name]()
