#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Which errors of core/error.hpp the functions of the headers can throw, read off their text.

    python3 scripts/thrown_errors.py [NAME...]

prints them for the functions of these names, or for all. No compiler: a call is an identifier before a parenthesis, and
reaches every function of that name that fits in kind (free, member, constructor) and, for streams and paths, in its first
argument. What a surrounding `catch` takes is left out, and so is a throw whose message says that it is a defect of
slice2mesh. Function objects that a caller hands in are not followed.
check_reference.py compares the result with the docstrings.
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "include", "slice2mesh")
BASES = {"OptionError": "Error", "FileError": "Error", "ParseError": "Error", "GeometryError": "Error",
         "TetrahedralizationError": "Error", "BudgetError": "Error", "Cancelled": "Error", "Error": "exception", "exception": "..."}
# What the text alone does not tell: function, error, why it is not thrown.
NOT_THROWN = {
    ("check_axioms", "Error"): "the layers of a mesh are measured if its arrays fit together",
    ("restore_layers", "Error"): "the arrays of a mesh that was just made fit together",
    ("restored", "Error"): "the complex was found to be sound before it is written",
}
ERRORS = [name for name in BASES if name != "exception"]
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|(?P<string>"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\')|(?P<word>[A-Za-z_]\w*)'
                   r'|(?P<number>\.?\d(?:[\'\w.]|[eE][+-])*)|::|->|\.\.\.|&&|[^\s\w]', re.S)
NOT_CALLS = {"if", "for", "while", "switch", "return", "sizeof", "catch", "decltype", "noexcept", "static_assert", "alignof", "throw"}


class Function:
    """One definition: names of its scopes, where it is, the types of its parameters as text, its tokens."""

    def __init__(self, scope, name, file, first, last, parameters, tokens, is_noexcept):
        self.scope, self.name, self.file, self.first, self.last = scope, name, file, first, last
        self.parameters, self.tokens, self.is_noexcept = parameters, tokens, is_noexcept
        self.owner = scope[-1] if scope and scope[-1][0].isupper() else ""
        self.thrown, self.calls, self.errors = [], [], set()


def tokens_of(text):
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: "\n" * m.group().count("\n"), text, flags=re.M)
    line, end = 1, 0
    for match in TOKEN.finditer(text):
        line += text.count("\n", end, match.start())
        end = match.start()
        if not match.group().startswith(("//", "/*")):
            yield match.group(), line


def closing(tokens, at):
    """Index of the bracket that closes the one at `at`."""
    pairs = {"(": ")", "{": "}", "[": "]"}
    depth = 0
    for i in range(at, len(tokens)):
        if tokens[i][0] in pairs:
            depth += 1
        elif tokens[i][0] in (")", "}", "]"):
            depth -= 1
            if depth == 0:
                return i
    raise ValueError("line %d: a bracket is not closed" % tokens[at][1])


def without_template(head):
    """The tokens of a declaration without `template <...>`."""
    while head and head[0][0] == "template":
        depth = 0
        for i, (token, _) in enumerate(head[1:], 1):
            depth += (token == "<") - (token == ">")
            if depth == 0:
                head = head[i + 1:]
                break
        else:
            return []
    return head


def assigns(head):
    """Whether a declaration has a = outside of parentheses: that of a variable does."""
    i = 0
    while i < len(head):
        if head[i][0] in ("(", "["):
            i = closing(head, i)
        elif head[i][0] == "=":
            return True
        i += 1
    return False


def parse(tokens, begin, end, scope, file, functions, members):
    """Functions of the tokens [begin, end), which are those of a file, a namespace or a class."""
    start = i = begin
    while i < end:
        token = tokens[i][0]
        if token == ";" or (token == ":" and tokens[i - 1][0] in ("public", "private", "protected")):
            members.setdefault(scope[-1] if scope else "", []).extend(t for t, _ in tokens[start:i])
            start = i + 1
        elif token in ("(", "["):
            i = closing(tokens, i)
        elif token == "{":
            close = closing(tokens, i)
            head = without_template(tokens[start:i])
            words = [t for t, _ in head]
            if "namespace" in words:
                names = [w for w in words[words.index("namespace") + 1:] if w != "::"]
                parse(tokens, i + 1, close, scope + names, file, functions, members)
                start = close + 1
            elif words and words[0] in ("class", "struct", "union"):
                parse(tokens, i + 1, close, scope + [words[1]], file, functions, members)
                start = i = close
                start += 1
                continue
            elif "(" in words and "enum" not in words and ("operator" in words or not assigns(head)):
                open_at = words.index("(")
                if words[open_at - 1] == "operator":  # operator()
                    open_at += 2
                close_at = closing(head, open_at)
                if ":" in words[close_at:] and re.match(r"\w", words[-1]) and words[-1] not in ("noexcept", "const"):
                    i = close + 1  # the braces of an initializer of a member
                    continue
                name = "operator" + "".join(words[words.index("operator") + 1:open_at]) if "operator" in words else words[open_at - 1]
                body = head[close_at + 1:] + tokens[i:close + 1]
                functions.append(Function(scope, name, file, head[0][1], tokens[close][1], words[open_at + 1:close_at], body,
                                          "noexcept" in words[close_at:]))
                start = close + 1
            elif assigns(head) and scope and scope[-1][0].isupper():  # a lambda that a member begins with
                functions.append(Function(scope, scope[-1], file, tokens[i][1], tokens[close][1], [], tokens[i:close + 1], False))
            i = close
        i += 1


def caught_by(tokens, at):
    """What the handlers behind the try block that closes at `at` take, without those that throw it on; their tokens stay."""
    types, i = [], at + 1
    while i < len(tokens) and tokens[i][0] == "catch":
        parenthesis = closing(tokens, i + 1)
        block = closing(tokens, parenthesis + 1)
        if not any(tokens[j][0] == "throw" and tokens[j + 1][0] == ";" for j in range(parenthesis, block)):
            types += [t for t, _ in tokens[i + 2:parenthesis] if t in BASES or t == "..."]
        i = block + 1
    return types


def passes(error, caught):
    while error in BASES:
        if error in caught:
            return False
        error = BASES[error]
    return "..." not in caught


def read_body(function):
    tokens = function.tokens
    tries = []  # (end, what is caught)
    for i, (token, _) in enumerate(tokens):
        tries = [t for t in tries if t[0] > i]
        caught = [c for t in tries for c in t[1]]
        if token == "try":
            close = closing(tokens, i + 1)
            tries.append((close, caught_by(tokens, close)))
        elif token == "throw" and tokens[i + 1][0] != ";":
            statement = []
            for t, _ in tokens[i + 1:]:
                if t == ";":
                    break
                statement.append(t)
            if "defect of slice2mesh" not in "".join(t.strip('"') for t in statement if t[0] == '"'):
                error = next((t for t in statement if t in BASES), None)
                if error and passes(error, caught):
                    function.thrown.append(error)
        elif re.match(r"[A-Za-z_]", token) and token not in NOT_CALLS and i + 1 < len(tokens):
            follows, before = tokens[i + 1][0], tokens[i - 1][0] if i > 0 else ""
            first = tokens[i + 2][0] if i + 2 < len(tokens) else ""
            if before not in ("throw",):
                function.calls.append((token, before, tokens[i - 2][0] if before == "::" and i > 1 else "", follows, first, caught))


def is_stream(function):
    return any(t in ("ostream", "istream") for t in function.parameters[:4])


def resolve(functions, members):
    """Edges of the graph of calls, then the errors that reach each function."""
    free, methods, constructors = {}, {}, {}
    for f in functions:
        table = constructors if f.owner and f.name == f.owner else methods if f.owner else free
        table.setdefault(f.name, []).append(f)
    for f in functions:
        words = {t for t, _ in f.tokens} | set(f.parameters) | set(members.get(f.owner, []))
        edges = []
        for name, before, qualifier, follows, first, caught in f.calls:
            found = []
            if before in (".", "->"):
                if follows in ("(", "<"):
                    found = methods.get(name, [])
                    found = [g for g in found if g.owner in words]
            else:
                found = list(constructors.get(name, []))
                if follows in ("(", "<"):
                    if qualifier and qualifier[0].isupper():
                        found += [g for g in methods.get(name, []) if g.owner == qualifier]
                    elif qualifier != "std":
                        found += [g for g in methods.get(name, []) if g.owner == f.owner] or free.get(name, [])
                # A value of a class that is called: Class{...}(...) or a variable of it.
                found += [g for g in methods.get("operator()", []) if g.owner == name]
            streams = [g for g in found if is_stream(g)]
            if streams and len(streams) < len(found):
                found = streams if first in ("out", "stream", "in", "file") else [g for g in found if g not in streams]
            edges += [(g, caught) for g in found if g is not f]
        f.edges = edges
        f.errors = set(f.thrown)
    changed = True
    while changed:
        changed = False
        for f in functions:
            for g, caught in f.edges:
                more = {e for e in g.errors if passes(e, caught) and (f.name, e) not in NOT_THROWN} - f.errors
                if more:
                    f.errors |= more
                    changed = True


def read_headers(root=ROOT):
    """All functions that the headers define, with their errors."""
    functions, members = [], {}
    for folder, _, names in sorted(os.walk(root)):
        for name in sorted(n for n in names if n.endswith(".hpp")):
            path = os.path.join(folder, name)
            with open(path, encoding="utf-8") as file:
                tokens = list(tokens_of(file.read()))
            parse(tokens, 0, len(tokens), [], os.path.relpath(path, root), functions, members)
    for function in functions:
        read_body(function)
    resolve(functions, members)
    return functions


def main():
    for f in read_headers():
        if not sys.argv[1:] or f.name in sys.argv[1:]:
            print("%s:%d: %s: %s" % (f.file, f.first, "::".join(f.scope + [f.name]), " ".join(sorted(f.errors)) or "none"))


if __name__ == "__main__":
    main()
