#!/usr/bin/env python3
"""Writes what the demo scene is made of, from formulas alone:

  examples/knot.ply   a trefoil tube with normals, as a binary PLY
  examples/demo.json  the scene, with the lantern's voxels as layers of text

Run it after changing it; both files are kept in the repository.
"""
import json
import math
import os
import re
import struct

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples")


def sub(a, b): return tuple(x - y for x, y in zip(a, b))
def add(a, b): return tuple(x + y for x, y in zip(a, b))
def mul(a, s): return tuple(x * s for x in a)
def dot(a, b): return sum(x * y for x, y in zip(a, b))
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
def unit(a): return mul(a, 1 / math.sqrt(dot(a, a)))


def knot(path, segments=320, sides=28, radius=0.3):
    """A (2,3) torus knot swept by a circle; frames by projecting the previous one, so that the tube does not twist."""
    def centre(t):
        r = 1 + 0.42 * math.cos(3 * t)
        return (r * math.cos(2 * t), r * math.sin(2 * t), 0.55 * math.sin(3 * t))
    points = [centre(2 * math.pi * i / segments) for i in range(segments)]
    tangents = [unit(sub(points[(i + 1) % segments], points[i - 1])) for i in range(segments)]
    normal = unit(cross(tangents[0], (0, 0, 1)))
    frames = []
    for t in tangents:
        normal = unit(sub(normal, mul(t, dot(normal, t))))
        frames.append((normal, cross(t, normal)))
    # What is left between the last frame and the first is spread over the whole tube.
    n, b = frames[-1]
    last = unit(sub(n, mul(tangents[0], dot(n, tangents[0]))))
    gap = math.atan2(dot(last, frames[0][1]), dot(last, frames[0][0]))
    vertices = []
    for i, (n, b) in enumerate(frames):
        for j in range(sides):
            a = 2 * math.pi * j / sides - gap * i / segments
            direction = add(mul(n, math.cos(a)), mul(b, math.sin(a)))
            vertices.append(add(points[i], mul(direction, radius)) + direction)
    faces = []
    for i in range(segments):
        for j in range(sides):
            p, q = i * sides + j, i * sides + (j + 1) % sides
            r, s = (i + 1) % segments * sides + j, (i + 1) % segments * sides + (j + 1) % sides
            faces += [(p, q, s), (p, s, r)]
    with open(path, "wb") as f:
        f.write((f"ply\nformat binary_little_endian 1.0\ncomment trefoil tube, tools/make-demo-assets.py\n"
                 f"element vertex {len(vertices)}\n" + "".join(f"property float {k}\n" for k in ("x", "y", "z", "nx", "ny", "nz")) +
                 f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode())
        for v in vertices:
            f.write(struct.pack("<6f", *v))
        for face in faces:
            f.write(struct.pack("<B3i", 3, *face))


def lantern():
    """Layers of a stone lantern: 1 stone, 2 dark roof, 3 clear glass, 4 amber glass, 5 glow, 6 moss."""
    n, c = 15, 7
    def empty(): return [["."] * n for _ in range(n)]
    layers = []
    def square(layer, r, mark):
        for z in range(c - r, c + r + 1):
            for x in range(c - r, c + r + 1):
                layer[z][x] = mark
    for r in (7, 6, 6):  # steps
        layer = empty()
        square(layer, r, "1")
        layers.append(layer)
    for x in range(n):  # moss on the lowest step
        for z in range(n):
            if max(abs(x - c), abs(z - c)) == 7 and (x * 7 + z * 5 + x * z) % 5 < 2:
                layers[0][z][x] = "6"
    height = 11
    for y in range(height):
        layer = empty()
        for z in range(n):
            for x in range(n):
                dx, dz = abs(x - c), abs(z - c)
                ring = max(dx, dz)
                if dx == 5 and dz == 5 or dx == 4 and dz == 5 and y in (0, height - 1) or dx == 5 and dz == 4 and y in (0, height - 1):
                    layer[z][x] = "1"
                elif ring == 5:
                    beam = y in (0, height - 1) or y == 5
                    other = min(dx, dz)
                    layer[z][x] = "1" if beam or other == 0 else ("4" if (y < 5) == ((x + z) % 4 < 2) else "3")
                elif dx <= 1 and dz <= 1 and 2 <= y <= 8:
                    layer[z][x] = "5" if dx + dz < 2 else "."
                elif y == 0 and ring < 5:
                    layer[z][x] = "1"
        layers.append(layer)
    for step, r in enumerate((7, 7, 6, 5, 4, 3, 2, 1, 0, 0)):  # pagoda roof
        layer = empty()
        square(layer, r, "2")
        if step == 1:
            square(layer, 5, ".")
            for z in range(n):
                for x in range(n):
                    if max(abs(x - c), abs(z - c)) < 7:
                        layer[z][x] = "2"
                    elif abs(x - c) + abs(z - c) < 12:
                        layer[z][x] = "."
        if step == 9:
            square(layer, 0, "5")
        layers.append(layer)
    return [["".join(row) for row in layer] for layer in layers]


def scene():
    def v(*x): return list(x)
    # The bunny of 32³ bits fills a cube of edge 3.4 that stands on the ground.
    edge = 3.4
    return {
        "version": 1,
        "camera": {"from": v(0.3, 2.3, 9.6), "at": v(0.05, 1.38, 0.0), "fov": 29, "lens_radius": 0.03, "focus_distance": 8.4},
        "film": {"size": v(1280, 720), "exposure": 0.1, "tone_map": "agx"},
        "integrator": {"type": "path", "spp": 28, "clamp": 6},
        "environment": {"type": "sky", "sun_elevation": 33, "sun_azimuth": -48, "haze": 1, "sun_angular_radius": 1.5},
        "textures": {
            "tiles": {"type": "checker", "color_a": v(0.42, 0.37, 0.31), "color_b": v(0.20, 0.19, 0.19), "scale": v(1.25, 1.25)},
        },
        "materials": {
            "ground": {"type": "diffuse", "color": "tiles", "roughness": 0.3},
            "stone": {"type": "diffuse", "color": v(0.42, 0.40, 0.37), "roughness": 0.5},
            "roof": {"type": "diffuse", "color": v(0.10, 0.13, 0.17)},
            "moss": {"type": "diffuse", "color": v(0.16, 0.25, 0.07)},
            "clear": {"type": "dielectric", "ior": 1.45, "absorption": v(0.6, 0.15, 0.25)},
            "amber": {"type": "dielectric", "ior": 1.45, "absorption": v(0.3, 3.0, 9.0)},
            "glow": {"type": "diffuse", "color": 0.8, "emission": v(26, 13, 4)},
            "copper": {"type": "metal", "preset": "copper", "roughness": 0.3},
            "teal": {"type": "dielectric", "ior": 1.5, "absorption": v(0.9, 0.16, 0.3)},
        },
        "media": {
            "cloud": {"scattering": 8.4, "absorption": 0.09, "g": 0.2, "density": "bunny",
                      "erosion": {"type": "fbm", "strength": 1.35, "frequency": 12, "octaves": 4}},
        },
        "geometries": {
            "bunny": {"type": "volume", "file": "bunny32.bits"},
            "knot": {"type": "mesh", "file": "knot.ply"},
            "lantern": {"type": "voxels", "layers": lantern()},
            "drop": {"type": "sdf", "expression": "smooth_difference(0.1, rounded_box(1.6, 1.6, 1.6, 0.14), sphere(0.93))"},
        },
        "objects": [
            {"name": "ground", "geometry": {"type": "plane"}, "material": "ground"},
            {"name": "bunny", "geometry": "bunny", "material": None, "interior": "cloud",
             "transform": [{"translate": v(-0.5, 0, -0.5)}, {"scale": edge}, {"rotate": {"axis": v(0, 1, 0), "degrees": -35}}, {"translate": v(-0.75, 0.0, 0.1)}]},
            {"name": "lantern", "geometry": "lantern", "material": ["stone", "roof", "clear", "amber", "glow", "moss"],
             "transform": [{"translate": v(-7.5, 0, -7.5)}, {"scale": 0.125}, {"rotate": {"axis": v(0, 1, 0), "degrees": 24}}, {"translate": v(2.75, 0, -0.3)}]},
            {"name": "drop", "geometry": "drop", "material": "teal",
             "transform": [{"scale": 0.68}, {"rotate": {"axis": v(0, 1, 0), "degrees": 30}}, {"translate": v(1.25, 0.545, 2.75)}]},
            {"name": "knot", "geometry": "knot", "material": "copper",
             "transform": [{"scale": 0.52}, {"rotate": {"axis": v(1, 0, 0), "degrees": -72}}, {"rotate": {"axis": v(0, 1, 0), "degrees": 20}}, {"translate": v(-2.5, 0.46, 1.7)}]},
        ],
    }


def written(value):
    text = json.dumps(value, indent=2, ensure_ascii=False)
    while True:  # short lists on one line
        shorter = re.sub(r"\[\s+((?:[^\[\]{}]|\[[^\[\]{}]*\]|\{[^\[\]{}\n]*\})*?)\s+\]",
                         lambda m: (lambda s: s if len(s) < 100 else m.group(0))("[" + re.sub(r"\s*\n\s*", " ", m.group(1)) + "]"), text)
        if shorter == text:
            return text
        text = shorter


if __name__ == "__main__":
    knot(os.path.join(HERE, "knot.ply"))
    with open(os.path.join(HERE, "demo.json"), "w", encoding="utf-8") as f:
        f.write("// Written by tools/make-demo-assets.py: the volumetric Stanford bunny as a cloud, a voxel lantern of stone, glass and\n"
                "// light, an implicit surface of glass and a mesh of copper, on one ground under one sky.\n")
        f.write(written(scene()) + "\n")
