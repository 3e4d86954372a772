"""Every command of the program ``powergs-sim`` as a function.

>>> done = powergs.commands.sensitivity("gscore", trace, set={"vru.cores": 8})       # doctest: +SKIP
>>> done.folder.tables["sensitivity"]                                                # doctest: +SKIP

Names are those of the program with ``_`` for ``-``: ``sweep status`` is ``sweep_status``,
``--dram-model banked`` is ``dram_model="banked"``; ``--lambda`` is ``lambda_``. A flag with several
values takes a list, ``set`` also a dictionary. ``help(powergs.commands.replay)`` lists the rest.

A command runs in a process of its own, so Ctrl-C, memory and threads are the program's, and numbers
are those of the program to the last bit. Where it writes a folder and ``out`` does not say where,
the folder is temporary, and goes when its ``Outcome`` does.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from typing import Any

from ._powergs import _commands
from .program import Folder, Outcome, near, python_name, run

#: Flags and commands without a name in Python, with the reason.
WITHOUT_NAME = {
    "--help": "help(powergs.commands.replay)",
    "--version": "powergs.__build__",
    "--json": "always given: Outcome.result is what it prints",
    "--quiet": "the opposite of progress=True",
    "completions": "it is for shells",
}


def _function(command: dict[str, Any]) -> Callable[..., Outcome]:
    both = inspect.Parameter.POSITIONAL_OR_KEYWORD
    parameters, lines = [], [command["help"] + ".", "", "Parameters", "----------"]
    for argument in sorted(command["arguments"], key=lambda a: bool(a["is_flag"])):
        name = python_name(argument["name"])
        if f"--{argument['name']}" in WITHOUT_NAME and argument["is_flag"]:
            continue
        is_place = not argument["is_flag"]
        kind = both if is_place else inspect.Parameter.KEYWORD_ONLY
        needed = is_place and argument["is_required"]
        default = inspect.Parameter.empty if needed else False if argument["takes"] == 0 else None
        parameters.append(inspect.Parameter(name, kind, default=default, annotation=_kind(argument)))
        lines += [f"{name} : {_kind(argument)}", f"    {argument['help']}"]
    parameters.append(
        inspect.Parameter(
            "progress", inspect.Parameter.KEYWORD_ONLY, default=False, annotation="bool"
        )
    )
    lines += ["progress : bool", "    Show the notes and the progress of the program."]
    # What comes after one that may be left out may be left out.
    signature = inspect.Signature(_optional(parameters), return_annotation="Outcome")

    def call(*args: Any, **kwargs: Any) -> Outcome:
        unknown = [key for key in kwargs if key not in signature.parameters]
        if unknown:
            meant = near(unknown[0], signature.parameters)
            raise TypeError(f"{function}() has no argument {unknown[0]!r}{meant}")
        bound = dict(signature.bind(*args, **kwargs).arguments)
        return run(command, bool(bound.pop("progress", False)), bound)

    function = "_".join(python_name(word) for word in command["path"])
    call.__name__ = call.__qualname__ = function
    call.__module__ = __name__
    call.__doc__ = "\n".join(lines)
    call.__signature__ = signature  # type: ignore[attr-defined]
    return call


def _optional(parameters: list[inspect.Parameter]) -> list[inspect.Parameter]:
    seen, fixed = False, []
    for parameter in parameters:
        if parameter.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD:
            seen = seen or parameter.default is not inspect.Parameter.empty
            if seen and parameter.default is inspect.Parameter.empty:
                parameter = parameter.replace(default=None)
        fixed.append(parameter)
    return fixed


def _kind(argument: dict[str, Any]) -> str:
    """The type of an argument, as a stub writes it."""
    if argument["takes"] == 0:
        return "bool"
    one = "_Word"
    if argument["choices"]:
        one = f"Literal[{', '.join(json.dumps(choice) for choice in argument['choices'])}]"
    several = f" | Sequence[{one}]" if argument["is_list"] else ""
    changes = " | Mapping[str, _Value]" if argument["name"] == "set" else ""
    needed = not argument["is_flag"] and argument["is_required"]
    return f"{one}{several}{changes}{'' if needed else ' | None'}"


_ALL: dict[str, Callable[..., Outcome]] = {
    function.__name__: function
    for function in (
        _function(command)
        for command in json.loads(_commands())
        if command["path"][0] not in WITHOUT_NAME
    )
}
globals().update(_ALL)

__all__ = ["Folder", "Outcome", "WITHOUT_NAME", *_ALL]


def _stub() -> str:
    """``commands.pyi``: what type checkers and editors read of this module."""
    lines = [
        '"""Every command of the program ``powergs-sim`` as a function.',
        "",
        "Written by ``python -P python/stubs.py`` from what the program takes.",
        '"""',
        "",
        "import os",
        "from collections.abc import Mapping, Sequence",
        "from typing import Literal, TypeAlias",
        "",
        "from ._powergs import Trace",
        "from .program import Folder as Folder",
        "from .program import Outcome as Outcome",
        "",
        "_Word: TypeAlias = str | int | float | os.PathLike[str] | Trace",
        "_Value: TypeAlias = int | float | str | bool | Sequence[int | float | str | bool]",
        "",
        "WITHOUT_NAME: dict[str, str]",
        "",
    ]
    for name, function in _ALL.items():
        lines.append(f"def {name}(")
        starred = False
        for parameter in inspect.signature(function).parameters.values():
            if parameter.kind is inspect.Parameter.KEYWORD_ONLY and not starred:
                lines.append("    *,")
                starred = True
            default = parameter.default
            given = "" if default is inspect.Parameter.empty else f" = {default!r}"
            lines.append(f"    {parameter.name}: {parameter.annotation}{given},")
        lines += [
            ") -> Outcome:",
            f'    """{(function.__doc__ or "").splitlines()[0]}"""',
            "",
        ]
    return "\n".join(lines)

