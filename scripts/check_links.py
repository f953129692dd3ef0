#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the links of all Markdown files of the project, without the network.

    python3 scripts/check_links.py [directory, default the project]

A relative link must lead to a file of the project (not only of this machine), and its anchor to a heading or a line of
it. Links to the web are not followed. Ends with 1, naming file and line, when a link is dead or no link was seen.
"""
import os
import re
import sys

SKIPPED = re.compile(r"^(\.git|build.*|\.cache|_deps)$")
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(\s*<?([^()\s<>]+(?:\([^()\s]*\)[^()\s]*)?)>?(?:\s+\"[^\"]*\")?\s*\)")
REFERENCE = re.compile(r"^\s{0,3}\[[^\]]+\]:\s+<?(\S+?)>?(?:\s|$)")
SCHEME = re.compile(r"^[a-zA-Z][a-zA-Z0-9+.-]*:")


def markdown_files(root):
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(f for f in folders if not SKIPPED.match(f))
        for name in sorted(names):
            if name.endswith(".md"):
                yield os.path.join(folder, name)


def lines_outside_code(path):
    """Number and text of the lines that are not in a fenced block, with code spans taken out."""
    fence = None
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            mark = re.match(r"^\s*(```+|~~~+)", line)
            if mark:
                if fence is None:
                    fence = mark.group(1)[:3]
                elif mark.group(1).startswith(fence):
                    fence = None
                continue
            if fence is None:
                yield number, line


def anchors(path):
    """The anchors of the headings, as GitHub makes them."""
    found = set()
    for _, line in lines_outside_code(path):
        found.update(re.findall(r"<a\s+(?:id|name)=\"([^\"]+)\"", line))
        heading = re.match(r"^#{1,6}\s+(.*?)\s*#*\s*$", line)
        if not heading:
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1))
        slug = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
        name, count = slug, 0
        while name in found:
            count += 1
            name = f"{slug}-{count}"
        found.add(name)
    return found


def fault(root, path, target):
    """Why a link is dead, or nothing."""
    if SCHEME.match(target):
        return "a path of one machine" if target.startswith("file:") else None
    name, _, anchor = target.partition("#")
    if name.startswith("/"):
        return "an absolute path"
    goal = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
    if os.path.commonpath([os.path.abspath(goal), root]) != root:
        return "leads out of the project"
    if not os.path.exists(goal):
        return "there is no such file"
    if anchor and goal.endswith(".md") and anchor not in anchors(goal):
        return "there is no such heading"
    return None


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    root = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, ".."))
    files = links = dead = 0
    for path in markdown_files(root):
        files += 1
        for number, line in lines_outside_code(path):
            text = re.sub(r"`[^`]*`", "``", line)
            targets = LINK.findall(text) + REFERENCE.findall(text)
            for target in targets:
                links += 1
                why = fault(root, path, target)
                if why:
                    dead += 1
                    print(f"{os.path.relpath(path, root)}:{number}: {target}: {why}", file=sys.stderr)
    print(f"{links} links in {files} Markdown files, {dead} dead")
    return 1 if dead or not links else 0


if __name__ == "__main__":
    sys.exit(main())
