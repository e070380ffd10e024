"""Collects the pages of the site from the repository: a hook of MkDocs.

Every document stays where it is, with its path as its address, so links between documents hold. Two pages are made here:
the options of all commands, from the texts that tests compare with the program, and the reference of the Python package.
A source file that a document refers to becomes a page, too.
"""

from __future__ import annotations

import posixpath
import re
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mkdocs.structure.files import File, Files

if TYPE_CHECKING:
    from collections.abc import Iterator

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE))

import python_reference  # noqa: E402

DOCUMENTS = [
    *(f"{name}.md" for name in ("README", "ARCHITECTURE", "CHANGELOG", "CONVENTIONS", "REFERENCES")),
    *("benches/README.md", "python/README.md", "python/lerobot_camera_fingervision/README.md"),
    *sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")),
]
LANGUAGES = {".py": "python", ".rs": "rust"}
HELP = ROOT / "crates/cli/tests/help"
LINK = re.compile(r"\[([^\]]*)\]\(([^)#:\s]+)(#[^)\s]*)?\)")
HELP_WIDTH = 88
BEFORE_SENTENCE = re.compile(r"\s*(?:\S+(?: \S+)* {2,})?")
ITEM = re.compile(r"\s*([-*]|\d+\.)\s")


def on_files(files: Files, *, config: Any) -> Files:
    """Adds all pages and pictures."""
    for name in DOCUMENTS:
        files.append(File.generated(config, name, content=_document(name)))
    for path in sorted((ROOT / "docs/figures").iterdir()):
        files.append(File.generated(config, path.relative_to(ROOT).as_posix(), abs_src_path=str(path)))
    for name in sorted({source for document in DOCUMENTS for source in _sources(document)}):
        files.append(File.generated(config, f"{name}.md", content=_source_page(name)))
    files.append(File.generated(config, "docs/commands.md", content=_commands()))
    files.append(File.generated(config, "docs/python-reference.md", content=python_reference.page(ROOT)))
    return files


def _document(name: str) -> str:
    """A document as the site needs it: lists begin after an empty line, and links have titles, not names of files."""
    sources = set(_sources(name))

    def linked(link: re.Match[str]) -> str:
        target = _resolved(name, link[2])
        text = _title(target) if link[1].endswith(".md") and (ROOT / target).is_file() else link[1]
        return f"[{text}]({link[2]}{'.md' if target in sources else ''}{link[3] or ''})"

    lines: list[str] = []
    is_code = False
    for line in (ROOT / name).read_text(encoding="utf-8").splitlines():
        is_code ^= line.startswith("```")
        before = lines[-1] if lines else ""
        if not is_code and ITEM.match(line) and before and before[0] != " " and not ITEM.match(before):
            lines.append("")
        lines.append(line if is_code else LINK.sub(linked, line))
    return "\n".join(lines) + "\n"


def _sources(name: str) -> Iterator[str]:
    """The files that a document refers to and that are neither documents nor pictures."""
    for link in LINK.finditer((ROOT / name).read_text(encoding="utf-8")):
        path = _resolved(name, link[2])
        if not path.endswith((".md", ".png")) and (ROOT / path).is_file():
            yield path


def _title(name: str) -> str:
    """The first heading of a document."""
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    return next((line.removeprefix("# ") for line in lines if line.startswith("# ")), name)


def _resolved(document: str, link: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(document), link))


def _source_page(name: str) -> str:
    path = ROOT / name
    language = LANGUAGES.get(path.suffix, "text")
    return f"# {path.name}\n\n`{name}`\n\n```{language}\n{path.read_text(encoding='utf-8').rstrip()}\n```\n"


def _commands() -> str:
    """The help of every command, the program itself first."""
    names = sorted((path.stem for path in HELP.glob("*.txt")), key=lambda name: (name != "fingervision", name))
    parts = ["# All commands and options\n\n`fingervision help COMMAND` prints these texts.\n"]
    for name in names:
        title = name if name == "fingervision" else f"fingervision {name.replace('-', ' ')}"
        text = "\n".join(map(_wrapped, (HELP / f"{name}.txt").read_text(encoding="utf-8").splitlines()))
        parts.append(f"## {title}\n\n```text\n{text}\n```\n")
    return "\n".join(parts)


def _wrapped(line: str) -> str:
    """A line of a help text on several lines; a sentence beside a name stays beside it."""
    before = BEFORE_SENTENCE.match(line)
    indent = " " * (before.end() if before else 0)
    return textwrap.fill(line, HELP_WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
