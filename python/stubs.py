"""Writes what editors and type checkers read: ``commands.pyi`` from what the program takes, and the
docstrings of ``_powergs.pyi`` from the module, where they are written. Types are written by hand.

Usage: python -P python/stubs.py   (with the package installed from this tree)
"""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

from powergs import _powergs, commands

FOLDER = Path(__file__).parent / "powergs"


def documented(source: str) -> str:
    """The stub with the docstrings of the module in place of its own."""
    lines = source.splitlines()
    edits: list[tuple[int, int, list[str]]] = []

    def visit(node: ast.FunctionDef | ast.ClassDef, thing: object, depth: int) -> None:
        text = inspect.cleandoc(getattr(thing, "__doc__", None) or "")
        body = node.body[0]
        has_own = isinstance(body, ast.Expr) and isinstance(getattr(body.value, "value", 0), str)
        is_class = isinstance(node, ast.ClassDef)
        if text and "\\" not in text:
            inside = "    " * (depth + 1)
            whole = f'"""{text}"""' if "\n" not in text else f'"""{text}\n"""'
            new = [(inside + line).rstrip() for line in whole.splitlines()]
            if has_own:
                edits.append((body.lineno, body.end_lineno or body.lineno, new))
            elif is_class:
                edits.append((body.lineno - len(getattr(body, "decorator_list", [])), 0, new))
            else:
                # ``def f() -> int: ...`` gets a body in place of the dots.
                line = lines[body.lineno - 1]
                head = line[: line.rindex("...")].rstrip()
                edits.append((body.lineno, body.lineno, [head, *new]))
        if isinstance(node, ast.ClassDef):
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                    own = inspect.getattr_static(thing, member.name, None)
                    # A static method has the text of ``staticmethod`` itself.
                    own = own.__func__ if isinstance(own, staticmethod) else own
                    visit(member, own, depth + 1)

    for node in ast.parse(source).body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            visit(node, getattr(_powergs, node.name), 0)
    for first, last, new in sorted(edits, key=lambda edit: -edit[0]):
        lines[first - 1 : max(last, first - 1)] = new
    return "\n".join(lines) + "\n"


def main() -> None:
    """Writes both files anew."""
    (FOLDER / "commands.pyi").write_text(commands._stub(), encoding="utf-8")
    stub = FOLDER / "_powergs.pyi"
    stub.write_text(documented(stub.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
