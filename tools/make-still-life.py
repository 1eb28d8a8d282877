#!/usr/bin/env python3
"""Writes examples/still-life.glb: turned vessels whose materials show what glTF has beyond metal and roughness: solid
glass that absorbs, a thin glass wall, clear coats, holes by an alpha mask, a glowing bulb. Usage: make-still-life.py OUT.glb
"""
import json
import math
import struct
import sys
import zlib

AROUND = 44


def smooth(points, steps):
    """A Catmull-Rom curve through (r, y) points."""
    curve = []
    for i in range(len(points) - 1):
        p = [points[max(i - 1, 0)], points[i], points[i + 1], points[min(i + 2, len(points) - 1)]]
        for k in range(steps):
            t = k / steps
            curve.append(tuple(
                0.5 * (2 * p[1][c] + (p[2][c] - p[0][c]) * t + (2 * p[0][c] - 5 * p[1][c] + 4 * p[2][c] - p[3][c]) * t * t +
                       (3 * p[1][c] - p[0][c] - 3 * p[2][c] + p[3][c]) * t ** 3) for c in range(2)))
    curve.append(points[-1])
    return [(max(r, 0.0), y) for r, y in curve]


def turned(profile):
    """Vertices (position, normal, uv) and triangles of a profile turned about y; outside lies to its right."""
    vertices, triangles = [], []
    count = len(profile)
    for i, (r, y) in enumerate(profile):
        before, after = profile[max(i - 1, 0)], profile[min(i + 1, count - 1)]
        dr, dy = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dy) or 1.0
        if r == 0.0:
            dr, dy = (abs(dr) if i == 0 else -abs(dr)), 0.0  # the ends of a closed one are flat
            length = abs(dr) or 1.0
        for k in range(AROUND + 1):
            a = 2 * math.pi * k / AROUND
            n = (dy / length, -dr / length)
            vertices.append((r * math.sin(a), y, r * math.cos(a), n[0] * math.sin(a), n[1], n[0] * math.cos(a),
                             k / AROUND, 1 - i / (count - 1)))
    for i in range(count - 1):
        for k in range(AROUND):
            a = i * (AROUND + 1) + k
            b = a + AROUND + 1
            if profile[i][0] > 0:
                triangles += [a, a + 1, b + 1]
            if profile[i + 1][0] > 0:
                triangles += [a, b + 1, b]
    return vertices, triangles


def sphere(radius, rings):
    return turned([(radius * math.sin(math.pi * i / rings) if 0 < i < rings else 0.0, -radius * math.cos(math.pi * i / rings))
                   for i in range(rings + 1)])


def png(width, height, pixel):
    rows = b"".join(b"\0" + bytes(v for x in range(width) for v in pixel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def lattice(x, y):
    """Two rows of holes a tile, the second shifted by a half."""
    u, v = (x + 0.5) / 64, (y + 0.5) / 64
    near = min(math.hypot((u - cx + 0.5) % 1 - 0.5, (v - cy + 0.5) % 1 - 0.5) for cx, cy in ((0.25, 0.25), (0.75, 0.75)))
    return 226, 150, 92, 0 if near < 0.235 else 255


carafe = smooth([(0.0, 0.0), (0.30, 0.0), (0.50, 0.05), (0.58, 0.35), (0.40, 0.80), (0.17, 1.15), (0.17, 1.45), (0.30, 1.72),
                 (0.285, 1.745), (0.25, 1.72), (0.125, 1.44), (0.125, 1.16), (0.34, 0.78), (0.49, 0.36), (0.40, 0.12),
                 (0.0, 0.09)], 3)
vase = smooth([(0.0, 0.0), (0.26, 0.0), (0.33, 0.03), (0.60, 0.50), (0.52, 0.92), (0.25, 1.18), (0.27, 1.36), (0.36, 1.44),
               (0.33, 1.44), (0.22, 1.34), (0.20, 1.18), (0.30, 1.0), (0.0, 0.95)], 3)
shade = smooth([(0.30, 0.0), (0.52, 0.22), (0.60, 0.55), (0.48, 0.92), (0.20, 1.12)], 4)
foot = smooth([(0.0, 0.0), (0.34, 0.0), (0.36, 0.03), (0.30, 0.06), (0.0, 0.07)], 3)
bowl = smooth([(0.0, 0.0), (0.22, 0.0), (0.26, 0.04), (0.46, 0.20), (0.60, 0.40), (0.58, 0.41), (0.42, 0.23), (0.20, 0.10),
               (0.0, 0.08)], 3)

EXTENSIONS = ["KHR_materials_clearcoat", "KHR_materials_emissive_strength", "KHR_materials_ior",
              "KHR_materials_transmission", "KHR_materials_volume", "KHR_texture_transform"]


def metal_rough(color, metallic, roughness, **more):
    return {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": metallic, "roughnessFactor": roughness,
                                     **more}}


materials = {
    "sea glass": {**metal_rough((1, 1, 1), 0, 0), "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5},
        "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 0.22, "attenuationColor": [0.25, 0.75, 0.62]}}},
    "lacquer": {**metal_rough((0.55, 0.02, 0.03), 0.6, 0.45), "extensions": {
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1}}},
    "pierced copper": {**metal_rough((1, 1, 1), 1, 0.3, baseColorTexture={
        "index": 0, "extensions": {"KHR_texture_transform": {"scale": [9, 4], "rotation": 0}}}),
        "alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": True},
    "bulb": {**metal_rough((0, 0, 0), 0, 1), "emissiveFactor": [1, 0.62, 0.27], "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 14}}},
    "bubble": {**metal_rough((0.93, 0.96, 1.0), 0, 0), "doubleSided": True, "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}}},
    "frosted": {**metal_rough((1.0, 0.72, 0.45), 0, 0.3), "doubleSided": True, "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}}},
    "gold": metal_rough((1.0, 0.76, 0.33), 1, 0.12),
    "glaze": {**metal_rough((0.05, 0.12, 0.38), 0, 0.7), "extensions": {
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.12}}},
}
names = list(materials)
shapes = {"carafe": turned(carafe), "vase": turned(vase), "shade": turned(shade), "foot": turned(foot), "bowl": turned(bowl),
          "ball": sphere(1.0, 20)}
# mesh of a shape in a material, then where it stands: x, y, z, scale
still_life = [
    ("carafe", "sea glass", (-2.05, 0, -0.25, 1.0)), ("shade", "pierced copper", (-0.62, 0.07, -0.75, 1.12)),
    ("foot", "gold", (-0.62, 0, -0.75, 1.0)), ("ball", "bulb", (-0.62, 0.66, -0.75, 0.24)),
    ("vase", "lacquer", (0.95, 0, -0.6, 1.0)), ("ball", "bubble", (2.2, 0.52, -0.15, 0.52)),
    ("ball", "gold", (2.2, 0.2, -0.15, 0.2)), ("bowl", "glaze", (-0.75, 0, 0.75, 0.85)),
    ("ball", "frosted", (0.55, 0.3, 0.75, 0.3)), ("ball", "glaze", (1.3, 0.2, 0.95, 0.2)),
    ("ball", "gold", (-0.86, 0.28, 0.75, 0.17)), ("ball", "lacquer", (-0.58, 0.25, 0.85, 0.13)),
]

binary = bytearray()
views, accessors = [], []


def view(data, target=None):
    while len(binary) % 4:
        binary.append(0)
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), **({"target": target} if target else {})})
    binary.extend(data)
    return len(views) - 1


def accessor(values, kind, component, width):
    code = {5126: "f", 5123: "H"}[component]
    data = struct.pack(f"<{len(values)}{code}", *values)
    entry = {"bufferView": view(data, 34963 if kind == "SCALAR" else 34962), "componentType": component,
             "count": len(values) // width, "type": kind}
    if kind == "VEC3":
        entry["min"] = [min(values[i::3]) for i in range(3)]
        entry["max"] = [max(values[i::3]) for i in range(3)]
    accessors.append(entry)
    return len(accessors) - 1


streams = {}
for name, (vertices, triangles) in shapes.items():
    assert len(vertices) < 65536
    streams[name] = {"attributes": {
        "POSITION": accessor([x for v in vertices for x in v[0:3]], "VEC3", 5126, 3),
        "NORMAL": accessor([x for v in vertices for x in v[3:6]], "VEC3", 5126, 3),
        "TEXCOORD_0": accessor([x for v in vertices for x in v[6:8]], "VEC2", 5126, 2)},
        "indices": accessor(triangles, "SCALAR", 5123, 1)}
meshes, nodes = [], []
for shape, material, (x, y, z, scale) in still_life:
    mesh = {"name": f"{material} {shape}", "primitives": [{**streams[shape], "material": names.index(material)}]}
    if mesh not in meshes:
        meshes.append(mesh)
    nodes.append({"name": mesh["name"], "mesh": meshes.index(mesh), "translation": [x, y, z], "scale": [scale] * 3})
picture = view(png(64, 64, lattice))

document = {
    "asset": {"version": "2.0", "generator": "tools/make-still-life.py"}, "extensionsUsed": EXTENSIONS, "scene": 0,
    "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
    "materials": [{"name": name, **values} for name, values in materials.items()],
    "textures": [{"source": 0}], "images": [{"bufferView": picture, "mimeType": "image/png"}],
    "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
text = json.dumps(document, separators=(",", ":")).encode()
text += b" " * (-len(text) % 4)
binary.extend(b"\0" * (-len(binary) % 4))
with open(sys.argv[1], "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)))
    file.write(struct.pack("<I4s", len(text), b"JSON") + text)
    file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)
