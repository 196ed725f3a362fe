#!/usr/bin/env python3
"""clang-tidy over the library's sources, with the checks of .clang-tidy.

Most of clang-tidy's time goes into headers, so the sources of a folder that have the same flags are
checked as one file that includes them. If that fails, its halves are checked, down to single
sources, which alone report: two sources may each have something local of one name, and then do not
compile together.
"""
import argparse
import collections
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

SOURCES_PER_GROUP = 8
FOLDERS = ("include", "runtime", "codegen", "sample", "tools/studio", "viewer")


def commands_of(build):
    """The commands of a build by source, without precompiled headers."""
    with open(f"{build}/compile_commands.json", encoding="utf-8") as file:
        return {
            entry["file"]: dict(entry, command=re.sub(
                r" -Winvalid-pch -include \S*cmake_pch\.hxx", "", entry["command"]))
            for entry in json.load(file)
        }


def configured(root):
    """A build tree with a command for each source and the generated headers; its path."""
    build = f"{root}/build/each"
    options = [f"-DPELAGE_CODEGEN_CACHE={root}/build/codegen_cache"]
    codegen = f"{root}/build/release/codegen/pelage-codegen"
    if os.path.exists(codegen):
        options.append(f"-DPELAGE_CODEGEN_EXECUTABLE={codegen}")
    subprocess.run(["cmake", "--preset", "each", *options], cwd=root, check=True,
                   stdout=subprocess.DEVNULL)
    targets = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"], check=True,
                             stdout=subprocess.PIPE, text=True).stdout
    headers = sorted(set(re.findall(r"^(\w+_headers): phony", targets, re.M)))
    subprocess.run(["ninja", "-C", build, *headers], check=True, stdout=subprocess.DEVNULL)
    return build


def groups_of(sources, commands, most):
    """Lists of at most `most` sources of one folder with the same flags, the longest first."""
    folders = collections.defaultdict(list)
    for source in sources:
        if source not in commands:
            sys.exit(f"tidy: {source} is not compiled by the build")
        flags = commands[source]["command"].split(" -o ")[0]
        folders[os.path.dirname(source), flags].append(source)
    groups = [files[first:first + most]
              for files in folders.values() for first in range(0, len(files), most)]
    return sorted(groups, key=len, reverse=True)


def complaint_of(entry):
    """What the build's compiler says of a source by itself; empty when it takes it."""
    command = re.sub(r" -o \S+ -c ", " -fsyntax-only ", entry["command"])
    return subprocess.run(command, shell=True, cwd=entry["directory"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False).stdout


class Tidy:
    def __init__(self, root, out, commands, checks):
        self.root, self.out, self.commands, self.checks = root, out, commands, checks

    def run(self, name, file, entry, checks):
        """Runs clang-tidy on one file, whose command goes into a folder of its own."""
        folder = f"{self.out}/{name}"
        os.makedirs(folder, exist_ok=True)
        with open(f"{folder}/compile_commands.json", "w", encoding="utf-8") as database:
            json.dump([dict(entry, file=file)], database)
        return subprocess.run(
            ["clang-tidy-14", "-p", folder, "--quiet", f"--config-file={self.root}/.clang-tidy",
             f"--checks={checks}", f"--header-filter=^{self.root}/({'|'.join(FOLDERS)})/",
             "--extra-arg=-Wno-unknown-warning-option", file],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)

    @staticmethod
    def compiles(entry):
        flags = entry["command"].partition(" ")[2]
        return subprocess.run(f"clang++-14 {flags} -fsyntax-only -w", shell=True,
                              cwd=entry["directory"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False).returncode == 0

    def check(self, sources, name):
        """What clang-tidy says of these sources; empty when there is nothing to say."""
        if len(sources) == 1:
            done = self.run(name, sources[0], self.commands[sources[0]], self.checks)
            return done.stdout if done.returncode != 0 else ""
        joined = f"{self.out}/{name}.cpp"
        with open(joined, "w", encoding="utf-8") as file:
            file.writelines(f'#include "{source}"\n' for source in sources)
        entry = self.commands[sources[0]]
        entry = dict(entry, command=entry["command"].split(" -o ")[0] + f" -c {joined}")
        checks = self.checks + ",-bugprone-suspicious-include"
        # Compiling says in a fifth of the time that they do not go together.
        if self.compiles(entry) and self.run(name, joined, entry, checks).returncode == 0:
            return ""
        half = len(sources) // 2
        return self.check(sources[:half], name + "a") + self.check(sources[half:], name + "b")


def main():
    arguments = argparse.ArgumentParser(description=__doc__,
                                        formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--each", action="store_true",
                           help="check each source alone: finds one that lacks an #include, and "
                                "takes several times as long")
    arguments.add_argument("--compile", action="store_true",
                           help="compile each source of tests, benchmarks, samples and viewer by "
                                "itself with the build's compiler, and nothing else")
    arguments.add_argument("--analyze", action="store_true",
                           help="with the static analyzer, which takes as long as all else")
    arguments.add_argument("sources", nargs="*", help="these sources; all without")
    options = arguments.parse_args()

    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    listed = subprocess.run(["git", "ls-files"] + [f"{folder}/*.cpp" for folder in FOLDERS[1:]],
                            cwd=root, stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    sources = ([os.path.abspath(source) for source in options.sources] or
               [f"{root}/{source}" for source in listed])
    commands = commands_of(configured(root))
    if options.compile:
        entries = [entry for source, entry in commands.items()
                   if re.match(f"{root}/(tests|benchmark|sample|viewer)/", source)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            said = "".join(pool.map(complaint_of, entries))
        print(f"{said}tidy: {len(entries)} sources compiled")
        sys.exit(1 if said else 0)
    if not any(source.startswith(f"{root}/viewer/") for source in commands):
        sources = [source for source in sources if not source.startswith(f"{root}/viewer/")]
    groups = groups_of(sources, commands, 1 if options.each else SOURCES_PER_GROUP)
    checks = "" if options.analyze else "-clang-analyzer-*"
    tidy = Tidy(root, f"{root}/build/tidy", commands, checks)
    os.makedirs(tidy.out, exist_ok=True)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(tidy.check, groups, map("group_{}".format, range(len(groups)))))
    print("".join(said), end="")
    sys.exit(1 if any(said) else 0)


main()
