"""The page on the Python package: every public name with its signature and documentation, from the sources."""

from __future__ import annotations

import ast
import inspect
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    Definition = ast.ClassDef | ast.FunctionDef

PACKAGE = "python/package/fingervision"
SOURCES = ("_native.pyi", "_commands.py", "_errors.py", "lerobot/_export.py")
CHAPTERS = {
    "Tracking": ("open", "Readings", "Reading", "Tracker", "FlowEstimator", "Flow"),
    "Profiles and cameras": ("Profile", "cameras", "CameraInfo"),
    "Recordings": ("Recording", "Frames", "Frame", "export_lerobot"),
    "Simulation": ("simulate", "scenes", "Simulation", "SimulatedFrame"),
    "Commands": ("command", "pattern", "calibrate_camera", "calibrate_depth", "calibrate_gel", "evaluate"),
    "Errors and warnings": (
        *("Error", "ArgumentError", "ArgumentTypeError", "ProfileError", "SceneError", "SourceError", "NotFoundError"),
        *("CameraError", "RecordingError", "ClosedError", "TrackError", "FlowError", "FieldError", "CommandError"),
        *("UsageError", "NoteWarning"),
    ),
}
CONSTANTS = ("FLAGS", "__version__")
TYPES = {
    r"\b_Floats\b": "NDArray[float32]",
    r"\b_Mask\b": "NDArray[bool]",
    r"\b_Pixels\b": "NDArray[uint8 | uint16]",
    r"\b_Path\b": "str | PathLike",
    r"\b_Field\b": "str",
    r"\b_Image\b": "ArrayLike",
    r"\b_Channels\b": "Literal['rgb', 'bgr']",
    r"\bnpt\.|\bnp\.|\bfingervision\.": "",
}


def page(root: Path) -> str:
    """The page, in Markdown."""
    found: dict[str, Definition] = {}
    for source in SOURCES:
        tree = ast.parse((root / PACKAGE / source).read_text(encoding="utf-8"))
        found |= {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    module = ast.parse((root / PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    _expect_all(module)
    parts = ["# Python reference", _documentation(module)]
    parts.append("`FLAGS` explains the flags of a reading, which [files.md](files.md#flags) lists, `__version__` is the version.")
    for chapter, names in CHAPTERS.items():
        parts.append(f"## {chapter}")
        parts += [part for name in names for part in _described(found[name])]
    return "\n\n".join(parts) + "\n"


def _expect_all(module: ast.Module) -> None:
    """Fails if a public name has no chapter."""
    assigned = next(node.value for node in module.body if isinstance(node, ast.Assign))
    missing = set(ast.literal_eval(assigned)) - {name for names in CHAPTERS.values() for name in names} - set(CONSTANTS)
    if missing:
        raise ValueError(f"names without a chapter in python_reference.py: {', '.join(sorted(missing))}")


def _described(node: Definition) -> list[str]:
    """A function or a class with its attributes and methods."""
    if isinstance(node, ast.FunctionDef):
        module = "fingervision.lerobot" if node.name == "export_lerobot" else "fingervision"
        return [f"### {node.name}", _signature(node, f"{module}.{node.name}"), _documentation(node)]
    members = [item for item in node.body if isinstance(item, ast.FunctionDef)]
    attributes = [item for item in members if _is_attribute(item)]
    parts = [f"### {node.name}"]
    makers = [item for item in members if item.name == "__new__"]
    parts += [_signature(item, f"fingervision.{node.name}", returns=False) for item in makers]
    bases = [base for base in map(ast.unparse, node.bases) if base != "Exception"]
    parts += [f"Also a `{'`, `'.join(bases)}`."] if bases else []
    parts.append(_documentation(node))
    if attributes:
        rows = [f"| `{item.name}` | `{_type(item.returns)}` | {_cell(_documentation(item))} |" for item in attributes]
        parts.append("\n".join(["| attribute | type | meaning |", "| --- | --- | --- |", *rows]))
    for item in members:
        if not item.name.startswith("_") and not _is_attribute(item):
            parts += [f"#### {node.name}.{item.name}", _signature(item, item.name), _documentation(item)]
    return parts


def _is_attribute(item: ast.FunctionDef) -> bool:
    return any(isinstance(decorator, ast.Name) and decorator.id == "property" for decorator in item.decorator_list)


def _signature(node: ast.FunctionDef, name: str, *, returns: bool = True) -> str:
    """The call as code, a line for each argument if it is long."""
    arguments = ast.arguments(**{field: getattr(node.args, field) for field in ast.arguments._fields})
    arguments.args = [item for item in arguments.args if item.arg not in ("self", "cls")]
    text = _plain(ast.unparse(arguments))
    result = f" -> {_plain(ast.unparse(node.returns))}" if returns and node.returns else ""
    if len(name) + len(text) + len(result) > 80:
        stub = ast.FunctionDef("f", arguments, [], [])
        listed = _listed(stub.args)
        text = "".join(f"\n    {_plain(item)}," for item in listed) + "\n"
    return f"```python\n{name}({text}){result}\n```"


def _listed(arguments: ast.arguments) -> list[str]:
    """Each argument with its type and default."""
    plain = [*arguments.posonlyargs, *arguments.args]
    defaults: list[ast.expr | None] = [None] * (len(plain) - len(arguments.defaults))
    listed = [_argument(*pair) for pair in zip(plain, [*defaults, *arguments.defaults], strict=True)]
    if arguments.vararg:
        listed.append(f"*{_argument(arguments.vararg, None)}")
    elif arguments.kwonlyargs:
        listed.append("*")
    return listed + [_argument(*pair) for pair in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)]


def _argument(argument: ast.arg, default: ast.expr | None) -> str:
    kind = f": {ast.unparse(argument.annotation)}" if argument.annotation else ""
    return argument.arg + kind + (f" = {ast.unparse(default)}" if default else "")


def _type(node: ast.expr | None) -> str:
    return _plain(ast.unparse(node)).replace("|", "\\|") if node else ""


def _plain(text: str) -> str:
    """A signature with the names of types that a reader knows."""
    for pattern, name in TYPES.items():
        text = re.sub(pattern, name, text)
    return text


def _documentation(node: ast.Module | Definition) -> str:
    return inspect.cleandoc(ast.get_docstring(node) or "")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
