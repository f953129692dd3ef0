#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the docstrings of all public names, by the XML of Doxygen and the text of the headers.

    python3 scripts/check_reference.py DIRECTORY_OF_XML

Names are types, their public members, free functions, variables, aliases, macros and enumerators. For all of them:

* there is a docstring (Doxygen itself says nothing of enumerators);
* a floating-point number (member, parameter, result, alias) has a unit of UNITS in its docstring or that of its function;
* an array that grows (std::vector, std::map, a matrix) has its shape there: #V, #T, "one per", "by 3", ...; one of fixed
  length says what stands in it;
* an integer says there what it counts, or that it is an index;
* the docstring of a function names its parameters of these kinds;
* a function names each error of core/error.hpp that it or what it calls throws (thrown_errors.py), and no other. docs/reference.md has what
  holds without being said: OptionError of what takes options, Cancelled of what takes a Progress.

What nobody calls by name (comparisons, destructors, what is deleted or defaulted) may go without. Ends with 1, naming what is missing.
"""
import collections
import glob
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

sys.dont_write_bytecode = True
import thrown_errors  # noqa: E402 (beside this file)

UNITS = re.compile(r"(?<!['\w])(mm(\^[23])?|mm/s|s|W|K|t/mm\^3|m[WJ]/\(\S+ K\)|degrees|pitch(es)?|steps|(file )?units?|"
                   r"R/3r|ratios?|shares?|relative|times the|radii|number of)(?![\w^])|%")
SHAPES = re.compile(r"#[A-Za-z]\w*|\bby [2346]\b|\bper \w+|\bby (part id|name|(its )?index)\b|\bbytes\b|\bany number\b|"
                    r"\bas many\b")
FIXED = re.compile(SHAPES.pattern + r"|\bx1? y1? z1?\b|\bx, y, z\b|\bby \w+Kind\b|\b(corners?|vertices|edges|start and end|below and above)\b")
COUNTS = re.compile(r"#[A-Za-z]\w*|\b(index|indices|ids?|numbers?|how many|from [01]|bytes|pitch(es)?|multiples?|limit|offset|"
                    r"hash)\b", re.I)
FLOAT = re.compile(r"\b(double|float|Point2)\b")
GROWING = re.compile(r"\b(vector|map|set|deque|Matrix|Map|span)\s*<")
ARRAY = re.compile(r"\barray\s*<")
INTEGER = re.compile(r"\b(u?int(8|16|32|64)?_t|size_t|ptrdiff_t|int|unsigned)\b")


def text(node, tag):
    child = node.find(tag)
    return "" if child is None else " ".join("".join(child.itertext()).split())


def doc_of(node):
    return (text(node, "briefdescription") + " " + text(node, "detaileddescription")).strip()


def needs_none(member):
    name, arguments = text(member, "name"), text(member, "argsstring").replace(" ", "")
    return name.startswith("~") or arguments.endswith(("=delete", "=default")) or name in ("operator==", "operator!=", "operator<")


class Checker:
    def __init__(self):
        self.names, self.problems = 0, []
        self.docs = collections.defaultdict(list)  # of functions, by their names without scopes
        self.functions = collections.defaultdict(list)
        for function in thrown_errors.read_headers():
            self.functions[function.file, function.name].append(function)
        self.compared = 0

    def problem(self, name, why):
        self.problems.append("%s: %s" % (name, why))

    def typed(self, name, kind, declared, doc):
        """The rules on a type: unit, shape, what is counted."""
        if FLOAT.search(declared) and not UNITS.search(doc):
            self.problem(name, "no unit of " + kind)
        if GROWING.search(declared):
            if not SHAPES.search(doc):
                self.problem(name, "no shape of " + kind)
        elif ARRAY.search(declared):
            if not FIXED.search(doc):
                self.problem(name, "not said what stands in " + kind)
        if INTEGER.search(declared) and not COUNTS.search(doc):
            self.problem(name, "not said what counts or is indexed by " + kind)

    def function(self, name, member, doc, around):
        """Parameters, result and errors; `around` is the docstring of the class."""
        plain, only = name.split("::")[-1], doc
        if re.search(r"\b(the same|as above|stream versions?|see above)\b", doc, re.I):
            doc += " " + around + " " + " ".join(d for d in self.docs[plain] if d != doc)
        said_of = re.sub(r"\b(Cost|Errors?):.*?(?=\b(Cost|Errors?):|$)", "", doc)
        for param in member.findall("param"):
            declared, called = text(param, "type"), text(param, "declname")
            if not called:
                continue
            self.typed(name, "`%s`" % called, declared, said_of)
            numbers = any(kind.search(declared) for kind in (FLOAT, GROWING, ARRAY, INTEGER))
            if numbers and not re.search(r"\b%s\b" % called, doc):
                self.problem(name, "`%s` is not named" % called)
        self.typed(name, "the result", text(member, "type"), said_of)

        location = member.find("location")
        file, line = location.get("file").split("slice2mesh/", 1)[-1], int(location.get("line"))
        found = self.functions[file, plain if not plain.startswith("operator") else plain.replace(" ", "")]
        found = [f for f in found if f.first <= line <= f.last] or found
        if not found:
            return
        self.compared += 1
        errors = set().union(*(f.errors for f in found))
        said = self.named(doc + " " + around, {plain})
        types = [text(param, "type") for param in member.findall("param")]
        free = set()
        if any(re.search(r"Options\b", t) for t in types):
            free.add("OptionError")
        if any(re.search(r"\bProgress\b", t) for t in types):
            free.add("Cancelled")
        for error in sorted(errors - said - free):
            self.problem(name, "may throw %s, which is not named" % error)
        own = set(re.findall(r"\w+", only)) & set(thrown_errors.ERRORS) - {"Error"} - errors
        for error in sorted(own):
            self.problem(name, "names %s, which nothing throws" % error)

    def named(self, doc, seen):
        """Errors that a docstring names, or those of the functions that it refers to."""
        said = set(re.findall(r"\w+", doc)) & set(thrown_errors.ERRORS)
        for place in re.findall(r"\b(?:those of|as|see) ([^.;:]*)", doc, re.I):
            for word in sorted(set(re.findall(r"\w+", place)) - seen):
                for other in self.docs.get(word, []):
                    said |= self.named(other, seen | {word})
        return said

    def member(self, scope, around, kind, node):
        name = text(node, "name") if kind == "file" else scope + "::" + text(node, "name")
        doc, what = doc_of(node), node.get("kind")
        self.names += 1
        if not needs_none(node):
            if not doc:
                self.problem(name, "no docstring")
            elif what == "function":
                self.function(name, node, doc, around if kind not in ("namespace", "file") else "")
            elif what in ("variable", "typedef"):
                self.typed(name, "it", text(node, "type"), doc)
        for value in node.findall("enumvalue"):
            self.names += 1
            if not doc_of(value):
                self.problem(name + "::" + text(value, "name"), "no docstring")

    def run(self, directory):
        compounds = []
        for path in sorted(glob.glob(os.path.join(directory, "*.xml"))):
            for compound in ElementTree.parse(path).getroot().iter("compounddef"):
                kind, hidden = compound.get("kind"), compound.get("prot") in ("private", "protected")
                if kind in ("struct", "class", "union", "concept", "namespace", "file") and not hidden:
                    compounds.append((compound, kind, text(compound, "compoundname"), doc_of(compound)))
        members = []
        for compound, kind, scope, doc in compounds:
            for node in compound.iter("memberdef"):
                # The members of a file are those of its namespaces, but for macros.
                if node.get("prot") == "public" and (kind != "file" or node.get("kind") == "define"):
                    members.append((scope, doc, kind, node))
                    if node.get("kind") == "function":
                        self.docs[text(node, "name")].append(doc_of(node) + " " + (doc if kind in ("struct", "class") else ""))
        for compound, kind, scope, doc in compounds:
            if kind in ("struct", "class", "union", "concept"):
                self.names += 1
                if not doc:
                    self.problem(scope, "no docstring")
        for arguments in members:
            self.member(*arguments)


def main():
    checker = Checker()
    checker.run(sys.argv[1])
    for problem in checker.problems:
        print("check_reference.py: " + problem, file=sys.stderr)
    if checker.names < 500 or checker.compared < 200:
        print("check_reference.py: only %d names, the errors of %d functions: is the search wrong?" % (checker.names, checker.compared),
              file=sys.stderr)
        return 1
    print("%d public names, the errors of %d functions" % (checker.names, checker.compared))
    return 1 if checker.problems else 0


if __name__ == "__main__":
    sys.exit(main())
