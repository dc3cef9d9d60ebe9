"""Holds the texts of the tree SOURCE to what a reader needs: `prose.py SOURCE`.

Prints file and line, and exits with status 1, for a line of Markdown above 120 characters (tables,
code and link definitions aside), a line of comment above 100, a word that stands in the place of a
noun, and a name of a source in Markdown (`walk.h`, `solver/deterministic.h`) that no file has.
"""

import re
import sys
import tokenize
from pathlib import Path

MARKDOWN_WIDTH, COMMENT_WIDTH = 120, 100
WORDS = re.compile(r"\b(likewise|so many)\b", re.IGNORECASE)
# What begins a comment, by the ending or the name of a file.
LIKE_C, LIKE_SHELL = r"(.*\s)?//|\s*(/\*|\*)", r"\s*#"
COMMENT = {".h": LIKE_C, ".cpp": LIKE_C, ".c": LIKE_C, ".js": LIKE_C, ".mjs": LIKE_C,
           ".cmake": LIKE_SHELL, "CMakeLists.txt": LIKE_SHELL, "Makefile": LIKE_SHELL}
SOURCE_NAME = re.compile(r"`((?:[a-z0-9_]+/)*[a-z0-9_]+\.(?:h|cpp|c|py|js|mjs))`")


def files_of(source):
    """The tree's own texts: nothing hidden, built or fetched."""
    for path in sorted(source.iterdir()):
        if path.is_dir():
            if not path.name.startswith((".", "build")) and path.name != "node_modules":
                yield from files_of(path)
        elif path.suffix in (".md", ".py") or path.suffix in COMMENT or path.name in COMMENT:
            yield path


def sentences(text):
    """The lines of a Markdown text that are sentences: [(number, line)]."""
    fenced = code = in_list = False
    before = ""
    for number, line in enumerate(text.splitlines(), 1):
        indent = len(line) - len(line.lstrip())
        if line.startswith("```"):
            fenced = not fenced
        elif re.match(r"\s*([-*]|\d+\.) ", line) and (indent < 4 or in_list):
            in_list, code = True, False
        elif line.strip() and indent == 0 and not before.strip():
            in_list = False
        if line.strip() and not before.strip():
            code = indent >= (7 if in_list else 4)
        before = line
        if not (fenced or code or re.match(r"\||<|\[[^]]*\]: ", line)):
            yield number, line


def comments(path, text):
    """The lines that hold a comment: [(number, line)]; of Python the docstrings, too."""
    lines = text.splitlines()
    if path.suffix != ".py":
        begin = re.compile(COMMENT.get(path.name) or COMMENT[path.suffix])
        yield from ((k, line) for k, line in enumerate(lines, 1) if begin.match(line))
        return
    with path.open("rb") as stream:
        for token in tokenize.tokenize(stream.readline):
            is_text = token.type == tokenize.STRING and token.line.lstrip().startswith('"""')
            if token.type == tokenize.COMMENT or is_text:
                for k in range(token.start[0], token.end[0] + 1):
                    yield k, lines[k - 1]


def faults(source):
    """Every fault of the tree `source`, in words."""
    paths = list(files_of(source))
    if not any(path.suffix == ".md" for path in paths):
        yield f"no texts in {source}"
    names = {"/" + path.relative_to(source).as_posix() for path in paths}
    for path in paths:
        name, text = path.relative_to(source).as_posix(), path.read_text()
        is_markdown = path.suffix == ".md"
        width = MARKDOWN_WIDTH if is_markdown else COMMENT_WIDTH
        for number, line in sentences(text) if is_markdown else comments(path, text):
            if len(line) > width:
                yield f"{name}:{number}: {len(line)} characters; allowed: {width}"
            if path != Path(__file__).resolve() and (word := WORDS.search(line)):
                yield f'{name}:{number}: "{word[1]}"; allowed: the noun that it stands for'
        if not is_markdown or path.name == "CHANGELOG.md":  # which also names files that were
            continue
        for number, line in enumerate(text.splitlines(), 1):
            for used in SOURCE_NAME.findall(line):
                if not any(known.endswith("/" + used) for known in names):
                    yield f"{name}:{number}: there is no {used}"


def main():
    found = list(faults(Path(sys.argv[1]).resolve()))
    print("\n".join(found) if found else "every text is within its lines")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
