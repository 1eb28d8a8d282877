#!/usr/bin/env python3
"""Writes the ground of examples/bunny.json, from formulas alone:

  examples/ground.png         flagstones of a warm grey, worn and mossy in their joints; it tiles
  examples/ground_normal.png  their normals, tangent space, of the same heights

Run it after changing it; the files are kept in the repository.
"""
import math
import os
import random
import struct
import zlib

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples")
SIZE = 256
STONES = 5   # along an edge
DEPTH = 9.0  # of a joint, texels


def png(path, pixels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b""
    before = bytes(3 * SIZE)
    for y in range(SIZE):  # each row as the difference to the one above: smaller
        row = bytes(c for p in pixels[y * SIZE:(y + 1) * SIZE] for c in p)
        rows += b"\2" + bytes((a - b) & 255 for a, b in zip(row, before))
        before = row
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", SIZE, SIZE, 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def noise_of(cells, rng):
    """Value noise of so many cells that tiles."""
    values = [[rng.random() for _ in range(cells)] for _ in range(cells)]

    def at(u, v):
        x, y = u * cells, v * cells
        i, j = int(x), int(y)
        fx, fy = x - i, y - j
        fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
        a, b = values[j % cells], values[(j + 1) % cells]
        low = a[i % cells] + (a[(i + 1) % cells] - a[i % cells]) * fx
        high = b[i % cells] + (b[(i + 1) % cells] - b[i % cells]) * fx
        return low + (high - low) * fy
    return at


def main():
    rng = random.Random(32)
    octaves = [(noise_of(c, rng), a) for c, a in ((4, 0.5), (8, 0.25), (16, 0.13), (32, 0.08), (64, 0.04))]

    def fbm(u, v):
        return sum(a * n(u % 1, v % 1) for n, a in octaves)
    middles = {(i, j): (i + 0.5 + 0.62 * (rng.random() - 0.5), j + 0.5 + 0.62 * (rng.random() - 0.5),
                        0.82 + 0.3 * rng.random(), rng.random()) for i in range(STONES) for j in range(STONES)}
    heights, colors = [], []
    for y in range(SIZE):
        for x in range(SIZE):
            u, v = (x + 0.5) / SIZE, (y + 0.5) / SIZE
            # Stones are the cells of the nearest middle, their borders bent by noise.
            px = u * STONES + 0.5 * (fbm(u, v) - 0.5)
            py = v * STONES + 0.5 * (fbm(u + 0.37, v + 0.71) - 0.5)
            near = []
            for di in (-2, -1, 0, 1, 2):
                for dj in (-2, -1, 0, 1, 2):
                    i, j = math.floor(px) + di, math.floor(py) + dj
                    mx, my, tone, warm = middles[(i % STONES, j % STONES)]
                    cx, cy = mx + (i - i % STONES), my + (j - j % STONES)
                    near.append((math.hypot(px - cx, py - cy), tone, warm))
            near.sort()
            edge = 0.5 * (near[1][0] - near[0][0])  # from the joint, stones
            top = min(edge / 0.09, 1.0)
            top = top * top * (3 - 2 * top)
            grain = fbm(u, v)
            heights.append(DEPTH * top + 5.0 * (grain - 0.5) * (0.3 + 0.7 * top))
            tone, warm = near[0][1], near[0][2]
            stone = [c * tone * (0.72 + 0.56 * grain) for c in (168 + 14 * warm, 158 + 4 * warm, 144 - 8 * warm)]
            moss = [c * (0.6 + 0.8 * fbm(u + 0.5, v + 0.2)) for c in (74, 84, 52)]
            colors.append(tuple(max(0, min(255, round(m + (s - m) * top))) for s, m in zip(stone, moss)))
    normals = []
    for y in range(SIZE):
        for x in range(SIZE):
            at = lambda i, j: heights[(j % SIZE) * SIZE + i % SIZE]
            # Rows go down, v goes up.
            n = (at(x - 1, y) - at(x + 1, y), at(x, y + 1) - at(x, y - 1), 2.0)
            length = math.sqrt(sum(c * c for c in n))
            normals.append(tuple(round(127.5 * (c / length + 1)) for c in n))
    png(os.path.join(HERE, "ground.png"), colors)
    png(os.path.join(HERE, "ground_normal.png"), normals)


if __name__ == "__main__":
    main()
