#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that the code in README.md and docs/*.md is compiled: each C++ block stands, line after line, in a file of examples/ or
tests/consumer/, indentation apart. (The CMake of the README is built by the test consumer.readme.)

    python3 scripts/check_snippets.py [root of the repository]

Ends with 1 and prints the blocks that are nowhere, or if there are no blocks at all.
"""
import glob
import os
import re
import sys


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def lines_of(text):
    return "\n" + "\n".join(line.strip() for line in text.strip().splitlines()) + "\n"


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")

    def files(*patterns):
        return [path for pattern in patterns for path in sorted(glob.glob(os.path.join(root, pattern)))]

    compiled = [lines_of(read(path)) for path in files("examples/*.cpp", "tests/consumer/*/*.cpp")]
    seen, missing = 0, 0
    for page in files("README.md", "docs/*.md"):
        for block in re.findall(r"^```(?:cpp|c\+\+)\n(.*?)^```", read(page), re.M | re.S):
            seen += 1
            if not any(lines_of(block) in text for text in compiled):
                missing += 1
                print("%s: in no file that is compiled:\n%s" % (os.path.relpath(page, root), block), file=sys.stderr)
    print("%d blocks of code, %d of them not compiled" % (seen, missing))
    return 0 if seen > 0 and missing == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
