"""Generator of Python code: a checked program as functions whose lines are those of RAPID, so that tracebacks show it.

A routine is a function, an atomic local variable a local of Python; one that somebody else may change is a list that
holds it. Before each statement stands `if flags: poll()`, where the task does what somebody else has asked of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from types import CodeType

from virtualrobot_apps.languages.core.code import compiled
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.check import Checked
from virtualrobot_apps.languages.rapid.generate_values import Values
from virtualrobot_apps.languages.rapid.symbols import Datum, ModuleScope, RoutineSymbol


def generate(checked: Checked, debugged: bool = False) -> list[CodeType]:
    """Return the code of a program, a piece for each of its modules, and last the one that sets the first values.

    A debugger may change all data of one that is `debugged`.
    """
    pieces = [Generator(checked, scope, debugged).module() for scope in checked.modules]
    return [*pieces, *(Generator(checked, scope).first_values(data) for scope, data in _by_module(checked))]


def _by_module(checked: Checked) -> Iterable[tuple[ModuleScope, list[Datum]]]:
    """Yield the data in their order, those of one module in a row together."""
    scopes = {id(scope.module.source): scope for scope in checked.modules}
    row: list[Datum] = []
    for datum in checked.data:
        if row and row[-1].source is not datum.source:
            yield scopes[id(row[-1].source)], row
            row = []
        row.append(datum)
    if row:
        yield scopes[id(row[-1].source)], row


class Generator(Values):
    """Generator of one module's code, as lines of Python with the line of RAPID that each comes from."""

    def __init__(self, checked: Checked, scope: ModuleScope, debugged: bool = False) -> None:
        """Begin without a line."""
        super().__init__(checked.types)
        self._debugged = debugged
        self.scope, self.source = scope, scope.module.source
        self._lines: list[str] = []
        self._places: list[int] = []
        self._depth, self._line, self._number = 0, 1, 0
        self._guarded = self._in_undo = self._handles = False

    def module(self) -> CodeType:
        """Return the code that defines the routines of the module."""
        for routine in self.scope.routines:
            self._routine(routine)
        return compiled(self._lines, self._places, self.source)

    def first_values(self, data: list[Datum]) -> CodeType:
        """Return the code that gives data their first values."""
        for datum in data:
            assert datum.node is not None
            self._line = self.source.line(datum.node.at)
            self._put(f"{datum.python}[:] = [{self.first_value(datum.node, datum.type)}]")
        return compiled(self._lines, self._places, self.source)

    # Lines.

    def _put(self, text: str) -> None:
        self._lines.append("    " * self._depth + text)
        self._places.append(self._line)

    def _fresh(self) -> str:
        self._number += 1
        return f"t{self._number}"

    # Routines.

    def _routine(self, routine: RoutineSymbol) -> None:
        node = routine.node
        self._line = self.source.line(node.at)
        shared = self._debugged or node.handler is not None or node.undo is not None
        self.boxed = {id(one) for one in routine.data if one.boxable and (one.referenced or shared)}
        names: list[str] = []
        for (parameter, _), datum in zip(routine.parameters, routine.data, strict=False):
            names += [f"c_{datum.python}", f"i_{datum.python}"] if parameter.mode != "in" else [datum.python]
        self._put(f"def {routine.python}({', '.join(names)}):")
        self._depth += 1
        for (parameter, _), datum in zip(routine.parameters, routine.data, strict=False):
            if parameter.mode == "in" and not datum.atomic:
                self._put(f"{datum.python} = copied({datum.python})")
            elif id(datum) in self.boxed and parameter.mode == "in":
                self._put(f"{datum.python} = [{datum.python}]")
        if node.handled:
            self._put("def handled():")
            self._put(f"    return {', '.join(map(self.value, node.handled))},")
        if node.handler is not None:
            self._handler(node)
        if node.handled:
            self._put("task.handled.append(handled)")
            self._put("try:")
            self._depth += 1
        if node.undo is not None:
            self._put("def undo():")
            self._depth += 1
            self._in_undo = True
            self._block(node.undo)
            self._in_undo = False
            self._depth -= 1
            self._put("try:")
            self._depth += 1
        self._guarded = node.handler is not None
        self._block(node.body)
        self._guarded = False
        if node.undo is not None:
            self._depth -= 1
            self._put("except BaseException:")
            self._put("    task.left(undo)")
            self._put("    raise")
        if node.handled:
            self._depth -= 1
            self._put("finally:")
            self._put("    task.handled.pop()")
        if node.kind == "func":
            self._put(f"no_value({node.name!r})")
        self._depth -= 1

    def _handler(self, node: tree.Routine) -> None:
        """Write the error handler, as a function of the fault."""
        self._put("def handler(fault):")
        self._depth += 1
        self._put(f"task.caught(fault, {'handled()' if node.handled else 'None'})")
        self._put("try:")
        self._depth += 1
        self.in_handler, self._handles = True, bool(node.handled)
        self._block(node.handler or [])
        self.in_handler = False
        self._put("unhandled(fault)")
        self._depth -= 1
        self._put("except CAUGHT as other:")
        self._depth += 1
        self._put("task.passed_on(fault, other)")
        self._depth -= 2

    def _block(self, statements: list[tree.Statement]) -> None:
        labels = [one.name.lower() for one in statements if isinstance(one, tree.Label)]
        if not labels:
            for one in statements:
                self._statement(one)
            if not statements:
                self._put("pass")
            return
        # A block with labels is a loop over what lies between them; GOTO ends a round, the next begins at its label.
        at = self._fresh()
        self._put(f"{at} = 0")
        self._put("while True:")
        self._depth += 1
        self._put("try:")
        self._depth += 1
        parts: list[list[tree.Statement]] = [[]]
        for one in statements:
            if isinstance(one, tree.Label):
                parts.append([])
            else:
                parts[-1].append(one)
        for number, part in enumerate(parts):
            self._put(f"if {at} <= {number}:")
            self._depth += 1
            for one in part:
                self._statement(one)
            self._put("pass")
            self._depth -= 1
        self._put("break")
        self._depth -= 1
        self._put("except Jump as jump:")
        self._depth += 1
        places = {label: number + 1 for number, label in enumerate(labels)}
        self._put(f"{at} = {places!r}.get(jump.label, -1)")
        self._put(f"if {at} < 0: raise")
        self._depth -= 2

    def _statement(self, node: tree.Statement) -> None:
        self._line = self.source.line(node.at)
        if not isinstance(node, tree.Data):
            self._put("if flags: poll()")
        match node:
            case tree.Assign():
                self._simple(self.assigned(node))
            case tree.Call():
                self._simple(self.called(node))
            case tree.If():
                self._if(node)
            case tree.While():
                self._while(node)
            case tree.For():
                self._for(node)
            case tree.Test():
                self._test(node)
            case tree.Jump():
                self._jump(node)
            case tree.Connect():
                holder, index = self.variable(node.interrupt)
                self._simple(f"{holder}[{index}] = task.interrupts.connect({node.target.python})")
            case tree.Goto():
                self._put(f"raise Jump({node.label.lower()!r})")
            case tree.Data():
                value = self.first_value(node, node.symbol.type)
                self._simple(f"{node.symbol.python} = {f'[{value}]' if id(node.symbol) in self.boxed else value}")
            case _:
                pass

    def _simple(self, text: str, skipped: str = "") -> None:
        """Write a statement; in a routine with an error handler within its guard. `skipped` is done after TRYNEXT."""
        if not self._guarded or self.in_handler:
            self._put(text)
            return
        self._put("while True:")
        self._depth += 1
        self._put("try:")
        self._depth += 1
        self._put(text)
        self._depth -= 1
        self._put("except CAUGHT as error:")
        self._depth += 1
        self._put("then = task.answered(handler(as_fault(error)))")
        self._put("if then is RETRY: continue")
        self._put("if then is not TRYNEXT: return then[0]")
        if skipped:
            self._put(skipped)
        self._depth -= 1
        self._put("break")
        self._depth -= 1

    def _value(self, text: str) -> str:
        """Return what names the value of an expression, computed within the guard where there is one."""
        if not self._guarded or self.in_handler:
            return text
        name = self._fresh()
        self._simple(f"{name} = {text}", f"{name} = SKIPPED")
        return name

    def _if(self, node: tree.If) -> None:
        line, otherwise = self._line, "else"
        tests = [self.value(condition) for condition, _ in node.arms]
        if self._guarded and not self.in_handler:
            chosen = self._chosen(node, tests)
            otherwise = f"elif {chosen} == 0"
            tests = [f"{chosen} == {number}" for number in range(1, len(tests) + 1)]
        for number, (condition, body) in enumerate(node.arms):
            self._line = self.source.line(condition.at) if number else line
            self._put(f"{'elif' if number else 'if'} {tests[number]}:")
            self._depth += 1
            self._block(body)
            self._depth -= 1
        if node.otherwise is not None:
            self._put(f"{otherwise}:")
            self._depth += 1
            self._block(node.otherwise)
            self._depth -= 1
        self._line = line

    def _chosen(self, node: tree.If, tests: list[str]) -> str:
        """Write which arm of IF is done, each condition within its guard; 0 is none, -1 that TRYNEXT leaves it out."""
        chosen = self._fresh()
        self._put(f"{chosen} = 0")
        for number, (condition, _) in enumerate(node.arms):
            if number:
                self._line = self.source.line(condition.at)
                self._put(f"if {chosen} == 0:")
                self._depth += 1
            value = self._value(tests[number])
            self._put(f"if {value} is SKIPPED: {chosen} = -1")
            self._put(f"elif {value}: {chosen} = {number + 1}")
            self._depth -= bool(number)
        return chosen

    def _while(self, node: tree.While) -> None:
        line = self._line
        if not self._guarded or self.in_handler:
            self._put(f"while {self.value(node.condition)}:")
            self._depth += 1
        else:
            self._put("while True:")
            self._depth += 1
            value = self._value(self.value(node.condition))
            self._put(f"if {value} is SKIPPED or not {value}: break")
        self._put("if flags: poll()")
        self._block(node.body)
        self._line = line
        self._depth -= 1

    def _for(self, node: tree.For) -> None:
        line = self._line
        bounds = [self.value(node.first), self.value(node.last)]
        if node.step is not None:
            bounds.append(self.value(node.step))
        first, last, step, name = self._fresh(), self._fresh(), self._fresh(), node.symbol.python
        self._simple(
            f"{first}, {last}, {step} = task.bounds({', '.join(bounds)})", f"{first} = {step} = 1.0; {last} = 0.0"
        )
        self._put(f"{name} = {first}")
        self._put(f"while {name} <= {last} if {step} > 0 else {name} >= {last}:")
        self._depth += 1
        self._put("if flags: poll()")
        self._block(node.body)
        self._line = line
        self._put(f"{name} += {step}")
        self._depth -= 1

    def _test(self, node: tree.Test) -> None:
        line, tested = self._line, self._fresh()
        cases = [[self.value(one) for one in values] for values, _ in node.cases]
        same = [" or ".join(f"{tested} == {one}" for one in values) for values in cases]
        choice = " or ".join([*(f"({one}) and {number}" for number, one in enumerate(same, 1)), "0"])
        chosen = self._fresh()
        self._simple(f"{tested} = {self.value(node.value)}; {chosen} = {choice}", f"{chosen} = -2")
        self._put(f"if {chosen} == -2: pass")
        for number, (_, body) in enumerate(node.cases, 1):
            self._put(f"elif {chosen} == {number}:")
            self._depth += 1
            self._block(body)
            self._depth -= 1
        if node.otherwise is not None:
            self._put("else:")
            self._depth += 1
            self._block(node.otherwise)
            self._depth -= 1
        self._line = line

    def _jump(self, node: tree.Jump) -> None:
        value = "None" if node.value is None else self.value(node.value)
        match node.word:
            case "raise" if self._in_undo and node.value is None:
                self._put("return")
            case "return":
                self._simple(f"return ({value},)" if self.in_handler else f"return {value}")
            case "raise":
                passed = f"task.passed_by(fault, {self._handles})"
                self._simple(passed if self.in_handler else f"raised({value})")
            case "exit":
                self._put("exited()")
            case "retry":
                self._put("return RETRY")
            case _:
                self._put("return TRYNEXT")
