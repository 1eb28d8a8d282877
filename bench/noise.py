#!/usr/bin/env python3
"""Time × variance of a scene, beside Blender's Cycles where that is installed.

    bench/noise.py build/release/bin/spinel bench/scenes/cloud.json [--spp 16] [--seeds 4] [--set KEY=VALUE …]
                   [--blender blender]

Prints processor seconds of one thread for a picture, the mean radiance, the mean over the pixels of the luminance's
variance between pictures of different seeds, and the product: less is better, however many samples a picture has. The
renderers take turns. Needs Python's numpy and OpenImageIO (Debian: python3-numpy, python3-openimageio); Cycles
(Debian: blender) takes scenes of one volume, a directional light and a constant environment only (cycles_volume.py).
"""
import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

import numpy
import OpenImageIO


def luminance(path):
    pixels = OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)[:, :, :3]
    return pixels.astype(numpy.float64) @ numpy.array([0.2126, 0.7152, 0.0722])


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr or done.stdout)
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("spinel")
    parser.add_argument("scene")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--set", action="append", default=[], help="of Spinel's integrator")
    parser.add_argument("--blender", help="the program; none: Spinel alone")
    arguments = parser.parse_args()
    if arguments.seeds < 2:
        parser.error("variance needs two seeds at least")

    def spinel(seed, output):
        command = [arguments.spinel, "render", arguments.scene, "-o", output, "--spp", arguments.spp, "--seed", seed,
                   "-t", 1, "--json"]
        for setting in arguments.set:
            command += ["--set", setting]
        return json.loads(run([str(c) for c in command]))["cpu_seconds"]

    def cycles(seed, output):
        script = pathlib.Path(__file__).with_name("cycles_volume.py")
        text = run([arguments.blender, "-b", "-P", str(script), "--python-exit-code", "1", "--", arguments.scene,
                    str(arguments.spp), str(seed), str(output)])
        return float(re.search(r"cpu_seconds=([\d.]+)", text)[1])

    renderers = {"spinel": spinel}
    if arguments.blender:
        renderers["cycles"] = cycles
    seconds = {name: [] for name in renderers}
    pictures = {name: [] for name in renderers}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, arguments.seeds + 1):
            for name, renderer in renderers.items():
                output = pathlib.Path(folder) / f"{name}.exr"
                seconds[name].append(renderer(seed, output))
                pictures[name].append(luminance(output))
    print(f"{'':8}{'seconds':>10}{'mean':>10}{'variance':>12}{'time × variance':>18}")
    for name in renderers:
        stack = numpy.stack(pictures[name])
        time, variance = statistics.median(seconds[name]), stack.var(0, ddof=1).mean()
        print(f"{name:8}{time:10.2f}{stack.mean():10.4f}{variance:12.4g}{time * variance:18.4g}")


main()
