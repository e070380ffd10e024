"""Writes the documentation of the extension module into its stubs, where editors look for it.

The documentation is written once, in `src/`. Run this with the package installed after a change of it; `--check` only
compares, and is part of `cargo xtask python`.
"""

import ast
import inspect
import sys
from pathlib import Path
from typing import Any

import fingervision._native as native

STUBS = Path(__file__).parent / "package" / "fingervision" / "_native.pyi"


def documented(text: str) -> str:
    """The stubs with the documentation of the module that is installed."""
    lines = text.splitlines()
    for node, runtime in reversed(list(pairs(ast.parse(text)))):
        documentation = inspect.getdoc(runtime)
        # What a class inherits from `object` explains nothing.
        if documentation is None or node.name.startswith("__"):
            continue
        first = node.body[0]
        constant = first.value if isinstance(first, ast.Expr) else None
        is_written = isinstance(constant, ast.Constant)
        is_ellipsis = isinstance(constant, ast.Constant) and constant.value is ...
        quoted = docstring(documentation, " " * (node.col_offset + 4))
        last = first.end_lineno or first.lineno
        if is_ellipsis and lines[first.lineno - 1].strip() != "...":
            head = lines[first.lineno - 1][: first.col_offset].rstrip()
            lines[first.lineno - 1 : last] = [head, *quoted]
        elif is_written:
            lines[first.lineno - 1 : last] = quoted
        else:
            start = min([first.lineno, *(decorator.lineno for decorator in getattr(first, "decorator_list", []))])
            lines[start - 1 : start - 1] = quoted
    return "\n".join(lines) + "\n"


def pairs(tree: ast.Module) -> list[tuple[ast.ClassDef | ast.FunctionDef, Any]]:
    """Classes, methods and functions in order of their lines, with the objects that they describe."""
    found: list[tuple[ast.ClassDef | ast.FunctionDef, Any]] = []
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_"):
            runtime = getattr(native, node.name)
            found.append((node, runtime))
            members = node.body if isinstance(node, ast.ClassDef) else []
            found += [(item, runtime.__dict__[item.name]) for item in members if isinstance(item, ast.FunctionDef)]
    return found


def docstring(text: str, indent: str) -> list[str]:
    """A docstring's lines."""
    first, *rest = text.splitlines()
    if not rest:
        return [f'{indent}"""{first}"""']
    return [f'{indent}"""{first}', *(f"{indent}{line}".rstrip() for line in rest), f'{indent}"""']


def main() -> int:
    """Compares or writes; returns the exit code."""
    text = STUBS.read_text(encoding="utf-8")
    wanted = documented(text)
    if "--check" not in sys.argv:
        STUBS.write_text(wanted, encoding="utf-8")
    elif wanted != text:
        print(f"{STUBS.name} differs from the documentation of the module: run stub_docs.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
