#!/usr/bin/env python3
"""Checks that every record in device memory has the same layout in C++ and in GLSL.

The kernels' structs are compiled twice. This script reads from a SPIR-V module the size and the member offsets of each
struct that lives in a buffer, turns them into static_asserts on the C++ struct of the same name, and compiles those.
Usage: check-layout.py MODULE.spv HEADER -- COMPILER [FLAG...]   (HEADER is included first: it declares the structs)
"""
import re
import subprocess
import sys


def layouts(assembly):
    """{struct name: (array stride or None, {member name: offset})} for structs with explicit offsets."""
    names = dict(re.findall(r'OpName (%\d+) "([^"]+)"', assembly))
    member_names = {(s, i): n for s, i, n in re.findall(r'OpMemberName (%\d+) (\d+) "([^"]+)"', assembly)}
    strides = dict(re.findall(r"OpDecorate (%\d+) ArrayStride (\d+)", assembly))
    elements = dict(re.findall(r"(%\d+) = OpTypeRuntimeArray (%\d+)", assembly))
    stride_of = {element: int(strides[array]) for array, element in elements.items() if array in strides}
    blocks = set(re.findall(r"OpDecorate (%\d+) Block", assembly))
    found = {}
    for struct, index, offset in re.findall(r"OpMemberDecorate (%\d+) (\d+) Offset (\d+)", assembly):
        if struct in blocks:  # the block around a buffer's array, not a record
            continue
        stride, members = found.setdefault(names[struct], (stride_of.get(struct), {}))
        members[member_names[struct, index]] = int(offset)
    return found


def main():
    split = sys.argv.index("--")
    module, header = sys.argv[1:split]
    compiler = sys.argv[split + 1:]
    assembly = subprocess.run(["spirv-dis", "--raw-id", module], check=True, capture_output=True, text=True).stdout
    found = layouts(assembly)
    if not found:
        print(f"check-layout: no struct with a layout in {module}", file=sys.stderr)
        return 1
    lines = [f'#include "{header}"', "#include <cstddef>", "using namespace spinel::kernels;"]
    for name, (stride, members) in sorted(found.items()):
        if stride is not None:
            lines.append(f'static_assert(sizeof({name}) == {stride}, "size of {name}");')
        for member, offset in members.items():
            lines.append(f'static_assert(offsetof({name}, {member}) == {offset}, "offset of {name}::{member}");')
    result = subprocess.run(compiler + ["-fsyntax-only", "-x", "c++", "-"], input="\n".join(lines) + "\n", text=True)
    print(f"check-layout: {len(found)} structs, {len(lines) - 3} assertions, {'failed' if result.returncode else 'ok'}")
    return result.returncode


if __name__ == "__main__":
    sys.exit(main())
