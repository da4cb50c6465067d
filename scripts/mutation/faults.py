# SPDX-License-Identifier: Apache-2.0
"""Small faults in C++ sources: where they can be made, and the source in which each can be switched on while the program runs."""
import random
import re
import subprocess
import zlib

MODULES = ("io", "archive", "remote", "field")
EQUIVALENT = "mutate: equivalent"   # comment on a line whose faults change nothing, with the reason
SWAPS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&", "+": "-", "-": "+", "*": "/", "/": "*",
         "+=": "-=", "-=": "+="}
# A comment, a text or a character.
LITERAL = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
STATEMENT = re.compile(r"(?<=[;{}])\n( +)([\w:.>\[\]()*-]+ ?(?:\(|=|\+=|-=|\+\+)[^;{}]*;)(?= *(?:~+)?\n)")
NOT_REMOVED = re.compile(r"(return|throw|const|constexpr|auto|using|static|if|for|while|switch|case|break|continue|template|friend|struct)\b")
FUNCTION = re.compile(r"^(?!namespace|struct|class|enum|extern|template|using|#|})([\w:<>,&* ]*?)\b[\w:~]+\([^;{}]*\)[\w ]*\{\n", re.MULTILINE)
# Words before an expression that do not belong to it.
BEFORE = re.compile(r"\b(return|throw|case|else|do|co_return|goto)$")


def masked(text):
    """The text with the characters of comments, texts and characters replaced by '~', of the same length."""
    return LITERAL.sub(lambda m: re.sub(r"[^\n]", "~", m.group()), text)


def closing(text, at):
    """Place of the bracket that closes the one at `at`, or -1."""
    depth = 0
    for n in range(at, len(text)):
        depth += (text[n] in "([{") - (text[n] in ")]}")
        if depth == 0:
            return n
    return -1


def is_assignment(code, at):
    return code[at] == "=" and code[at - 1] not in "<>=!" and code[at + 1] != "="


def ends_expression(code, at):
    """Whether a character outside of brackets separates expressions: ; , ? = and the colon of a label or a condition."""
    return code[at] in ";,?" or is_assignment(code, at) or (code[at] == ":" and code[at - 1] != ":" and code[at + 1] != ":")


def expression_around(code, start, end):
    """Smallest whole expression that contains [start, end): from one bracket, separator or assignment to the next."""
    depth, left = 0, start
    while left > 0:
        one = code[left - 1]
        if one == "}" and code[left] == "\n":   # end of a block
            break
        depth += (one in ")]}") - (one in "([{")
        if depth < 0 or (depth == 0 and one not in "([{" and ends_expression(code, left - 1)) or (depth == 0 and BEFORE.search(code[max(0, left - 12):left])):
            break
        left -= 1
    while code[left].isspace():
        left += 1
    depth, right = 0, end
    while right < len(code):
        one = code[right]
        depth += (one in "([{") - (one in ")]}")
        if depth < 0 or (depth == 0 and one not in ")]}" and ends_expression(code, right)):
            break
        right += 1
    while code[right - 1].isspace():
        right -= 1
    return left, right


class Fault:
    """The characters [start, end) of a source are replaced by `new`. `span`: what is written twice to make it a choice at run time."""

    def __init__(self, path, text, start, end, new, kind, refusal=False, span=None):
        self.path, self.start, self.end, self.new, self.kind, self.refusal = path, start, end, new, kind, refusal
        self.span = span or (start, end)
        self.line = text.count("\n", 0, start) + 1
        self.old = " ".join(text[start:end].split())
        self.id = zlib.crc32(f"{path}:{start}:{kind}:{new}".encode()) & 0x7fffffff
        self.result = None   # name of the case that failed, "time limit", "crash", "" for survived, None: not tried

    def describe(self):
        shorten = lambda words: words if len(words) <= 60 else words[:57] + "..."
        if self.kind == "statement removed":
            return f"{self.kind}: `{shorten(self.old)}`"
        if self.kind == "early return":
            return f"{self.kind}: `{self.new.strip()}`"
        return f"{self.kind}: `{shorten(self.old)}` to `{shorten(' '.join(self.new.split()))}`"


def refusals(root, text):
    """Expression for the beginning of a statement that refuses: throw, and calls of functions that do not return."""
    headers = [root / "src" / name for name in re.findall(r'#include "(.*)"', text)]
    texts = [text] + [header.read_text(encoding="utf-8") for header in headers if header.is_file()]
    names = {name for one in texts for name in re.findall(r"\[\[noreturn\]\] [\w:<> ]*?(\w+)\(", one)}
    return re.compile(r"[\s{~]*(throw\b|(" + "|".join(sorted(names) or ["throw"]) + r")\()")


def faults_of(root, path, text, lines=None):
    """All faults of a source. `lines`: numbers of the permitted lines; None: all."""
    code, found, refuses, rows = masked(text), [], refusals(root, text), text.split("\n")

    def add(start, end, new, kind, refusal=False, span=None):
        fault = Fault(path, text, start, end, new, kind, refusal, span)
        row = rows[fault.line - 1]
        if (lines is None or fault.line in lines) and EQUIVALENT not in row and not row.lstrip().startswith(("#", "static_assert", "namespace")):
            found.append(fault)

    for m in re.finditer(r"(?<= )(<=|>=|==|!=|&&|\|\||\+=|-=|[<>+*/-])(?= |\n)", code):
        # Formatted code has blanks around binary operators, and none in templates and pointers.
        kind = "comparison" if m.group()[0] in "<>=!" else "logic" if m.group() in ("&&", "||") else "arithmetic"
        span = expression_around(code, m.start(), m.end())
        if m.group() == "+" and "~" in code[span[0]:span[1]]:   # texts that are joined
            continue
        if m.group() in ("+=", "-="):   # the whole statement
            before = re.search(r"[\w:.>\[\]()*-]+ $", code[:m.start()])
            span = (before.start() if before else m.start(), span[1])
        add(m.start(), m.end(), SWAPS[m.group()], kind, span=span)
    for m in re.finditer(r"(?<![\w.'])(\d+)(?![\w.'])", code):
        add(m.start(), m.end(), str(int(m.group()) + 1), "constant", span=expression_around(code, m.start(), m.end()))
    for m in re.finditer(r"\b(true|false)\b", code):
        add(m.start(), m.end(), "false" if m.group() == "true" else "true", "constant", span=expression_around(code, m.start(), m.end()))
    for m in re.finditer(r"\bif (?:constexpr )?\(", code):
        if "constexpr" in m.group():
            continue
        end = closing(code, m.end() - 1)
        start = m.end() + code[m.end():end].rfind(";") + 1
        if end < 0 or re.search(r"[\w>] = ", code[start:end]):   # a declaration as a condition
            continue
        start += len(code[start:end]) - len(code[start:end].lstrip())
        refusal = bool(refuses.match(code, end + 1))
        add(start, end, "false", "refusal removed" if refusal else "condition never", refusal)
        add(start, end, f"!({text[start:end]})", "condition negated")
    for m in STATEMENT.finditer(code):
        if not NOT_REMOVED.match(m.group(2)):
            add(m.start(2), m.end(2), "static_cast<void>(0);", "statement removed")
    for m in FUNCTION.finditer(code):
        add(m.end() - 1, m.end() - 1, " return;" if m.group(1).strip().endswith("void") else " return {};", "early return")
    return sorted(found, key=lambda one: (one.start, one.kind))


def switched(text, faults):
    """The source with all these faults, each switched by simplexseg_fault(its number); lines keep their numbers.

    An expression E with the fault F becomes (simplexseg_fault(N) ? (F) : (E)), a condition a call of simplexseg_condition(), a statement
    and an early return the body of an if. A fault whose expression overlaps another without lying in it is left out.
    """
    spans = {}
    for fault in faults:
        spans.setdefault(fault.span, []).append(fault)
    plain = LITERAL.sub(lambda m: re.sub(r"[^\n]", " ", m.group()) if m.group()[0] == "/" else m.group(), text)
    order = sorted(spans, key=lambda span: (span[0], -span[1]))

    def render(start, end, inner):
        """The characters [start, end) with the spans `inner`, which lie in it."""
        out, at = [], start
        while inner:
            first, *rest = inner
            nested = [span for span in rest if span[1] <= first[1]]
            inner = [span for span in rest if span[0] >= first[1]]
            out += [text[at:first[0]], around(first, nested)]
            at = first[1]
        return "".join(out) + text[at:end]

    def around(span, nested):
        start, end = span
        body = render(start, end, nested)
        of = {}
        for fault in spans[span]:
            of.setdefault(fault.kind, []).append(fault)
        if "early return" in of:
            return f" if (simplexseg_fault({of['early return'][0].id})) {of['early return'][0].new.strip()}" + body
        if "statement removed" in of:
            return f"if (!simplexseg_fault({of['statement removed'][0].id})) " + body
        choices = [one for kind in of for one in of[kind] if kind in ("comparison", "logic", "arithmetic", "constant")]
        if choices:
            faulty = "".join(f"simplexseg_fault({one.id}) ? ({plain[start:one.start]}{one.new}{plain[one.end:end]}) : " for one in choices)
            body = "(" + faulty.replace("\n", " ") + f"({body}))"
        never, negated = of.get("refusal removed") or of.get("condition never"), of.get("condition negated")
        if never or negated:
            numbers = f"{never[0].id if never else 0}, {negated[0].id if negated else 0}"
            body = f"simplexseg_condition({numbers}, static_cast<bool>({body}))"
        return body

    return render(0, len(text), order)


def changed_lines(root, base):
    """Lines of the sources of MODULES that differ from a commit: path to a set of numbers, or None for all."""
    folders = [f"src/{module}" for module in MODULES]
    diff = subprocess.run(["git", "diff", "-U0", "--no-color", base, "--", *folders], cwd=root, capture_output=True, text=True, check=True).stdout
    lines, path = {}, None
    for row in diff.splitlines():
        if row.startswith("+++ "):
            path = row[6:] if row.endswith(".cpp") else None
        elif path and (m := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", row)):
            first, count = int(m.group(1)), int(m.group(2) or 1)
            lines.setdefault(path, set()).update(range(first, first + count))
    new = subprocess.run(["git", "ls-files", "--others", "--exclude-standard", "--", *folders], cwd=root, capture_output=True, text=True, check=True)
    for path in new.stdout.split():
        if path.endswith(".cpp"):
            lines[path] = None
    return lines


def spread(faults):
    """The faults in a fixed random order, refusals first, one source after the other."""
    by_path = {}
    for fault in faults:
        by_path.setdefault(fault.path, []).append(fault)
    chooser = random.Random(1)
    for group in by_path.values():
        chooser.shuffle(group)
        group.sort(key=lambda one: not one.refusal)
    rows = sorted(((not by_path[path][n].refusal, n, path) for path, group in by_path.items() for n in range(len(group))))
    return [by_path[path][n] for _, n, path in rows]
