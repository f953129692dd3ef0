#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that every public name has a docstring, by the XML of Doxygen, which itself says nothing of enumerators.

    python3 scripts/check_reference.py DIRECTORY_OF_XML

Names are types, their public members, free functions, variables, aliases, macros and enumerators; what nobody calls by name (comparisons,
destructors, what is deleted or defaulted) may go without. Ends with 1, naming what is not documented.
"""
import glob
import os
import sys
import xml.etree.ElementTree as ElementTree


def text(node, tag):
    child = node.find(tag)
    return "" if child is None else "".join(child.itertext()).strip()


def documented(node):
    return bool(text(node, "briefdescription") or text(node, "detaileddescription"))


def needs_none(member):
    name, arguments = text(member, "name"), text(member, "argsstring").replace(" ", "")
    return name.startswith("~") or arguments.endswith(("=delete", "=default")) or name in ("operator==", "operator!=", "operator<")


def main():
    names, missing = 0, []
    for path in sorted(glob.glob(os.path.join(sys.argv[1], "*.xml"))):
        for compound in ElementTree.parse(path).getroot().iter("compounddef"):
            kind, scope = compound.get("kind"), text(compound, "compoundname")
            if kind not in ("struct", "class", "union", "namespace", "file") or compound.get("prot") in ("private", "protected"):
                continue
            if kind in ("struct", "class", "union"):
                names += 1
                if not documented(compound):
                    missing.append(scope)
            for member in compound.iter("memberdef"):
                # The members of a file are those of its namespaces, but for macros.
                if member.get("prot") != "public" or (kind == "file" and member.get("kind") != "define"):
                    continue
                name = text(member, "name") if kind == "file" else scope + "::" + text(member, "name")
                names += 1
                if not documented(member) and not needs_none(member):
                    missing.append(name)
                for value in member.findall("enumvalue"):
                    names += 1
                    if not documented(value):
                        missing.append(name + "::" + text(value, "name"))
    for name in missing:
        print("check_reference.py: no docstring: " + name, file=sys.stderr)
    if names < 500:
        print("check_reference.py: only %d names: is the search wrong?" % names, file=sys.stderr)
        return 1
    print("%d public names" % names)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
