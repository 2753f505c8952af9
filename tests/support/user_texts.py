"""What users read, out of the repository's files: sentences in sources, help texts, schemas, documents.

`masked(name, text)` has the length and the lines of `text`. What no user reads is NUL; the gap between two literals
that the compiler joins is GAP, so that a phrase is found across it. A literal without a space is a name, not a sentence.
"""
import fnmatch
import re

NUL, GAP = "\0", "\1"
SPACE = rf"[\s{GAP}]+"  # between two words of a phrase

DOCUMENTS = ("README.md", "examples/*.md", "schemas/*.md", ".github/*.md", "tests/bench/README.md", "tests/README.md",
             "passes/README.md", "tests/golden/help/*.txt", "examples/*.yaml", "examples/*.yml", "examples/*/run",
             "examples/images/*", "compiler/package/changelog")
PRODUCT = ("compiler/", "passes/", "formats/", "examples/")

C_STRING = r'"((?:[^"\\\n]|\\.)*)"'
LITERALS = {
    ".cpp": re.compile(r'#[ \t]*include[^\n]*|//[^\n]*|/\*.*?\*/|R"([^(\s]*)\((?P<raw>.*?)\)\1"'
                       r"|(?<!\w)'(?:[^'\\\n]|\\.)+'|" + C_STRING.replace("(", "(?P<text>", 1), re.S),
    ".js": re.compile(r"""//[^\n]*|/\*.*?\*/|'(?P<single>(?:[^'\\\n]|\\.)*)'|"(?P<text>(?:[^"\\\n]|\\.)*)\""""
                      r"|`(?P<raw>(?:[^`\\]|\\.)*)`", re.S),
    ".py": re.compile(r'"""(?P<raw>.*?)"""|#[^\n]*|' r"""'(?P<single>(?:[^'\\\n]|\\.)*)'"""
                      r'|"(?P<text>(?:[^"\\\n]|\\.)*)"', re.S),
    ".json": re.compile(r'"(?:description|title)"\s*:\s*"(?P<text>(?:[^"\\\n]|\\.)*)"'),
}
for other, same in ((".h", ".cpp"), (".c", ".cpp"), (".cmake", ".py")):
    LITERALS[other] = LITERALS[same]
# Names in a document: code within a line, and where a link leads to. A block of code is read.
NAMES = re.compile(r"(?<!`)(`{1,2})(?!`)(?:(?!\n\s*\n).)+?(?<!`)\1(?!`)|\]\([^)\s]*\)|<https?:[^>]*>"
                   r"|^\[[^\]\n]*\]: \S+", re.S | re.M)


def blank(text):
    return re.sub(r"[^\n]", NUL, text)


def without_escapes(text):
    return re.sub(r"\\.", "  ", text, flags=re.S)


def of_document(text):
    return NAMES.sub(lambda found: blank(found.group()), text)


def of_source(text, literals):
    """Texts in quotes; those with nothing but white space between them are one."""
    parts, end, begin_of_text, last = [], 0, None, None

    def close():
        # A name: blank after all.
        if begin_of_text is not None and not re.search(r"\s", "".join(parts[begin_of_text:]).replace(GAP, "").strip()
                                                       .replace("\n", "")):
            parts[begin_of_text:] = [blank(part) for part in parts[begin_of_text:]]

    for found in literals.finditer(text):
        group = next((name for name in ("text", "raw", "single") if found.groupdict().get(name) is not None), None)
        if group is None:
            continue
        gap = text[end:found.start(group)]
        is_joined = last is not None and not re.sub(r"//[^\n]*", "", gap[1:-1]).strip()
        if not is_joined:
            close()
        parts.append(re.sub(r"[^\n]", GAP, gap) if is_joined else blank(gap))
        if not is_joined:
            begin_of_text = len(parts)
        parts.append(without_escapes(found.group(group)))
        end, last = found.end(group), group
    close()
    parts.append(blank(text[end:]))
    return "".join(parts)


def is_read(name):
    """Whether users read some of a file."""
    ending = "." + name.rsplit(".", 1)[-1]
    return (any(fnmatch.fnmatchcase(name, pattern) for pattern in DOCUMENTS)
            or (ending in LITERALS and (name.startswith(PRODUCT) or (ending == ".json" and name.startswith("schemas/")))))


def masked(name, text):
    """The text of a file with all but what users read blanked."""
    if name.endswith(".md"):
        return of_document(text)
    if any(fnmatch.fnmatchcase(name, pattern) for pattern in DOCUMENTS):
        return text
    return of_source(text, LITERALS["." + name.rsplit(".", 1)[-1]])
