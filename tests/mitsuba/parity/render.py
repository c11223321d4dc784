"""Renders the parity suite's scenes with Mitsuba: writes NAME.exr beside each NAME.xml.

    pip install mitsuba==3.9.1 numpy==2.4.6
    python tests/mitsuba/parity/render.py [NAME ...]

Variant scalar_rgb. Each file holds the mean of SEEDS independent renders (R, G, B) and its standard error
(stderr.R, ...) from their scatter, summed in double precision: Mitsuba's film sums in single precision, so many
small renders are better than a large one. What made it is in the file's attributes, with the CRC-32 of the scene.
"""
import json
import pathlib
import sys
import zlib
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
FOLDER = pathlib.Path(__file__).parent
SEEDS = 32
SAMPLES = 64
# Scenes with more noise, or with few pixels that are independent, need more to show that images are the same to 1 %.
MORE_SAMPLES = {
    "bsdf-blendbsdf-smooth": 256,
    "bsdf-principledthin-glass": 256,
    "bsdf-roughconductor-beckmann": 256,
    "emitter-area-rectangle": 256,
    "emitter-area-reflecting": 256,
    "emitter-area-textured": 256,
    "emitter-sunsky-wide": 256,
    "filter-lanczos": 128,
    "medium-around-camera": 512,
    "medium-below-open-water": 1024,
    "medium-in-glass": 128,
    "medium-in-nothing": 256,
}


def mean_and_error(scene, sensor=0, samples=SAMPLES, seeds=SEEDS, first=1, **options):
    """The mean over seeds, and its standard error."""
    # Far from each other: Mitsuba seeds the rows of blocks with numbers that follow on the seed.
    renders = (np.array(mi.render(scene, sensor=sensor, spp=samples, seed=1_000_003 * (first + i), **options), dtype=np.float64)[..., :3]
               for i in range(seeds))
    # Welford's sums: no difference of large numbers.
    mean, squares = 0.0, 0.0
    for i, image in enumerate(renders):
        step = image - mean
        mean = mean + step / (i + 1)
        squares = squares + step * (image - mean)
    return mean, np.sqrt(squares / (seeds - 1) / seeds)


def eight_bits(values):
    """Values with 8 bits of mantissa: a standard error is worth no more, and zeros take no space in a file."""
    bits = np.asarray(values, dtype=np.float32).view(np.uint32)
    return ((bits + 0x8000) & 0xFFFF0000).view(np.float32)


def write(path, scene_file, mean, error, samples=SAMPLES, seeds=SEEDS, command="python tests/mitsuba/parity/render.py"):
    channels = np.concatenate([mean.astype(np.float32), eight_bits(error)], axis=2)
    names = ["R", "G", "B", "stderr.R", "stderr.G", "stderr.B"]
    image = mi.Bitmap(np.ascontiguousarray(channels), mi.Bitmap.PixelFormat.MultiChannel, names)
    about = image.metadata()
    about["nephroid:renderer"] = f"Mitsuba {mi.__version__}, {mi.variant()}"
    about["nephroid:command"] = command
    about["nephroid:samples"] = str(samples)
    about["nephroid:seeds"] = f"1000003 * i for i in 1..={seeds}"
    about["nephroid:settings"] = json.dumps({"replicates": seeds})
    about["nephroid:scene-crc32"] = f"{zlib.crc32(pathlib.Path(scene_file).read_bytes()):08x}"
    image.write(str(path))


def main():
    names = sys.argv[1:] or sorted(path.stem for path in FOLDER.glob("*.xml"))
    for name in names:
        file = FOLDER / f"{name}.xml"
        samples = MORE_SAMPLES.get(name, SAMPLES)
        mean, error = mean_and_error(mi.load_file(str(file)), samples=samples)
        write(file.with_suffix(".exr"), file, mean, error, samples)
        print(f"{name}: mean {mean.mean():.4g}, relative error of a pixel {np.sqrt((error**2).mean()) / mean.mean():.2%}", flush=True)


if __name__ == "__main__":
    main()
