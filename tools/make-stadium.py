#!/usr/bin/env python3
"""The teapot in the stadium: a small mesh of many triangles on the field of a large one of few, as one PLY.

    tools/make-stadium.py teapot.obj stadium.ply

A uniform grid has to choose for which of the two its cells are right; `spinel bench stadium.ply` tells what it costs."""
import math
import sys


def read_obj(path):
    vertices, faces = [], []
    for line in open(path):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append([float(x) for x in words[1:4]])
        elif words[0] == "f":
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            faces += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return vertices, faces


def main():
    vertices, faces = read_obj(sys.argv[1])
    low = [min(v[i] for v in vertices) for i in range(3)]
    size = max(max(v[i] for v in vertices) - low[i] for i in range(3))
    vertices = [[(v[i] - low[i]) / size for i in range(3)] for v in vertices]  # one unit large
    segments, rows = 96, 30
    profile = [(0.0, 0.0), (50.0, 0.0)]
    for row in range(rows):
        profile += [(50.0 + row, row + 1.0), (51.0 + row, row + 1.0)]
    first = len(vertices)
    for radius, height in profile:
        for s in range(segments):
            angle = 2 * math.pi * s / segments
            vertices.append([1.4 * radius * math.cos(angle), height, radius * math.sin(angle)])
    for ring in range(len(profile) - 1):
        for s in range(segments):
            a, b = first + ring * segments + s, first + ring * segments + (s + 1) % segments
            c, d = a + segments, b + segments
            faces += [(a, c, d), (a, d, b)]
    with open(sys.argv[2], "w") as out:
        out.write(f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
                  f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        out.writelines("%.7g %.7g %.7g\n" % tuple(v) for v in vertices)
        out.writelines("3 %d %d %d\n" % f for f in faces)


main()
