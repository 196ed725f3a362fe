"""Breaks kernels and the order of a frame, one line at a time, and reports which test notices.

    python3 scripts/mutants.py [--check] [--build DIR] [--report FILE] [NAME...]

tests/mutants.json has the mutants: a text of a source, what replaces it, and the tests (a
program and a filter of GoogleTest) of which one has to fail. Each mutant is written into the working
tree, built in DIR (build/release), tested and taken back. The exit status is 1 if one survives.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
SECONDS = 600  # a test that takes longer hangs


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def mutated(mutant):
    path = os.path.join(ROOT, mutant["file"])
    text = read(path)
    if text.count(mutant["from"]) != 1:
        sys.exit(f"{mutant['name']}: {mutant['file']} has {text.count(mutant['from'])} times: "
                 f"{mutant['from']}")
    return path, text, text.replace(mutant["from"], mutant["to"])


def program(build, name):
    for folder, _, files in os.walk(os.path.join(build, "tests")):
        if name in files:
            return os.path.join(folder, name)
    sys.exit(f"{name}: no such program under {build}/tests; build the tests first")


def built(build, targets):
    done = subprocess.run(["cmake", "--build", build, "--target", *targets], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode == 0, done.stdout


def first_failure(output):
    for line in output.splitlines():
        if line.startswith("[  FAILED  ] ") or "ERROR: AddressSanitizer" in line:
            return line.removeprefix("[  FAILED  ] ").split(",")[0].split(" (")[0]
    return "crash"


def killer(build, tests):
    """The first test that fails, or None. Tests that run and pass without the mutant are assumed."""
    for test in tests:
        name, _, chosen = test.partition(":")
        arguments = [program(build, name), "--gtest_fail_fast", "--gtest_brief=1"]
        if chosen:
            arguments.append("--gtest_filter=" + chosen)
        try:
            done = subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, errors="replace", timeout=SECONDS, check=False)
        except subprocess.TimeoutExpired:
            return f"{name}: over {SECONDS} s"
        if done.returncode != 0:
            return f"{name}: {first_failure(done.stdout)}"
        if "[  SKIPPED ]" in done.stdout:
            sys.exit(f"{test}: skipped; mutants need all drivers")
    return None


def check_tests(build, mutant):
    for test in mutant["tests"]:
        name, _, chosen = test.partition(":")
        listed = subprocess.run([program(build, name), "--gtest_list_tests",
                                 "--gtest_filter=" + (chosen or "*")],
                                stdout=subprocess.PIPE, text=True, check=True).stdout
        if "\n  " not in listed:
            sys.exit(f"{mutant['name']}: there is no test {test}")


def run(build, mutant):
    path, text, changed = mutated(mutant)
    targets = sorted({test.partition(":")[0] for test in mutant["tests"]})
    write(path, changed)
    try:
        good, log = built(build, targets)
        if not good:
            return "does not build: " + log[-400:]
        return killer(build, mutant["tests"])
    finally:
        write(path, text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--build", default=os.path.join(ROOT, "build/release"))
    parser.add_argument("--report")
    parser.add_argument("--check", action="store_true",
                        help="only see that sources have the texts that are replaced")
    options = parser.parse_args()
    # A mutant is taken back when the run is stopped, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    os.environ["PELAGE_REQUIRE_DEVICES"] = "1"
    mutants = json.loads(read(os.path.join(ROOT, "tests/mutants.json")))
    for mutant in mutants:
        mutated(mutant)
        if not options.check:
            check_tests(options.build, mutant)
    if options.check:
        return
    survivors = []
    lines = []
    for mutant in mutants:
        if options.names and mutant["name"] not in options.names:
            continue
        start = time.monotonic()
        found = run(options.build, mutant)
        if found is None or found.startswith("does not build"):
            survivors.append(mutant["name"])
        lines.append(f"| {mutant['name']} | {found or 'SURVIVES'} |")
        print(f"{lines[-1]}  {time.monotonic() - start:.0f} s", flush=True)
    print(f"{len(lines) - len(survivors)} of {len(lines)} mutants killed")
    if options.report:
        write(options.report, "| mutant | killed by |\n|---|---|\n" + "\n".join(lines) + "\n")
    sys.exit(1 if survivors else 0)


if __name__ == "__main__":
    main()
