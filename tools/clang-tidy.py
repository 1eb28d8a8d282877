#!/usr/bin/env python3
"""Runs clang-tidy on every source of src/ that changed, itself or by what it includes, since it was last found clean.
Tests are only compiled, each alone, as builds take them in batches.

Usage: tools/clang-tidy.py [JOBS]   (after `cmake --preset lint`, whose compile commands it reads)
Version 16 at least: older ones do not know C++20's aggregates by parentheses, which the kernels use.
"""
import concurrent.futures
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
build = root / "build/lint"


def is_clean(command, stamp):
    """Whether nothing that the source is made of is younger than its last clean run, which was of the same command."""
    if not stamp.exists() or stamp.read_text() != command["command"]:
        return False
    arguments = shlex.split(command["command"])
    output = arguments.index("-o")
    listing = subprocess.run(arguments[:output] + arguments[output + 2:] + ["-M"],
                             cwd=command["directory"], capture_output=True, text=True)
    if listing.returncode != 0:
        return False
    _, _, files = listing.stdout.replace("\\\n", " ").partition(": ")
    read = [root / ".clang-tidy", *(pathlib.Path(f.replace("\\ ", " ")) for f in re.split(r"(?<!\\)\s+", files.strip()))]
    return all(f.exists() and f.stat().st_mtime <= stamp.stat().st_mtime for f in read)


def main():
    jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    tidy = shutil.which("clang-tidy-16")
    if not tidy:
        sys.exit("clang-tidy: clang-tidy-16 is not installed (tools/install-deps.sh lint)")
    # clang does not read what g++ precompiled; without it, every source has to include what it uses. Parameters are g++'s.
    commands = json.loads((build / "compile_commands.json").read_text())
    for command in commands:
        command["command"] = re.sub(r"-Winvalid-pch -include \S+|--param=\S+", "", command["command"])
    plain = build / "clang-tidy"
    plain.mkdir(exist_ok=True)
    (plain / "compile_commands.json").write_text(json.dumps(commands))

    def check(command):
        source = pathlib.Path(command["file"])
        stamp = plain / source.relative_to(root).with_suffix(".clean")
        if is_clean(command, stamp):
            return None
        if source.is_relative_to(root / "src"):
            run = [tidy, "-p", plain, "--quiet", "--warnings-as-errors=*", source]
        else:
            run = shlex.split(command["command"]) + ["-Werror", "-fsyntax-only"]
        done = subprocess.run(run, cwd=command["directory"], capture_output=True, text=True)
        if done.returncode != 0:
            print(done.stdout or done.stderr, end="", flush=True)  # clang-tidy's stderr counts what was suppressed
            return False
        stamp.parent.mkdir(parents=True, exist_ok=True)
        stamp.write_text(command["command"])
        return True

    due = [c for c in commands if pathlib.Path(c["file"]).is_relative_to(root / "src")
           or pathlib.Path(c["file"]).is_relative_to(root / "tests")]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(check, due))
    print(f"clang-tidy: {len(results) - results.count(None)} sources checked, {results.count(False)} with findings")
    return 1 if False in results else 0


sys.exit(main())
