"""The stub has what the module has, and the other way round."""

from __future__ import annotations

import ast
import importlib.util
import inspect
from pathlib import Path

import pytest

import powergs
from powergs import _powergs

STUB = ast.parse((Path(__file__).parents[1] / "powergs" / "_powergs.pyi").read_text())

# What Python or pyo3 gives every class, and what a stub says of a protocol only.
GIVEN = {"__doc__", "__module__", "__new__", "__repr__", "__str__", "__reduce__", "__iter__"}
GIVEN |= {"__getattr__", "__eq__", "__ne__", "__lt__", "__le__", "__gt__", "__ge__", "__hash__"}
GIVEN |= {"__getattribute__"}


def defined(body: list[ast.stmt]) -> dict[str, ast.stmt]:
    named = (ast.FunctionDef, ast.ClassDef)
    return {node.name: node for node in body if isinstance(node, named)}


def parameters(node: ast.FunctionDef) -> list[tuple[str, str, object]]:
    """Names, kinds and whether there is a default; without ``self``."""
    args = node.args
    found = [(a.arg, "positional", None) for a in args.posonlyargs]
    found += [(a.arg, "either", None) for a in args.args]
    defaults: list[object] = [None] * (len(found) - len(args.defaults)) + [
        ast.unparse(d) for d in args.defaults
    ]
    result = [(name, kind, default) for (name, kind, _), default in zip(found, defaults)]
    if args.vararg:
        result.append((args.vararg.arg, "list", None))
    for a, d in zip(args.kwonlyargs, args.kw_defaults):
        result.append((a.arg, "keyword", ast.unparse(d) if d else None))
    if args.kwarg:
        result.append((args.kwarg.arg, "keywords", None))
    return [p for p in result if p[0] not in ("self", "cls")]


KINDS = {
    inspect.Parameter.POSITIONAL_ONLY: "positional",
    inspect.Parameter.POSITIONAL_OR_KEYWORD: "either",
    inspect.Parameter.KEYWORD_ONLY: "keyword",
    inspect.Parameter.VAR_POSITIONAL: "list",
    inspect.Parameter.VAR_KEYWORD: "keywords",
}


def actual(function: object) -> list[tuple[str, str, object]]:
    signature = inspect.signature(function)  # type: ignore[arg-type]
    none = inspect.Parameter.empty
    return [
        (p.name, KINDS[p.kind], None if p.default is none else repr(p.default))
        for p in signature.parameters.values()
        if p.name != "self"
    ]


def same(ours: list[tuple[str, str, object]], its: list[tuple[str, str, object]]) -> bool:
    plain = [(name, kind, str(default).replace('"', "'")) for name, kind, default in ours]
    return plain == [(name, kind, str(default).replace('"', "'")) for name, kind, default in its]


def test_names_agree() -> None:
    stub = set(defined(STUB.body))
    stub -= {"_Bar", "_FitSettings", "_Quality", "_Settings"} | {"_Arrays", "_DisplayPower", "_Replayed"}
    module = {name for name in vars(_powergs) if not name.startswith("__")}
    assert stub == module


@pytest.mark.parametrize("name", [n for n in powergs.__all__ if hasattr(_powergs, n)])
def test_members_and_signatures_agree(name: str) -> None:
    if name.startswith("__"):
        return
    node, thing = defined(STUB.body)[name], getattr(_powergs, name)
    assert thing.__doc__, f"{name} has no docstring"
    if isinstance(node, ast.FunctionDef):
        assert same(parameters(node), actual(thing)), name
        return
    assert isinstance(node, ast.ClassDef)
    stub = defined(node.body)
    module = set(vars(thing))
    assert set(stub) - GIVEN == module - GIVEN, name
    for member in set(stub) - GIVEN:
        method = stub[member]
        assert isinstance(method, ast.FunctionDef)
        is_property = any(ast.unparse(d) == "property" for d in method.decorator_list)
        value = vars(thing)[member]
        assert is_property == inspect.isdatadescriptor(value), f"{name}.{member}"
        if member.startswith("_"):
            continue
        assert getattr(thing, member).__doc__, f"{name}.{member} has no docstring"
        if not is_property:
            call = getattr(thing, member)
            assert same(parameters(method), actual(call)), f"{name}.{member}"


def test_docstrings_and_commands_are_those_of_the_module() -> None:
    spec = importlib.util.spec_from_file_location("stubs", Path(__file__).parents[1] / "stubs.py")
    assert spec is not None and spec.loader is not None
    stubs = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(stubs)
    folder = Path(powergs.__file__).parent
    for name, wanted in [
        ("_powergs.pyi", stubs.documented((folder / "_powergs.pyi").read_text())),
        ("commands.pyi", powergs.commands._stub()),
    ]:
        same = (folder / name).read_text() == wanted
        assert same, f"{name}: write it anew with `python -P python/stubs.py`"


def test_the_package_hands_everything_on() -> None:
    public = {name for name in vars(_powergs) if not name.startswith("_")}
    assert public <= set(powergs.__all__)
    assert sorted(powergs.__all__, key=str.lower) == sorted(set(powergs.__all__), key=str.lower)
    assert all(hasattr(powergs, name) for name in powergs.__all__)
