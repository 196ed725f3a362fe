"""Every test of every program is run by exactly one entry of ctest, shards and tiers aside.

    test_entries.py BUILD_DIRECTORY

Entries choose tests by suites and APIs in names (pelage_tests() in tests/CMakeLists.txt); a test whose
name no filter matches would never run.
"""
import collections
import json
import subprocess
import sys


def tests_of(program, arguments):
    """Full names of the tests that a program would run."""
    text = subprocess.run([program, *arguments, "--gtest_list_tests"], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    suite, names = "", []
    for line in text.splitlines():
        name = line.split("#")[0].rstrip()
        if name and not name.startswith(" "):
            suite = name
        elif name:
            names.append(suite + name.strip())
    return names


def main():
    listed = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=sys.argv[1], check=True,
                                       stdout=subprocess.PIPE, text=True).stdout)
    chosen = collections.defaultdict(set)  # filters of a program
    for test in listed["tests"]:
        program, *arguments = test.get("command", [""])
        labels = [p["value"] for p in test["properties"] if p["name"] == "LABELS"]
        if arguments and arguments[0].startswith("--gtest_filter=") and "tiers" not in sum(labels, []):
            chosen[program].add(arguments[0])
    wrong = []
    for program, filters in sorted(chosen.items()):
        runs = collections.Counter()
        for f in filters:
            names = tests_of(program, [f])
            runs.update(names)
            if not names:
                wrong.append(f"{program}: an entry without a test: {f}")
        for name in tests_of(program, []):
            if runs[name] != 1:
                wrong.append(f"{program}: {runs[name]} entries run {name}")
    print("\n".join(wrong) or f"{len(chosen)} programs: one entry for each test")
    if wrong or not chosen:
        sys.exit(1)


main()
