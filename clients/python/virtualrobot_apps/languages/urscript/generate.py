"""Generator of Python code: a checked script as generators whose lines are those of URScript.

A function is a generator, which yields where its thread's turn in a cycle of the controller is over: None where it
waits for the next cycle, True where it has used up its turn by computing. So threads switch where they wait, and
nowhere else.
"""

from __future__ import annotations

from types import CodeType

from virtualrobot_apps.languages.core.code import compiled
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.check import Checked, statements_of
from virtualrobot_apps.languages.urscript.table import BUILTINS, Builtin

MAIN = "program"
"""Name of the generator that is the program itself."""
_WORDS = {
    "break": "break",
    "continue": "continue",
    "pass": "pass",
    "halt": "task.halt()",
    # Threads switch where they wait alone, so that nobody comes between what a section has.
    "enter_critical": "pass",
    "exit_critical": "pass",
}
_BINARY = {"+": "add", "-": "subtract", "*": "multiply", "/": "divide", "%": "remainder"}


def generate(checked: Checked, debugged: bool = False) -> CodeType:
    """Return the code that defines the program and its functions; `debugged`: it looks around before each statement."""
    return Generator(checked, debugged).code()


class Generator:
    """Generator of one script's code, as lines of Python with the line of URScript that each comes from.

    In code that is debugged a function's own variables are in a dictionary, `own`, where others can set them.
    """

    def __init__(self, checked: Checked, debugged: bool = False) -> None:
        """Begin without a line."""
        self._debugged = debugged
        self._checked, self._source = checked, checked.script.source
        self._lines: list[str] = []
        self._places: list[int] = []
        self._depth, self._line = 0, 1
        self._own: set[str] = set()

    def code(self) -> CodeType:
        """Return the code."""
        main = self._checked.script.main
        self._function(MAIN, main, set())
        for function in self._checked.functions.values():
            self._function(f"f_{function.name}", function, self._checked.own[function.name])
        return compiled(self._lines, self._places, self._source)

    def _put(self, text: str) -> None:
        self._lines.append("    " * self._depth + text)
        self._places.append(self._line)

    def _function(self, python: str, function: tree.Function, own: set[str]) -> None:
        self._own, self._line = own, self._source.line(function.at)
        self._put(f"def {python}({', '.join(f'v_{one.name}' for one in function.parameters)}):")
        self._depth += 1
        set_here = {
            one.target.name
            for one in statements_of(function.body)
            if isinstance(one, tree.Assign) and isinstance(one.target, tree.Name)
        }
        if names := sorted(set_here - own):
            self._put(f"global {', '.join(f'g_{name}' for name in names)}")
        self._turn()
        if self._debugged:
            self._put(f"own = Own({', '.join(f'v_{one.name}=v_{one.name}' for one in function.parameters)})")
        self._block(function.body)
        self._depth -= 1

    def _turn(self) -> None:
        self._put("task.left -= 1")
        self._put("if task.left < 0: yield True")

    def _block(self, body: list[tree.Statement]) -> None:
        self._put("pass")
        for one in body:
            self._line = self._source.line(one.at)
            if self._debugged and not isinstance(one, tree.Function):
                self._put("task.look()")
            self._statement(one)

    def _statement(self, node: tree.Statement) -> None:
        match node:
            case tree.Assign():
                self._assign(node)
            case tree.Do():
                self._put(self.value(node.value))
            case tree.If():
                for number, (condition, arm) in enumerate(node.arms):
                    self._line = self._source.line(condition.at)
                    self._put(f"{'elif' if number else 'if'} {self.truth(condition)}:")
                    self._inner(arm)
                if node.otherwise is not None:
                    self._put("else:")
                    self._inner(node.otherwise)
            case tree.While():
                self._put(f"while {self.truth(node.condition)}:")
                self._depth += 1
                self._turn()
                if self._debugged:
                    self._put("task.look()")
                self._depth -= 1
                self._inner(node.body)
            case tree.Return():
                self._put("return" if node.value is None else f"return {self.own_value(node.value)}")
            case tree.Word():
                self._put(_WORDS[node.word])
            case tree.OfThread():
                self._put(f"yield from task.{node.word}({self.value(node.handle)})")

    def _inner(self, body: list[tree.Statement]) -> None:
        self._depth += 1
        self._block(body)
        self._depth -= 1

    def _assign(self, node: tree.Assign) -> None:
        value = self.own_value(node.value)
        match node.target:
            case tree.Name(_, name):
                self._put(f"{self._variable(name)} = {value}")
            case tree.Element(_, of, indices):
                self._put(f"put({', '.join((self.value(of), value, *map(self.value, indices)))})")
            case tree.Component(_, of, name):
                self._put(f"put_component({self.value(of)}, {value}, {name!r})")

    # Values.

    def _variable(self, name: str) -> str:
        if name not in self._own:
            return f"g_{name}"
        return f"own['v_{name}']" if self._debugged else f"v_{name}"

    def within(self, own: set[str]) -> Generator:
        """Return it as it is within a function that has variables of its own, for expressions there."""
        self._own = own
        return self

    def own_value(self, node: tree.Expression) -> str:
        """Return the text of a value that nobody else has: a copy where it is that of a variable."""
        text = self.value(node)
        return f"copied({text})" if isinstance(node, tree.Name | tree.Element | tree.Component) else text

    def truth(self, node: tree.Expression) -> str:
        """Return the text of a condition."""
        if isinstance(node, tree.Truth) or (isinstance(node, tree.Unary) and node.operator == "not"):
            return self.value(node)
        if isinstance(node, tree.Binary) and node.operator not in _BINARY:
            return self.value(node)
        return f"truth({self.value(node)})"

    def value(self, node: tree.Expression) -> str:
        """Return the text of a value."""
        match node:
            case tree.Number() | tree.Text() | tree.Truth():
                return repr(node.value)
            case tree.Name():
                return self._variable(node.name)
            case tree.Items():
                items = ", ".join(map(self.own_value, node.items))
                return f"pose({items})" if node.pose else f"[{items}]"
            case tree.Element():
                return f"element({', '.join(map(self.value, (node.of, *node.indices)))})"
            case tree.Component():
                return f"component({self.value(node.of)}, {node.name!r})"
            case tree.Call():
                return self._call(node)
            case tree.Run():
                function = self._checked.functions[node.call.name]
                return f"task.start({function.name!r}, f_{function.name}({self._arguments(node.call, function)}))"
            case tree.Unary():
                return self._unary(node)
            case tree.Binary():
                return self._binary(node)

    def _unary(self, node: tree.Unary) -> str:
        if node.operator == "not":
            return f"(not {self.truth(node.operand)})"
        if isinstance(node.operand, tree.Number):
            return f"({node.operator}{node.operand.value!r})"
        return f"negative({self.value(node.operand)})" if node.operator == "-" else self.value(node.operand)

    def _binary(self, node: tree.Binary) -> str:
        operator = node.operator
        if operator in ("and", "or"):
            return f"({self.truth(node.left)} {operator} {self.truth(node.right)})"
        if operator == "xor":
            return f"({self.truth(node.left)} != {self.truth(node.right)})"
        left, right = self.value(node.left), self.value(node.right)
        if operator in _BINARY:
            return f"{_BINARY[operator]}({left}, {right})"
        return f"({left} {operator} {right})" if operator in ("==", "!=") else f"order({operator!r}, {left}, {right})"

    def _call(self, node: tree.Call) -> str:
        if node.name == "struct":
            return f"Struct({', '.join(f'{one.name}={self.own_value(one.value)}' for one in node.arguments)})"
        function = self._checked.functions.get(node.name)
        if function is not None:
            return f"(yield from f_{node.name}({self._arguments(node, function)}))"
        builtin = BUILTINS.get(node.name)
        if builtin is None:
            return f"task.lacks({node.name!r})"
        given = self._arguments(node, builtin)
        call = f"b_{node.name}(task{', ' if given else ''}{given})"
        return f"(yield from {call})" if builtin.waits else call

    def _arguments(self, node: tree.Call, called: tree.Function | Builtin) -> str:
        """Return the arguments in the order of the parameters, those that are left out with their values."""
        names = [one.name for one in called.parameters]
        given = {one.name or names[number]: one.value for number, one in enumerate(node.arguments)}
        # Functions of the language change no argument; those of the script do.
        told = self.own_value if isinstance(called, tree.Function) else self.value
        values = []
        for one in called.parameters:
            value = given.get(one.name, one.value)
            assert value is not None
            missing = isinstance(called, Builtin) and value is one.value and isinstance(value, tree.Name)
            values.append("None" if missing else told(value))
        return ", ".join(values)
