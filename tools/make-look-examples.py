#!/usr/bin/env python3
"""Writes the example scenes that show how voxels may look, from formulas alone:

  examples/blocks.png   an atlas of block textures, 4×4 tiles of 16×16 pixels
  examples/blocks.json  a hut and a tree of textured blocks, leaves with holes, lanterns
  examples/rounded.json a toy castle of rounded bricks
  examples/outlines.json  the same castle with lines along its edges
  examples/waves.json   a harbour basin with waves
  examples/shafts.json  light shafts in the fog of a nave
  examples/polished.json  metals that see each other
  examples/neon.json    a street lit by emissive voxels alone
  examples/gyroid.json  a world of voxels that are not stored

Run it after changing it; the files are kept in the repository.
"""
import json
import math
import os
import random
import re
import struct
import zlib

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples")


# ------------------------------------------------------------------------------------------------------------ the atlas
def png(path, width, height, pixels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixels[y][x]) for y in range(height))
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 6, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def shade(color, factor):
    return tuple(max(0, min(255, round(c * factor))) for c in color[:3]) + (255,)


def atlas(path):
    rng = random.Random(7)
    GRASS, DIRT, STONE, WOOD, BARK, BRICK = (96, 150, 58), (124, 88, 58), (136, 134, 130), (178, 136, 84), (92, 68, 44), (158, 78, 60)
    noise = [[rng.random() for _ in range(16)] for _ in range(16)]

    def speckled(color, low, high):
        return lambda x, y: shade(color, low + (high - low) * rng.random())

    def turf(x, y):
        edge = 3 + round(2.2 * noise[0][x])
        return shade(GRASS, 0.8 + 0.4 * rng.random()) if y < edge else shade(DIRT, 0.75 + 0.4 * rng.random())

    def bricks(color, mortar, width, height):
        def f(x, y):
            row = y // height
            if y % height == height - 1 or (x + (row % 2) * width // 2) % width == width - 1:
                return shade(mortar, 0.9 + 0.2 * rng.random())
            cell = noise[row % 16][((x + (row % 2) * width // 2) // width) % 16]
            return shade(color, 0.78 + 0.3 * cell + 0.12 * rng.random())
        return f

    def planks(x, y):
        if y % 4 == 3 or (x == (3 + 5 * (y // 4)) % 16):
            return shade(WOOD, 0.55)
        return shade(WOOD, 0.85 + 0.2 * noise[y // 4][x // 5] + 0.1 * rng.random())

    def bark(x, y):
        return shade(BARK, 0.6 + 0.7 * noise[3][x] + 0.15 * rng.random())

    def rings(x, y):
        r = math.hypot(x - 7.5, y - 7.5)
        return shade(BARK, 0.9) if r > 7.4 else shade(WOOD, 0.95 if int(r * 1.1) % 2 else 0.72)

    def leaves(x, y):
        v = noise[y][x] * 0.6 + noise[(y + 5) % 16][(x + 3) % 16] * 0.4
        return (0, 0, 0, 0) if v < 0.34 else shade((64, 118, 44), 0.55 + 0.9 * v)

    def lantern(x, y):
        if x in (0, 15) or y in (0, 15) or x in (7, 8) or y in (7, 8):
            return (30, 26, 22, 255)
        return shade((255, 206, 120), 0.85 + 0.15 * noise[y][x])

    def lantern_glow(x, y):
        c = lantern(x, y)
        return (0, 0, 0, 255) if c[0] < 60 else c

    def window(x, y):
        return shade(WOOD, 0.6) if x in (0, 7, 8, 15) or y in (0, 7, 8, 15) else (0, 0, 0, 0)

    def shingles(x, y):
        row = y // 4
        if y % 4 == 3:
            return shade((110, 56, 44), 0.6)
        return shade((142, 70, 52), 0.75 + 0.35 * noise[row][((x + 2 * (row % 2)) // 4) % 16] + 0.1 * rng.random())

    def gravel(x, y):
        return shade((150, 142, 128), 0.7 + 0.5 * noise[y // 2][x // 2] + 0.1 * rng.random())

    tiles = [speckled(GRASS, 0.78, 1.2), turf, speckled(DIRT, 0.75, 1.15), bricks(STONE, (96, 94, 92), 8, 4),
             planks, bark, rings, leaves, lantern, lantern_glow, window, shingles, gravel, bricks(BRICK, (190, 180, 168), 8, 4),
             speckled(STONE, 0.8, 1.1), speckled((230, 226, 216), 0.92, 1.05)]
    pixels = [[(0, 0, 0, 0)] * 64 for _ in range(64)]
    for i, tile in enumerate(tiles):
        for y in range(16):
            for x in range(16):
                pixels[i // 4 * 16 + y][i % 4 * 16 + x] = tile(x, y)
    png(path, 64, 64, pixels)


# ------------------------------------------------------------------------------------------------------------- voxels
class Set:
    """A set of voxels by palette index; layers of text as scene files have them."""
    CHARACTERS = ".123456789abcdefghijklmnopqrstuvwxyz"

    def __init__(self, x, y, z):
        self.size = (x, y, z)
        self.cells = {}

    def put(self, x, y, z, palette):
        if 0 <= x < self.size[0] and 0 <= y < self.size[1] and 0 <= z < self.size[2]:
            self.cells[x, y, z] = palette

    def box(self, lower, upper, palette):
        for x in range(lower[0], upper[0]):
            for y in range(lower[1], upper[1]):
                for z in range(lower[2], upper[2]):
                    self.put(x, y, z, palette)

    def layers(self):
        x, y, z = self.size
        return [["".join(self.CHARACTERS[self.cells.get((i, j, k), 0)] for i in range(x)) for k in range(z)] for j in range(y)]


def write(name, comment, scene):
    text = json.dumps(scene, indent=1)
    # Short lists on one line.
    text = re.sub(r"\[\s+((?:-?[\d.e-]+,\s+)*-?[\d.e-]+)\s+\]", lambda m: "[" + re.sub(r"\s+", " ", m.group(1)) + "]", text)
    with open(os.path.join(HERE, name), "w", encoding="utf-8") as f:
        f.write("// " + comment + "\n" + text + "\n")


def camera(origin, at, fov, **more):
    return dict({"from": list(origin), "at": list(at), "fov": fov}, **more)


# -------------------------------------------------------------------------------------------------------------- scenes
def blocks():
    s = Set(26, 17, 22)
    rng = random.Random(3)
    GRASS, DIRT, BRICKS, PLANKS, LOG, LEAVES, LANTERN, WINDOW, ROOF, GRAVEL, BASE, WHITE = range(1, 13)
    height = lambda x, z: 2 + (1 if x + z > 36 else 0) + (1 if x + 2 * z < 8 else 0)
    for x in range(26):
        for z in range(22):
            h = height(x, z)
            s.box((x, 0, z), (x + 1, h, z + 1), DIRT)
            s.put(x, h, z, GRASS)
    # The hut, on a base of stone.
    s.box((6, 2, 5), (15, 3, 13), BASE)
    for y in range(3, 7):
        s.box((6, y, 5), (15, y + 1, 13), PLANKS if y > 3 else BRICKS)
        s.box((7, y, 6), (14, y + 1, 12), 0)
    for x, z in ((6, 5), (14, 5), (6, 12), (14, 12)):
        s.box((x, 3, z), (x + 1, 7, z + 1), LOG)
    for x in (8, 12):
        s.box((x, 4, 12), (x + 1, 6, 13), WINDOW)
    for z in (7, 8, 10):
        s.box((14, 4, z), (15, 6, z + 1), WINDOW)
    s.box((10, 3, 12), (11, 5, 13), 0)
    s.box((7, 2, 6), (14, 3, 12), PLANKS)
    for i in range(6):  # gables along x
        s.box((5, 7 + i, 4 + i), (16, 8 + i, 5 + i), ROOF)
        s.box((5, 7 + i, 13 - i), (16, 8 + i, 14 - i), ROOF)
        s.box((6, 7 + i, 5 + i), (7, 8 + i, 13 - i), WHITE)
        s.box((14, 7 + i, 5 + i), (15, 8 + i, 13 - i), WHITE)
    s.box((8, 8, 6), (10, 14, 8), BRICKS)  # chimney
    for z in range(13, 22):
        s.put(10, height(10, z), z, GRAVEL)
        s.put(11 if z > 16 else 10, height(11, z), z, GRAVEL)
    s.put(10, 6, 9, LANTERN)
    for x, z in ((8, 15), (13, 18)):
        h = height(x, z) + 1
        s.box((x, h, z), (x + 1, h + 2, z + 1), LOG)
        s.put(x, h + 2, z, LANTERN)
    # The tree.
    tx, tz = 20, 11
    s.box((tx, 3, tz), (tx + 1, 10, tz + 1), LOG)
    for x in range(26):
        for z in range(22):
            for y in range(7, 16):
                r = math.sqrt((x - tx) ** 2 + 1.3 * (y - 10.5) ** 2 + (z - tz) ** 2)
                if r < 4.3 - 1.1 * rng.random() and (x, y, z) not in s.cells:
                    s.put(x, y, z, LEAVES)
    for _ in range(9):  # bushes
        x, z = rng.randrange(26), rng.randrange(22)
        if (x, height(x, z) + 1, z) not in s.cells and not (4 < x < 17 and 3 < z < 20):
            s.put(x, height(x, z) + 1, z, LEAVES)
    tile = lambda **parts: dict({"type": "faces", "file": "blocks.png", "grid": [4, 4]}, **parts)
    diffuse = lambda texture: {"type": "diffuse", "color": texture}
    scene = {
        "version": 1,
        "camera": camera((31, 16.5, 40), (13.4, 6.6, 9.6), 29),
        "film": {"size": [960, 540], "exposure": 0.4},
        "integrator": {"spp": 256},
        "environment": {"type": "sky", "sun_elevation": 30, "sun_azimuth": -35, "haze": 1.4},
        "textures": {
            "turf": tile(top=0, sides=1, bottom=2), "dirt": tile(all=2), "bricks": tile(all=3), "planks": tile(all=4),
            "log": tile(top=6, bottom=6, sides=5), "leaves": tile(all=7), "lantern": tile(all=8), "glow": tile(all=9),
            "window": tile(sides=10, top=4, bottom=4), "roof": tile(all=11), "gravel": tile(all=12), "base": tile(all=14),
            "plaster": tile(all=15)},
        "materials": {
            "turf": diffuse("turf"), "dirt": diffuse("dirt"), "bricks": diffuse("bricks"), "planks": diffuse("planks"),
            "log": diffuse("log"), "leaves": {"type": "diffuse", "color": "leaves", "opacity": "leaves"},
            "lantern": {"type": "diffuse", "color": "lantern", "emission": {"texture": "glow", "factor": [11, 7.5, 3.6]}},
            "window": {"type": "diffuse", "color": "window", "opacity": "window"}, "roof": diffuse("roof"),
            "gravel": diffuse("gravel"), "base": diffuse("base"), "plaster": diffuse("plaster")},
        "geometries": {"hut": {"type": "voxels", "layers": s.layers()}},
        "objects": [{"geometry": "hut", "material": ["turf", "dirt", "bricks", "planks", "log", "leaves", "lantern", "window",
                                                     "roof", "gravel", "base", "plaster"]}]}
    write("blocks.json", "Blocks with textures of their own on top, bottom and sides, out of one atlas; leaves and windows have\n"
          "// holes by its alpha, and the lanterns shine through theirs. Written by tools/make-look-examples.py.", scene)


def castle():
    s = Set(21, 19, 21)
    RED, BLUE, YELLOW, GREEN, WHITE = range(1, 6)
    s.box((0, 0, 0), (21, 1, 21), GREEN)
    for x, z in ((2, 2), (15, 2), (2, 15), (15, 15)):
        s.box((x, 1, z), (x + 4, 9, z + 4), WHITE)
        s.box((x + 1, 1, z + 1), (x + 3, 9, z + 3), 0)
        for i in range(4):
            for j in range(4):
                if (i in (0, 3) or j in (0, 3)) and (i + j) % 2 == 0:
                    s.put(x + i, 9, z + j, WHITE)
        s.box((x, 6, z), (x + 4, 7, z + 4), RED)
        s.box((x + 1, 6, z + 1), (x + 3, 7, z + 3), 0)
    for k in (3, 17):
        s.box((6, 1, k), (15, 6, k + 1), YELLOW)
        s.box((k, 1, 6), (k + 1, 6, 15), YELLOW)
        for i in range(6, 15, 2):
            s.put(i, 6, k, YELLOW)
            s.put(k, 6, i, YELLOW)
    s.box((9, 1, 17), (12, 4, 18), 0)
    s.put(9, 4, 17, BLUE), s.put(10, 4, 17, BLUE), s.put(11, 4, 17, BLUE)
    s.box((8, 1, 8), (13, 11, 13), BLUE)
    for i in range(3):
        s.box((8 + i, 11 + i, 8 + i), (13 - i, 12 + i, 13 - i), RED)
    s.box((10, 14, 10), (11, 17, 11), WHITE)
    s.put(11, 16, 10, YELLOW), s.put(12, 16, 10, YELLOW)
    for y in (4, 8):
        for k in (9, 11):
            s.put(k, y, 12, WHITE), s.put(12, y, k, WHITE)
    return s


def castle_scene(looks, paint, environment, film):
    colors = {"red": [0.62, 0.05, 0.03], "blue": [0.03, 0.16, 0.48], "yellow": [0.80, 0.46, 0.03], "green": [0.09, 0.34, 0.08],
              "white": [0.78, 0.76, 0.71]}
    materials = {name: dict(paint, color=color) for name, color in colors.items()}
    materials["table"] = {"type": "diffuse", "color": [0.55, 0.50, 0.44]}
    return {
        "version": 1,
        "camera": camera((35, 24, 44), (10.3, 7.2, 10.5), 28),
        "film": dict({"size": [960, 540]}, **film),
        "integrator": {"spp": 256},
        "environment": environment,
        "materials": materials,
        "geometries": {"castle": dict({"type": "voxels", "layers": castle().layers()}, **looks)},
        "objects": [{"geometry": "castle", "material": ["red", "blue", "yellow", "green", "white"]},
                    {"geometry": {"type": "plane"}, "material": "table"}]}


def rounded():
    scene = castle_scene({"rounding": [0.3, 0.3, 0.3, 0.12, 0.3]}, {"type": "plastic", "roughness": 0.22},
                         {"type": "sky", "sun_elevation": 38, "sun_azimuth": 70, "haze": 2}, {"exposure": 0.1})
    scene["camera"] = camera((29, 15, 36), (10.6, 4.8, 12.5), 19)
    write("rounded.json", "A toy castle whose voxels have rounded edges: wherever air lies across both faces of an edge; equal\n"
          "// neighbours join smoothly. Written by tools/make-look-examples.py.", scene)


def outlines():
    scene = castle_scene({"outlines": {"where": "changes", "width": 0.14, "color": [0.02, 0.02, 0.03], "strength": 0.9}},
                         {"type": "diffuse"}, {"type": "constant", "radiance": [0.95, 1.0, 1.1]}, {"exposure": -0.1})
    scene["lights"] = [{"type": "directional", "direction": [-1, -1.5, -0.55], "irradiance": 1.6, "angular_radius": 2}]
    write("outlines.json", "The toy castle, drawn: lines where the visible shape or the colour changes.\n"
          "// Written by tools/make-look-examples.py.", scene)


def waves():
    s = Set(40, 12, 34)
    SAND, STONE, WATER, WOOD, RED, WHITE, LAMP = range(1, 8)
    for x in range(40):
        for z in range(34):
            depth = max(0, min(5, int(1.2 + 0.20 * (z - 4) + 1.1 * math.sin(0.25 * x))))
            bed = 5 - depth
            s.box((x, 0, z), (x + 1, bed + 1, z + 1), SAND)
            s.box((x, bed + 1, z), (x + 1, 6, z + 1), WATER)
    s.box((0, 0, 0), (6, 8, 34), STONE)
    for z in range(0, 34, 5):
        s.box((5, 0, z), (7, 9, z + 1), STONE)
    s.box((0, 0, 0), (40, 7, 4), STONE)
    s.box((6, 7, 10), (20, 8, 13), WOOD)  # the pier
    for x in (9, 14, 19):
        s.box((x, 0, 10), (x + 1, 8, 11), WOOD), s.box((x, 0, 12), (x + 1, 8, 13), WOOD)
    s.box((2, 8, 17), (4, 9, 19), STONE)
    for i in range(3):  # a buoy
        s.box((27, 5 + i, 17), (30, 6 + i, 20), RED if i != 1 else WHITE)
    s.put(28, 8, 18, WHITE), s.put(28, 9, 18, LAMP)
    s.box((19, 8, 11), (20, 10, 12), WOOD), s.put(19, 10, 11, LAMP)
    scene = {
        "version": 1,
        "camera": camera((42, 20, 42), (18.5, 5.2, 14.5), 30),
        "film": {"size": [960, 540], "exposure": 1.1},
        "integrator": {"spp": 384, "clamp": 3},
        "environment": {"type": "sky", "sun_elevation": 36, "sun_azimuth": 305, "haze": 1.5, "sun_angular_radius": 1},
        "materials": {
            "sand": {"type": "diffuse", "color": [0.62, 0.50, 0.32]}, "stone": {"type": "diffuse", "color": [0.34, 0.33, 0.32]},
            "water": {"type": "dielectric", "ior": 1.333, "absorption": [0.20, 0.03, 0.02]},
            "wood": {"type": "diffuse", "color": [0.34, 0.19, 0.09]}, "red": {"type": "plastic", "color": [0.6, 0.04, 0.02]},
            "white": {"type": "plastic", "color": 0.75}, "lamp": {"type": "diffuse", "color": 0.5, "emission": [5, 3, 1.1]}},
        "geometries": {"harbour": {"type": "voxels", "waves": {"palette": [WATER], "height": 0.55, "length": 8, "count": 10,
                                                               "direction": 110, "spread": 60},
                                   "layers": s.layers()}},
        "objects": [{"geometry": "harbour", "material": ["sand", "stone", "water", "wood", "red", "white", "lamp"]}]}
    write("waves.json", "A harbour in voxels: the water's top is a true surface of waves that reflects, refracts and absorbs.\n"
          "// Written by tools/make-look-examples.py.", scene)


def shafts():
    s = Set(26, 27, 44)
    STONE, FLOOR, RED, GLASS = range(1, 5)
    s.box((0, 0, 0), (26, 27, 44), STONE)
    s.box((1, 1, 1), (25, 26, 43), 0)
    for x in range(26):  # a pointed vault
        for y in range(15, 27):
            if abs(x - 12.5) > 12.5 * math.sqrt(max(0.0, 1 - ((y - 15) / 10.5) ** 2)):
                s.box((x, y, 0), (x + 1, y + 1, 44), STONE)
    for x in range(26):
        for z in range(44):
            s.put(x, 0, z, FLOOR if (x // 2 + z // 2) % 2 else STONE)
    for z in range(4, 44, 8):
        for x in (6, 18):
            s.box((x, 1, z), (x + 2, 17, z + 2), STONE)
            s.box((x - 1, 1, z - 1), (x + 3, 2, z + 3), STONE), s.box((x - 1, 15, z - 1), (x + 3, 17, z + 3), STONE)
        s.box((6, 17, z), (20, 18, z + 2), 0)
        s.box((25, 7, z + 4), (26, 15, z + 6), 0)  # tall windows between the pillars
    s.box((11, 1, 1), (15, 2, 43), RED)
    s.box((10, 1, 2), (16, 3, 5), FLOOR), s.box((12, 3, 3), (14, 4, 4), RED)
    s.box((10, 8, 0), (16, 20, 1), 0)
    s.box((12, 8, 0), (13, 20, 1), STONE), s.box((10, 13, 0), (16, 14, 1), STONE)
    scene = {
        "version": 1,
        "camera": camera((9.6, 4.2, 42), (13.6, 8.2, 14), 56),
        "film": {"size": [960, 540], "exposure": 1.2},
        "integrator": {"type": "single-scatter", "spp": 16},
        "environment": {"type": "constant", "radiance": [0.025, 0.033, 0.05]},
        "lights": [{"type": "directional", "direction": [-1, -0.85, -0.25], "irradiance": [60, 50, 36], "angular_radius": 0.265}],
        "media": {"haze": {"scattering": 0.014, "absorption": 0.001, "g": 0.35}},
        "materials": {"stone": {"type": "diffuse", "color": [0.48, 0.43, 0.37]}, "tile": {"type": "diffuse", "color": [0.25, 0.23, 0.22]},
                      "carpet": {"type": "diffuse", "color": [0.30, 0.05, 0.04]}},
        "geometries": {"nave": {"type": "voxels", "layers": s.layers()}},
        "objects": [{"geometry": "nave", "material": ["stone", "tile", "carpet"]},
                    {"name": "fog", "geometry": {"type": "box", "size": [24, 25, 42]}, "material": None, "interior": "haze",
                     "transform": [{"translate": [13, 13.5, 22]}]}]}
    write("shafts.json", "Sun through the windows of a nave of voxels that is full of haze. Written by tools/make-look-examples.py.", scene)


def polished():
    s = Set(25, 14, 25)
    GOLD, COPPER, STEEL, BLACK, RED, LAMP = range(1, 7)
    for x in range(25):
        for z in range(25):
            s.put(x, 0, z, BLACK if (x // 3 + z // 3) % 2 else STEEL)
    def ball(cx, cy, cz, r, palette):
        for x in range(25):
            for y in range(1, 14):
                for z in range(25):
                    if (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2 < r * r:
                        s.put(x, y, z, palette)
    ball(8, 5, 9, 4.6, GOLD), ball(17, 4, 13, 3.6, COPPER), ball(9, 3, 18, 2.6, STEEL), ball(17, 2.5, 20, 1.9, RED)
    s.box((3, 1, 2), (5, 14, 4), STEEL), s.box((20, 1, 3), (22, 12, 5), RED)
    s.box((11, 1, 2), (16, 9, 3), COPPER)
    scene = {
        "version": 1,
        "camera": camera((31, 16, 42), (12.2, 4.0, 11.0), 25),
        "film": {"size": [960, 540], "exposure": 0.2},
        "integrator": {"spp": 2048, "clamp": 3},
        "environment": {"type": "constant", "radiance": [0.10, 0.12, 0.16]},
        "materials": {
            "gold": {"type": "metal", "preset": "gold", "roughness": 0.22}, "copper": {"type": "metal", "preset": "copper", "roughness": 0.32},
            "steel": {"type": "metal", "color": [0.62, 0.63, 0.65], "roughness": 0.28}, "black": {"type": "plastic", "color": 0.02, "roughness": 0.12},
            "red": {"type": "plastic", "color": [0.55, 0.03, 0.02], "roughness": 0.18},
            "lamp": {"type": "diffuse", "color": 0, "emission": [9, 8.2, 7]}, "rim": {"type": "diffuse", "color": 0, "emission": [2.5, 4, 8]}},
        "geometries": {"room": {"type": "voxels", "rounding": [0.16, 0.16, 0.06, 0.06, 0.16], "layers": s.layers()}},
        "objects": [{"geometry": "room", "material": ["gold", "copper", "steel", "black", "red"]},
                    {"geometry": {"type": "rectangle", "size": [16, 10]}, "material": "lamp",
                     "transform": [{"rotate": {"axis": [0, 0, 1], "degrees": 145}}, {"translate": [-8, 22, 20]}]},
                    {"geometry": {"type": "rectangle", "size": [4, 20]}, "material": "rim",
                     "transform": [{"rotate": {"axis": [0, 0, 1], "degrees": 100}}, {"translate": [36, 10, 6]}]}]}
    write("polished.json", "Rough metals and plastics in voxels that see each other, bounce after bounce.\n"
          "// Written by tools/make-look-examples.py.", scene)


def neon():
    s = Set(42, 26, 40)
    rng = random.Random(11)
    ROAD, WALL, DARK, PINK, CYAN, AMBER, WHITE, PUDDLE = range(1, 9)
    s.box((0, 0, 0), (42, 1, 40), ROAD)
    for x in range(15, 27):
        for z in range(40):
            if math.sin(0.9 * x + 1.7 * math.sin(0.35 * z)) + math.sin(0.6 * z) > 0.75:
                s.put(x, 0, z, PUDDLE)
    for side in (0, 1):
        z = 0
        while z < 40:
            depth, height, setback = rng.choice((6, 7, 9)), rng.randrange(11, 25), rng.randrange(0, 3)
            front = 13 - setback if side == 0 else 28 + setback
            lower, upper = (0, front) if side == 0 else (front, 42)
            s.box((lower, 1, z), (upper, height, min(40, z + depth)), WALL if rng.random() < 0.6 else DARK)
            face = front - 1 if side == 0 else front
            sign = face + (1 if side == 0 else -1)
            for y in range(4, height - 1, 3):
                for k in range(z + 1, min(40, z + depth - 1), 2):
                    if rng.random() < 0.35:
                        s.put(face, y, k, AMBER if rng.random() < 0.75 else WHITE)
                    else:
                        s.put(face, y, k, 0)
            color = rng.choice((PINK, CYAN, PINK, CYAN, AMBER))
            if z + 3 < 40:
                s.box((sign, 4, z + 2), (sign + 1, min(height - 2, 4 + rng.randrange(3, 9)), z + 3), color)
            if rng.random() < 0.7 and z + depth - 1 < 40:
                s.box((min(face, sign), 3, z + 1), (max(face, sign) + 1, 4, z + depth - 1), rng.choice((PINK, CYAN)))
            z += depth
    s.box((19, 1, 12), (23, 2, 18), DARK), s.box((19, 2, 13), (23, 3, 17), DARK)  # a car
    s.put(19, 1, 18, WHITE), s.put(22, 1, 18, WHITE)
    s.put(19, 1, 11, PINK), s.put(22, 1, 11, PINK)
    glow = lambda color: {"type": "diffuse", "color": 0.3, "emission": color}
    scene = {
        "version": 1,
        "camera": camera((20.6, 5.2, 52), (20.8, 7.4, 8), 40),
        "film": {"size": [960, 540], "exposure": 0.7},
        "integrator": {"spp": 512, "clamp": 6},
        "environment": {"type": "constant", "radiance": [0.004, 0.006, 0.016]},
        "materials": {
            "road": {"type": "plastic", "color": [0.05, 0.05, 0.06], "roughness": 0.5}, "wall": {"type": "diffuse", "color": [0.30, 0.27, 0.27]},
            "dark": {"type": "plastic", "color": [0.10, 0.11, 0.14], "roughness": 0.35}, "pink": glow([9, 0.7, 4.2]), "cyan": glow([0.5, 4.6, 7]),
            "amber": glow([3.4, 1.5, 0.35]), "white": glow([5, 5, 4.6]), "puddle": {"type": "plastic", "color": 0.012, "roughness": 0.06}},
        "geometries": {"street": {"type": "voxels", "layers": s.layers()}},
        "objects": [{"geometry": "street", "material": ["road", "wall", "dark", "pink", "cyan", "amber", "white", "puddle"]}]}
    write("neon.json", "A street by night: every glowing voxel face is a light that is sampled as such.\n"
          "// Written by tools/make-look-examples.py.", scene)


def gyroid():
    scene = {
        "version": 1,
        "camera": camera((-60, 64, 250), (130, 2, -60), 38),
        "film": {"size": [960, 540], "exposure": 0.2},
        "integrator": {"spp": 192},
        "environment": {"type": "sky", "sun_elevation": 24, "sun_azimuth": 120, "haze": 2.5},
        "materials": {
            "rock": {"type": "diffuse", "color": [0.30, 0.26, 0.24]}, "clay": {"type": "diffuse", "color": [0.50, 0.27, 0.15]},
            "sand": {"type": "diffuse", "color": [0.62, 0.47, 0.28]}, "moss": {"type": "diffuse", "color": [0.20, 0.33, 0.09]},
            "snow": {"type": "diffuse", "color": 0.8}, "sea": {"type": "plastic", "color": [0.02, 0.09, 0.11], "roughness": 0.08}},
        "geometries": {"world": {
            "type": "sdf_voxels",
            "expression": "smooth_intersection(14, gyroid(96, 13), displace(9, 0.045, plane(0, 1, 0, 22)))",
            "bounds": [[-4000, -40, -8000], [4000, 44, 230]], "strata": [-14, -4, 4, 20]}},
        "objects": [{"geometry": "world", "material": ["rock", "clay", "sand", "moss", "snow"]},
                    {"geometry": {"type": "plane"}, "material": "sea", "transform": [{"translate": [0, -22.5, 0]}]}]}
    write("gyroid.json", "A world of five billion cells that are not stored: they are solid where an expression says so.\n"
          "// Written by tools/make-look-examples.py.", scene)


atlas(os.path.join(HERE, "blocks.png"))
for make in (blocks, rounded, outlines, waves, shafts, polished, neon, gyroid):
    make()
