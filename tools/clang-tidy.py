#!/usr/bin/env python3
"""Runs clang-tidy on every source of src/ that changed, itself or by what it includes, since it was last found clean.

Usage: tools/clang-tidy.py [JOBS]   (after a release build, whose compile commands and dependencies it reads)
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
build = root / "build/release"


def includes():
    """{object file: the files it was compiled from}, as ninja recorded them."""
    listing = subprocess.run(["ninja", "-C", build, "-t", "deps"], check=True, capture_output=True, text=True).stdout
    blocks = re.findall(r"^(\S+): #deps.*\n((?:    .+\n)+)", listing, re.MULTILINE)
    return {target: [build / line.strip() for line in files.splitlines()] for target, files in blocks}


def main():
    jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    tidy = shutil.which("clang-tidy-16")
    if not tidy:
        sys.exit("clang-tidy: clang-tidy-16 is not installed (tools/install-deps.sh lint)")
    files_of = includes()
    commands = json.loads((build / "compile_commands.json").read_text())
    due = []
    for command in commands:
        source = pathlib.Path(command["file"])
        if not source.is_relative_to(root / "src"):
            continue
        stamp = build / "clang-tidy" / source.relative_to(root / "src").with_suffix(".clean")
        arguments = shlex.split(command["command"])
        read = [root / ".clang-tidy", source, *files_of.get(arguments[arguments.index("-o") + 1], [])]
        if not stamp.exists() or any(not f.exists() or f.stat().st_mtime > stamp.stat().st_mtime for f in read):
            due.append((source, stamp))

    # clang does not read what g++ precompiled; without it, every source has to include what it uses. Parameters are g++'s.
    for command in commands:
        command["command"] = re.sub(r"-Winvalid-pch -include \S+|--param=\S+", "", command["command"])
    plain = build / "clang-tidy"
    plain.mkdir(exist_ok=True)
    (plain / "compile_commands.json").write_text(json.dumps(commands))

    def check(source, stamp):
        run = subprocess.run([tidy, "-p", plain, "--quiet", "--warnings-as-errors=*", source],
                             capture_output=True, text=True)  # stderr counts what was suppressed
        if run.returncode != 0:
            print(run.stdout or run.stderr, end="", flush=True)
        if run.returncode == 0:
            stamp.parent.mkdir(parents=True, exist_ok=True)
            stamp.touch()
        return run.returncode == 0

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        clean = list(pool.map(check, *zip(*due))) if due else []
    print(f"clang-tidy: {len(due)} sources checked, {clean.count(False)} with findings")
    return 1 if False in clean else 0


sys.exit(main())
