"""Renders third-party scenes with Mitsuba, for a comparison that is made on demand.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/parity/third_party.py SCENES OUT [NAME ...]
    NEPHROID_PARITY_DIR=OUT cargo test --release --test mitsuba parity_third_party:: -- --ignored --nocapture

SCENES is the folder that the paths in tests/mitsuba/third_party_quick.txt begin at. The scenes are not part of this
repository, and neither are their images: OUT should be a temporary folder. Every scene is rendered unmodified but for
its film, which is 32 pixels wide and has a box filter, so that pixels are independent; and its integrator: path, max_depth 8.
"""
import pathlib
import sys
import mitsuba as mi
import numpy as np
import render

LIST = pathlib.Path(__file__).parent.parent / "third_party_quick.txt"
WIDTH = 32
DEPTH = 8
# Noise that leaves a bound below 1 % of what it does not explain, and the samples a pixel and seed that it may cost.
NOISE, MOST = 0.01, 2048
CONFIG = mi.parser.ParserConfig(mi.variant())


def enough(mean, error):
    """The samples a pixel and seed after which a pixel's error is NOISE of the mean, as far as MOST of them go."""
    noise = np.sqrt((error**2).mean()) / mean.mean()
    wanted = render.SAMPLES * (noise / NOISE)**2
    return int(2**np.ceil(np.log2(np.clip(wanted, render.SAMPLES, MOST))))


def load_with_small_film(file):
    """The scene, what the file says of its films replaced."""
    mi.file_resolver().prepend(str(file.parent))
    state = mi.parser.parse_file(CONFIG, str(file))
    mi.parser.transform_all(CONFIG, state)
    for node in state.nodes:
        if node.props.plugin_name() == "hdrfilm":
            width, height = (node.props.get(name, default) for name, default in [("width", 768), ("height", 576)])
            for name in list(node.props.keys()):
                if name.startswith("crop_"):
                    del node.props[name]
            node.props["width"] = WIDTH
            node.props["height"] = max(1, (WIDTH * height + width // 2) // width)
        elif str(node.type) == "ObjectType.ReconstructionFilter":
            node.props = mi.Properties("box")
    return mi.parser.instantiate(CONFIG, state)


def main():
    scenes, out, *chosen = sys.argv[1:]
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    integrator = mi.load_dict({"type": "path", "max_depth": DEPTH})
    for line in LIST.read_text().splitlines():
        name = line.split(" | ")[0]
        if line.startswith("#") or chosen and name not in chosen:
            continue
        file = pathlib.Path(scenes) / name
        try:
            scene = load_with_small_film(file)
            if scene.sensors()[0].film().rfilter().is_box_filter() is False:
                raise ValueError("the film has no filter to replace")
            mean, error = render.mean_and_error(scene, integrator=integrator)
            samples = enough(mean, error)
            if samples > render.SAMPLES:
                mean, error = render.mean_and_error(scene, integrator=integrator, samples=samples)
        except Exception as problem:  # One scene that Mitsuba refuses is no reason to leave the others out.
            print(f"{name}: {problem}", flush=True)
            continue
        render.write(out / (name.replace("/", "__") + ".exr"), file, mean, error, samples)
        print(f"{name}: {mean.shape}, mean {mean.mean():.4g}, {samples} samples a pixel and seed", flush=True)


if __name__ == "__main__":
    main()
