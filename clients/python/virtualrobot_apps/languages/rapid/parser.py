"""Parser of RAPID: recursive descent, written by hand, that tells a fault with its place and goes on after it.

A fault in a statement costs that statement, one in a declaration that declaration; what comes after is parsed as ever.
"""

from __future__ import annotations

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.words import Failed
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.expressions import ExpressionParser

_DECLARED = {"proc", "func", "trap", "local", "task", "var", "pers", "const", "record", "alias"}
_ENDS = frozenset(
    """endproc endfunc endtrap endif elseif else endfor endwhile endtest case default backward error undo endmodule end
    proc func trap module""".split()
)
"""Words before which the statements of a block are over."""

_STRAY = {
    **dict.fromkeys(("endif", "elseif", "else"), "IF"),
    **dict.fromkeys(("endtest", "case", "default"), "TEST"),
    "endfor": "FOR",
    "endwhile": "WHILE",
}
"""Words that belong to what has begun before, in the same routine."""
_BEGINS = frozenset("if for while test return raise exit retry trynext goto connect var pers const".split())
"""Reserved words that begin a statement: what is wrong before one on another line does not reach it."""


def parse(source: Source, diagnostics: Diagnostics) -> list[tree.Module]:
    """Return the modules of a source; all faults go to `diagnostics`."""
    return Parser(source, diagnostics).file()


class Parser(ExpressionParser):
    """Parser of modules, declarations and statements."""

    def file(self) -> list[tree.Module]:
        """Parse all modules."""
        if self.kind == "end":
            self.diagnostics.add(self.source, self.at, "MODULE is expected here, not the end of the file")
        modules = []
        while self.kind != "end":
            try:
                modules.append(self.module())
            except Failed:
                self._skip({"module"})
        return modules

    def module(self) -> tree.Module:
        """Parse a module."""
        at = self.at
        self.eat("module", "MODULE")
        module = tree.Module(at, self.name("the module's name"), [], [], self.source)
        if self.take("("):
            while True:
                module.attributes.append(self.name("a module's attribute"))
                if not self.take(","):
                    break
            self.eat(")")
        while not self.take("endmodule"):
            if self.kind in ("end", "module"):
                self.diagnostics.add(self.source, self.at, f"ENDMODULE of {module.name!r} is missing")
                break
            begin = self.next
            try:
                module.declarations.append(self.declaration())
            except Failed:
                self.depth = 0
                self.next = max(self.next, begin + 1)
                self._skip({*_DECLARED, "endmodule", "module"})
        return module

    def _skip(self, kinds: set[str]) -> None:
        """Go on to a word of these kinds, or the end."""
        while self.kind not in kinds and self.kind != "end":
            self.next += 1

    def declaration(self) -> tree.Declaration:
        """Parse a declaration of a module."""
        scope = self.values[self.next].lower() if self.kind in ("local", "task") else ""
        self.next += bool(scope)
        at, kind = self.at, self.kind
        if kind in ("var", "pers", "const"):
            return self.data(scope)
        if kind == "record":
            self.next += 1
            record = tree.Record(at, scope, self.name("the record's name"), [])
            while not self.take("endrecord"):
                type_name = self.name("a type, or ENDRECORD")
                record.components.append((type_name, self.name("the name of a component")))
                self.semicolon()
            return record
        if kind == "alias":
            self.next += 1
            type_name = self.name("a type")
            alias = tree.Alias(at, scope, self.name("the new name of the type"), type_name)
            self.semicolon()
            return alias
        if kind in ("proc", "func", "trap"):
            return self.routine(scope)
        self.fail("a declaration (VAR, PERS, CONST, RECORD, ALIAS, PROC, FUNC, TRAP) or ENDMODULE")

    def data(self, scope: str) -> tree.Data:
        """Parse a declaration of data."""
        at, storage = self.at, self.kind
        self.next += 1
        type_name = self.name("a type")
        data = tree.Data(at, scope, storage, type_name, self.name("the name of the data"), [], None)
        if self.take("{"):
            data.sizes = self.expressions("}")
        if self.take(":="):
            data.value = self.expression()
        self.semicolon()
        return data

    def routine(self, scope: str) -> tree.Routine:
        """Parse a routine; a name that the header lacks or a wrong header costs the header alone."""
        at, kind = self.at, self.kind
        self.next += 1
        routine = tree.Routine(at, scope, kind, "", "", [], [])
        try:
            routine.result = self.name("the type of the result") if kind == "func" else ""
            routine.name = self.name("the routine's name")
            if kind != "trap":
                self.eat("(", "'(' and the parameters")
                routine.parameters = self.parameters(")")
                self.next += 1
        except Failed:
            line = self.source.line(self.at)
            while self.kind != "end" and self.source.line(self.at) == line:
                self.next += 1
        routine.body = self.block()
        while self.kind in ("backward", "error", "undo"):
            part = self.kind
            self.next += 1
            if part == "error" and self.take("("):
                routine.handled = self.expressions(")")
            statements = self.block()
            if part == "backward":
                routine.backward = statements
            elif part == "error":
                routine.handler = statements
            else:
                routine.undo = statements
        if not self.take(f"end{kind}"):
            found = self.values[self.next] if self.kind == "end" else repr(self.values[self.next])
            said = f"END{kind.upper()} of {routine.name!r} is missing before {found}"
            self.diagnostics.add(self.source, self.at, said)
            self.next += self.kind.startswith("end") and self.kind not in ("end", "endmodule")
        return routine

    def block(self) -> list[tree.Statement]:
        """Parse the statements of a routine or of its handler; an end of what has not begun is told and left out."""
        found = self.statements()
        while self.kind in _STRAY:
            begun, value = _STRAY[self.kind], self.values[self.next]
            self.diagnostics.add(self.source, self.at, f"{value!r} stands here without its {begun}")
            self.next += 1
            found += self.statements()
        return found

    def parameters(self, end: str) -> list[tree.Parameter]:
        """Parse parameters up to the sign that ends them, which is left."""
        found: list[tree.Parameter] = []
        choice = 0
        while self.kind != end:
            if choice and not self.take(",") and self.kind != "\\":
                self.fail(f"',' or {end!r}")
            choice += 1
            optional = self.take("\\")
            while True:
                at, mode = self.at, "in"
                if self.kind in ("inout", "var", "pers"):
                    mode = self.kind
                    self.next += 1
                type_name = self.name("the type of a parameter")
                one = tree.Parameter(at, mode, type_name, self.name("the name of a parameter"), 0, optional, choice)
                if self.take("{"):
                    one.dimensions = 1
                    self.eat("*")
                    while self.take(","):
                        self.eat("*")
                        one.dimensions += 1
                    self.eat("}")
                found.append(one)
                if not self.take("|"):
                    break
        return found

    def statements(self) -> list[tree.Statement]:
        """Parse the statements of a block."""
        found: list[tree.Statement] = []
        depth = self.depth
        while self.kind not in _ENDS:
            begin = self.next
            try:
                found.extend(self.statement())
            except Failed:
                self.depth = depth
                self.next = max(self.next, begin + 1)
                while self.kind not in _ENDS and self.kind != ";" and not self._begins_statement():
                    self.next += 1
                self.take(";")
        return found

    def _begins_statement(self) -> bool:
        """Return whether the next word begins a statement on a line of its own."""
        line = self.source.line
        return self.kind in _BEGINS and line(self.ends[self.next - 1]) != line(self.at)

    def statement(self) -> list[tree.Statement]:
        """Parse a statement; an empty one is none."""
        kind, at = self.kind, self.at
        if kind == "name":
            if self.kinds[self.next + 1] == ":":
                self.next += 2
                return [tree.Label(at, self.values[self.next - 2])]
            return [self._assignment_or_call()]
        if kind in ("local", "task", "var", "pers", "const"):
            scope = kind if kind in ("local", "task") else ""
            self.next += bool(scope)
            if self.kind not in ("var", "pers", "const"):
                self.fail("VAR, PERS or CONST")
            return [self.data(scope)]
        parse = getattr(self, f"_{kind}", None) if kind.isalpha() else None
        if parse is not None:
            self.next += 1
            self.deepen()
            found = parse(at)
            self.depth -= 1
            return [found]
        if self.take("%"):
            late = self.expression()
            self.eat("%")
            call = tree.Call(at, "", self.arguments(";"), late)
            self.semicolon()
            return [call]
        if self.take(";"):
            return []
        self.fail("a statement")

    def _assignment_or_call(self) -> tree.Statement:
        at, value = self.at, self.values[self.next]
        self.next += 1
        target = self.parts(tree.Name(at, value))
        if self.take(":="):
            assigned = tree.Assign(at, target, self.expression())
            self.semicolon()
            return assigned
        if not isinstance(target, tree.Name):
            self.fail("':='")
        if self.kind in (":", "="):
            self.fail("':='")
        call = tree.Call(at, value, self.arguments(";"))
        self.semicolon()
        return call

    def _if(self, at: int) -> tree.Statement:
        condition = self.expression()
        if not self.take("then"):
            return tree.If(at, [(condition, self.statement())], None, compact=True)
        arms = [(condition, self.statements())]
        otherwise = None
        while self.take("elseif"):
            condition = self.expression()
            self.eat("then", "THEN")
            arms.append((condition, self.statements()))
        if self.take("else"):
            otherwise = self.statements()
        self.eat("endif", "a statement or ENDIF")
        return tree.If(at, arms, otherwise)

    def _for(self, at: int) -> tree.Statement:
        name = self.name("the name of the loop's variable")
        self.eat("from", "FROM")
        first = self.expression()
        self.eat("to", "TO")
        last = self.expression()
        step = self.expression() if self.take("step") else None
        self.eat("do", "DO")
        body = self.statements()
        self.eat("endfor", "a statement or ENDFOR")
        return tree.For(at, name, first, last, step, body)

    def _while(self, at: int) -> tree.Statement:
        condition = self.expression()
        self.eat("do", "DO")
        body = self.statements()
        self.eat("endwhile", "a statement or ENDWHILE")
        return tree.While(at, condition, body)

    def _test(self, at: int) -> tree.Statement:
        test = tree.Test(at, self.expression(), [], None)
        while True:
            if self.take("case"):
                values = self.expressions(":")
                test.cases.append((values, self.statements()))
            elif self.take("default"):
                self.eat(":")
                test.otherwise = self.statements()
            else:
                self.eat("endtest", "CASE, DEFAULT or ENDTEST")
                return test

    def _jump(self, at: int) -> tree.Statement:
        word = self.kinds[self.next - 1]
        ended = self.kind == ";" or self.source.line(self.ends[self.next - 1]) != self.source.line(self.at)
        jump = tree.Jump(at, word, None if ended else self.expression())
        self.semicolon()
        return jump

    _return = _raise = _exit = _retry = _trynext = _jump

    def _goto(self, at: int) -> tree.Statement:
        goto = tree.Goto(at, self.name("a label"))
        self.semicolon()
        return goto

    def _connect(self, at: int) -> tree.Statement:
        begin = self.at
        interrupt = self.parts(tree.Name(begin, self.name("the name of an interrupt")))
        self.eat("with", "WITH")
        connect = tree.Connect(at, interrupt, self.name("the name of a trap"))
        self.semicolon()
        return connect
