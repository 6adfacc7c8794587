"""Random edits."""

import random
import re

TOKEN = re.compile(rb"[A-Za-z_]\w*|\.?\d[\w.]*|[^\w\s]")
LOOPS = [b"while (true) {}", b"for (;;) { status.limiter += 0u; }", b"for (uint i = 0u; i < 70000u; ++i) frame.media.x ^= i;"]


class Mutator:
    """Makes a wrong text of a right one, in one of many ways."""

    def __init__(self, seed):
        self.chance = random.Random(seed)
        self.ways = [
            self.delete_token,
            self.swap_tokens,
            self.change_token,
            self.change_token,
            self.change_token,
            self.change_number,
            self.change_number,
            self.duplicate_line,
            self.delete_line,
            self.move_line,
            self.insert_loop,
            self.cut,
            self.insert_bytes,
            self.insert_comment,
        ]

    def mutate(self, text):
        way = self.chance.choice(self.ways)
        return way.__name__, way(text)

    def token(self, text, wanted=TOKEN):
        found = list(wanted.finditer(text))
        return self.chance.choice(found) if found else re.match(b"", text)

    def replace(self, text, match, new):
        return text[: match.start()] + new + text[match.end() :]

    def delete_token(self, text):
        return self.replace(text, self.token(text), b"")

    def swap_tokens(self, text):
        a, b = sorted((self.token(text), self.token(text)), key=lambda match: match.start())
        if a.end() > b.start():
            return text
        return self.replace(self.replace(text, b, a[0]), a, b[0])

    def change_token(self, text):
        """Into another of its kind, so that much of it compiles."""
        old = self.token(text)
        kind = next(kind for kind in (rb"[A-Za-z_]\w*", rb"\.?\d[\w.]*", rb"") if re.match(kind, old[0]))
        kind = kind if kind else rb"[-+*/<>&|^=]"
        return self.replace(text, old, self.token(text, re.compile(kind))[0])

    def change_number(self, text):
        new = self.chance.choice([b"0", b"1", b"2u", b"0u", b"-1", b"0.5", b"1e30", b"0.0", b"64u", b"0xffffffffu"])
        return self.replace(text, self.token(text, re.compile(rb"\b\d[\w.]*")), new)

    def lines(self, text):
        lines = text.split(b"\n")
        return lines, self.chance.randrange(len(lines))

    def duplicate_line(self, text):
        lines, i = self.lines(text)
        return b"\n".join(lines[: i + 1] + lines[i:])

    def delete_line(self, text):
        lines, i = self.lines(text)
        return b"\n".join(lines[:i] + lines[i + 1 :])

    def move_line(self, text):
        lines, i = self.lines(text)
        lines.insert(self.chance.randrange(len(lines)), lines.pop(i))
        return b"\n".join(lines)

    def insert_loop(self, text):
        at = self.token(text, re.compile(rb"[;{]\n")).end()
        return text[:at] + self.chance.choice(LOOPS) + text[at:]

    def cut(self, text):
        return text[: self.chance.randrange(len(text) + 1)]

    def insert_bytes(self, text):
        at = self.chance.randrange(len(text) + 1)
        return text[:at] + self.chance.randbytes(self.chance.randrange(1, 40)) + text[at:]

    def insert_comment(self, text):
        at = self.token(text, re.compile(rb"\n")).end()
        return text[:at] + b"// %d\n" % self.chance.randrange(10**9) + text[at:]
