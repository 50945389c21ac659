"""Parser of URScript: recursive descent, written by hand, that tells a fault with its place and goes on after it.

A fault in a statement costs that line; what comes after is parsed as ever.
"""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import DEEPEST, Failed, Words
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.expressions import ExpressionParser

_ENDS = frozenset(("end", "elif", "else", "end of file"))
"""Words before which the statements of a block are over."""
_BEGINS = frozenset(
    """break continue def enter_critical exit_critical global halt if join kill local pass return sec thread
    while""".split()
)
"""Reserved words that begin a statement, and go on with none."""
_FUNCTIONS = frozenset(("def", "thread", "sec"))
_OPENS = _FUNCTIONS | {"if", "while"}
"""Words that an `end` belongs to."""


@dataclass(frozen=True, slots=True)
class Script:
    """A script: the program that it defines, or its lines as one.

    Attributes:
        main: the program; its kind is sec where it runs beside the one that runs already.
        source: the text.
    """

    main: tree.Function
    source: Source


def parse(source: Source, diagnostics: Diagnostics, words: Words | None = None) -> Script:
    """Return the script of a source; all faults go to `diagnostics`. `words` are those of the source, if known."""
    return Parser(source, diagnostics, words).script()


class Parser(ExpressionParser):
    """Parser of programs and statements."""

    def script(self) -> Script:
        """Parse a whole text: one program, or lines one after the other, which are a program without a name."""
        if self.kind == "end of file":
            self.diagnostics.add(self.source, self.at, "a program (def, sec) or a statement is expected here")
        lines = self.block()
        while self.kind != "end of file":
            self._stray()
            lines += self.block()
        functions = [one for one in lines if isinstance(one, tree.Function) and one.kind != "thread"]
        if functions and lines[0] is functions[0]:
            main, *others = lines
            assert isinstance(main, tree.Function)
            for other in others:
                if not _starts(other, main.name):
                    self.diagnostics.add(self.source, other.at, f"nothing can stand after the end of {main.name!r}")
            return Script(main, self.source)
        return Script(tree.Function(0, "def", "line", [], lines), self.source)

    def _stray(self) -> None:
        """Tell of an end of what has not begun, and leave its line out."""
        self.diagnostics.add(self.source, self.at, f"{self.values[self.next]!r} stands here without its begin")
        self._skip_line()

    def _skip_line(self) -> None:
        while self.kind not in ("newline", "end of file"):
            self.next += 1
        self.take("newline")

    def _skip_statement(self, begin: int) -> None:
        """Leave out the statement that begins at a word, and all that is within it, however deep."""
        self.next, level = begin, 0
        while self.kind != "end of file":
            kind = self.kind
            self.next += 1
            level += (kind in _OPENS) - (kind == "end")
            if level <= 0 and kind in ("end", "newline"):
                return

    def block(self) -> list[tree.Statement]:
        """Parse the statements of a block up to the word that ends it, which is left."""
        found: list[tree.Statement] = []
        while self.kind not in _ENDS:
            if self.take("newline"):
                continue
            begin, depth = self.next, self.depth
            try:
                self.deepen()
                found.append(self.statement())
                self.depth = depth
            except Failed:
                deepest, self.depth = self.depth > DEEPEST, depth
                found += self._still_assigned(begin)
                if deepest:
                    self._skip_statement(begin)
                    continue
                opens = self.kinds[begin] in ("while", "if")
                self.next = max(self.next, begin + 1)
                self._skip_line()
                if opens and self._headless(found):
                    continue
        return found

    def _still_assigned(self, begin: int) -> list[tree.Statement]:
        """Return an assignment in place of one with a fault, so that its variable is known."""
        scope = self.kinds[begin] if self.kinds[begin] in ("local", "global") else ""
        name = begin + bool(scope)
        if self.kinds[name : name + 2] != ["name", "="]:
            return []
        at = self.starts[name]
        return [tree.Assign(at, scope, tree.Name(at, self.values[name]), tree.Number(at, 0))]

    def _headless(self, found: list[tree.Statement]) -> bool:
        """Parse the body of what has a fault in its header, so that its `end` is not taken for another one's."""
        found += self.block()
        while self.kind in ("elif", "else"):
            self._skip_line()
            found += self.block()
        return self.take("end")

    def line_ends(self) -> None:
        """Take the end of a statement's line; a word that ends a block or begins a statement may stand on it, too."""
        if self.kind not in _ENDS and self.kind not in _BEGINS:
            self.eat("newline", "the end of the line")

    def assigned(self) -> tree.Expression:
        """Parse the value of an assignment, which may stand on the next line."""
        self.take("newline")
        return self.expression()

    def statement(self) -> tree.Statement:
        """Parse a statement."""
        at, kind = self.at, self.kind
        if kind in _FUNCTIONS:
            return self.function()
        self.next += 1
        match kind:
            case "if":
                return self._if(at)
            case "while":
                condition = self.expression()
                self.eat(":")
                return tree.While(at, condition, self._closed("while", at))
            case "return":
                value = None if self.kind in ("newline", *_ENDS) else self.expression()
                found: tree.Statement = tree.Return(at, value)
            case "break" | "continue" | "pass" | "halt" | "enter_critical" | "exit_critical":
                found = tree.Word(at, kind)
            case "join" | "kill":
                found = tree.OfThread(at, kind, self.expression())
            case "local" | "global":
                where, name = self.at, self.name("the name of a variable")
                self.eat("=")
                found = tree.Assign(at, kind, tree.Name(where, name), self.assigned())
            case "run" if self.values[self.next] == "program" and self.kinds[self.next + 1] == "newline":
                # Old scripts end with these words; the program runs without them.
                self.next += 1
                found = tree.Word(at, "pass")
            case _:
                self.next -= 1
                found = self._assignment_or_call(at)
        self.line_ends()
        return found

    def _assignment_or_call(self, at: int) -> tree.Statement:
        if self.kind not in ("name", "run", "(", "[", "number", "text", "True", "False", "not", "-", "+"):
            self.fail("a statement")
        value = self.expression()
        if self.kind == "=":
            if not isinstance(value, tree.Name | tree.Element | tree.Component):
                self.diagnostics.add(self.source, at, "only a variable, its element or component can be assigned to")
                raise Failed
            self.next += 1
            return tree.Assign(at, "", value, self.assigned())
        if not isinstance(value, tree.Call | tree.Run):
            self.fail("'='" if isinstance(value, tree.Name | tree.Element | tree.Component) else "a call")
        return tree.Do(at, value)

    def _closed(self, word: str, at: int) -> list[tree.Statement]:
        """Parse the statements of a block and its `end`, whose absence is told where the block begins."""
        body = self.block()
        while self.kind in ("elif", "else"):
            self._stray()
            body += self.block()
        if not self.take("end"):
            self.diagnostics.add(self.source, at, f"this {word!r} has no 'end'")
        return body

    def _if(self, at: int) -> tree.Statement:
        condition = self.expression()
        self.eat(":")
        arms = [(condition, self.block())]
        otherwise: list[tree.Statement] | None = None
        while self.kind in ("elif", "else") and otherwise is None:
            if self.take("elif"):
                condition = self.expression()
                self.eat(":")
                arms.append((condition, self.block()))
            else:
                self.next += 1
                self.eat(":")
                otherwise = self.block()
        last = self._closed("if", at)
        (arms[-1][1] if otherwise is None else otherwise).extend(last)
        return tree.If(at, arms, otherwise)

    def function(self) -> tree.Function:
        """Parse a function, a thread or a program; a wrong header costs the header alone."""
        at, kind = self.at, self.kind
        self.next += 1
        function = tree.Function(at, kind, self.name(f"the name of this {kind!r}"))
        try:
            self.eat("(", "'(' and the parameters")
            function.parameters = self.parameters(")")
            self.eat(":")
        except Failed:
            self._skip_line()
        function.body = self._closed(kind, at)
        return function

    def parameters(self, end: str) -> list[tree.Parameter]:
        """Parse parameters, and the word that ends them."""
        found: list[tree.Parameter] = []
        if self.take(end):
            return found
        while True:
            at, name = self.at, self.name("the name of a parameter")
            value = self.expression() if self.take("=") else None
            found.append(tree.Parameter(at, name, value))
            if not self.take(","):
                self.eat(end, f"',' or {end!r}")
                return found


def _starts(node: tree.Statement, name: str) -> bool:
    """Return whether what stands after a program only says that it shall run."""
    if isinstance(node, tree.Word):
        return node.word == "pass"
    call = node.value if isinstance(node, tree.Do) else None
    return isinstance(call, tree.Call) and call.name == name and not call.arguments
