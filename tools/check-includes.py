#!/usr/bin/env python3
"""Checks that includes only point to the same or an earlier room, and that a source includes its own header first.

The rooms, in order, are the folders of src/; include/spinel/ counts as scene, but for scene.h, dvr.h, grid.h and voxels.h: they are the plain
data that a user wrote down, the builders of geometry read their records, and so they stand, with what they may include,
at image.
kernels is stricter: it is the physics in the common subset of C++ and GLSL and includes nothing but itself. Tests, benchmarks and examples may include anything.
Usage: tools/check-includes.py [ROOT]; prints file:line for every violation and exits 1 if there is one.
"""
import pathlib
import re
import sys

ROOMS = ["core", "kernels", "image", "accel", "geometry", "scene", "formats", "render", "devices", "cli"]
SOURCES = {".h", ".cpp", ".comp", ".glsl"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def room_of(root, path):
    """The room of a file below src/ or include/spinel/; None for a file that is in no room."""
    if path.is_relative_to(root / "include"):
        return "image" if path.name in ("scene.h", "dvr.h", "grid.h", "voxels.h") else "scene"
    parts = path.relative_to(root / "src").parts
    return parts[0] if len(parts) > 1 and parts[0] in ROOMS else None


def resolve(root, path, name):
    """The included file, by the compiler's order: beside the includer, then src/, then include/."""
    for folder in (path.parent, root / "src", root / "include"):
        candidate = (folder / name).resolve()
        if candidate.is_file():
            return candidate
    return None


def check_file(root, path):
    """Yields (line, message) for every violation in one file."""
    room = room_of(root, path)
    if room is None:
        yield 1, f"is in no room; the rooms are {', '.join(ROOMS)}"
        return
    own_header = path.with_suffix(".h")
    first = True
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        name = match[2]
        target = resolve(root, path, name)
        if first and path.suffix == ".cpp" and own_header.is_file() and target != own_header:
            yield number, f"the first include of {path.name} is its own header, {own_header.name}, not {name}"
        first = False
        if target is None and match[1] == "<":
            continue  # the standard library or a dependency
        if target is None:
            yield number, f"cannot find {name} beside this file, in src/ or in include/"
            continue
        if not (target.is_relative_to(root / "src") or target.is_relative_to(root / "include")):
            yield number, f"{name} lies outside src/ and include/"
            continue
        other = room_of(root, target)
        if room == "kernels" and other != "kernels":
            yield number, f"kernels may include only kernels, not {name}"
        elif other is not None and ROOMS.index(other) > ROOMS.index(room):
            yield number, f"{room} may not include the later room {other} ({name})"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent).resolve()
    files = sorted(p for folder in ("src", "include") for p in (root / folder).rglob("*") if p.suffix in SOURCES)
    if not files:
        print(f"check-includes: no sources below {root}/src", file=sys.stderr)
        return 1
    failures = 0
    for path in files:
        for line, message in check_file(root, path):
            print(f"{path.relative_to(root)}:{line}: {message}", file=sys.stderr)
            failures += 1
    print(f"check-includes: {len(files)} files, {failures} violations")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
