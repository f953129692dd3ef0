#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that docs/errors.md lists the diagnostics of the code and docs/options.md the options of the program, and that the
version is the same everywhere.

    python3 scripts/check_catalogs.py [path of the program slice2mesh]

Codes are those that the headers add to diagnostics, with their severity; options and defaults are those of --help, and
are left out without the program. Ends with 1, naming what is missing, superfluous or different.
"""
import json
import os
import re
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")


def text_of(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def codes_of_headers():
    found = set()
    for folder, _, names in os.walk(os.path.join(ROOT, "include")):
        for name in names:
            text = text_of(folder, name)
            for severity, code in re.findall(r"Severity::(\w+),\s*(?:Stage::\w+,\s*)?\"([a-z0-9_]+)\"", text):
                found.add((code, severity.lower()))
            found.update((code, "note") for code in re.findall(r"\bnote\((?!Severity)[\w.\[\]]+,\s*\"([a-z0-9_]+)\"", text))
    return found


def codes_of_page():
    rows = re.findall(r"^\| `([a-z0-9_]+)` \| (note|repair|warning) \|", text_of("docs", "errors.md"), re.M)
    return set(rows)


def options_of_program(program):
    """Names of the options with the default that --help shows."""
    found = set()
    for arguments in (["--help"], ["info", "--help"]):
        lines = subprocess.run([program] + arguments, check=True, capture_output=True, text=True).stdout
        # "  -o,--output FILE ...", "  --eps LENGTH=0.1h  text": the default ends at the column of the text or the line.
        for names, default in re.findall(r"^ {2}(-\S+)(?: [^\s=]+(?:=(.*?))?)?(?: \.\.\.)?(?: {2,}.*| [A-Z].*)?$", lines, re.M):
            found.add((names.split(",")[-1], default.strip()))
    return found


def options_of_page():
    rows = re.findall(r"^\| `(?:-\w, )?(--[a-z0-9-]+)[^`]*` \|(?:[^|]*\|){2}([^|]*)\|", text_of("docs", "options.md"), re.M)
    return {(name, default.strip("` ")) for name, default in rows}


def compare(what, code, page):
    for item in sorted(code - page):
        print(f"{what}: not on the page: {' '.join(item)}", file=sys.stderr)
    for item in sorted(page - code):
        print(f"{what}: on the page only: {' '.join(item)}", file=sys.stderr)
    print(f"{what}: {len(page)} on the page")
    return code == page and bool(page)


def versions_agree():
    version = re.search(r'SLICE2MESH_VERSION "([0-9.]+)"', text_of("include", "slice2mesh", "version.hpp")).group(1)
    citation = re.search(r"^version: (\S+)", text_of("CITATION.cff"), re.M).group(1)
    port = json.loads(text_of("cmake", "vcpkg", "vcpkg.json"))["version"]
    if not version == citation == port:
        print(f"versions: {version}, CITATION.cff {citation}, vcpkg.json {port}", file=sys.stderr)
    return version == citation == port


def main():
    good = compare("diagnostics", codes_of_headers(), codes_of_page())
    if len(sys.argv) > 1:
        good = compare("options", options_of_program(sys.argv[1]), options_of_page()) and good
    good = versions_agree() and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
