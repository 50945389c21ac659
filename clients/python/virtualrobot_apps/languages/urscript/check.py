"""Check of URScript: names, calls and places of statements, before anything runs.

Scopes are those of the manual (Universal Robots, "The URScript Programming Language", scoping rules): what is assigned
on the first level of the program is global, and so is what `global` declares; within a function a name is its own with
`local` or as a parameter, else the global one where there is one, else its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, did_you_mean
from virtualrobot_apps.languages.urscript import builtin, tree
from virtualrobot_apps.languages.urscript.parser import Script
from virtualrobot_apps.languages.urscript.table import BUILTINS, Builtin, lacking_names

builtin.load()

LOOPS = 15
"""Number of loops that may be within each other."""


@dataclass(slots=True)
class Checked:
    """A script and what its names mean.

    Attributes:
        script: the script.
        functions: its functions and threads, by name.
        globals: names of its global variables.
        own: names of each function's own variables, by the function's name; its parameters are among them.
    """

    script: Script
    functions: dict[str, tree.Function] = field(default_factory=dict)
    globals: set[str] = field(default_factory=set)
    own: dict[str, set[str]] = field(default_factory=dict)


def check(script: Script, diagnostics: Diagnostics) -> Checked:
    """Return what the names of a script mean; all faults go to `diagnostics`."""
    return Checker(script, diagnostics).check()


def statements_of(body: Sequence[tree.Statement]) -> Iterator[tree.Statement]:
    """Yield the statements of a body, those of its blocks too, but not those of functions in it."""
    for one in body:
        yield one
        match one:
            case tree.If():
                for _, arm in one.arms:
                    yield from statements_of(arm)
                yield from statements_of(one.otherwise or [])
            case tree.While():
                yield from statements_of(one.body)


class Checker:
    """Check of one script."""

    def __init__(self, script: Script, diagnostics: Diagnostics) -> None:
        """Begin with the script alone."""
        self._script, self._diagnostics = script, diagnostics
        self._found = Checked(script)
        self._function = script.main
        self._own: set[str] = set()

    def check(self) -> Checked:
        """Look at all."""
        main, found = self._script.main, self._found
        if main.parameters:
            self._tell(main.parameters[0].at, f"the program {main.name!r} can't have parameters")
        self._collect(main)
        for one in statements_of(main.body):
            if isinstance(one, tree.Assign) and isinstance(one.target, tree.Name):
                found.globals.add(one.target.name)
        for function in found.functions.values():
            names = {one.name for one in function.parameters}
            for one in statements_of(function.body):
                if isinstance(one, tree.Assign) and isinstance(one.target, tree.Name) and one.scope != "global":
                    name = one.target.name
                    if one.scope == "local" or name not in found.globals:
                        names.add(name)
            found.own[function.name] = names
        self._look(main, set())
        for function in found.functions.values():
            self._look(function, found.own[function.name])
        return found

    def _tell(self, at: int, message: str) -> None:
        self._diagnostics.add(self._script.source, at, message)

    def _collect(self, function: tree.Function) -> None:
        """Enter the functions within a function, and the variables that `global` declares."""
        for one in statements_of(function.body):
            if isinstance(one, tree.Function):
                if one.name in self._found.functions:
                    self._tell(one.at, f"{one.name!r} is defined twice")
                elif one.name in BUILTINS:
                    self._tell(one.at, f"{one.name!r} is a function of the language, and can't be defined anew")
                self._found.functions[one.name] = one
                if one.kind == "sec":
                    self._tell(one.at, "a secondary program (sec) can't stand in another one")
                self._collect(one)
            elif isinstance(one, tree.Assign) and one.scope == "global" and isinstance(one.target, tree.Name):
                self._found.globals.add(one.target.name)

    def _look(self, function: tree.Function, own: set[str]) -> None:
        self._function, self._own = function, own
        names: set[str] = set()
        optional = False
        for parameter in function.parameters:
            if parameter.name in names:
                self._tell(parameter.at, f"two parameters of {function.name!r} are called {parameter.name!r}")
            names.add(parameter.name)
            if parameter.value is not None:
                self._value(parameter.value)
            elif optional:
                self._tell(parameter.at, f"{parameter.name!r} needs a value, since the parameter before it has one")
            optional = optional or parameter.value is not None
        self._block(function.body, 0)

    def _block(self, body: list[tree.Statement], loops: int) -> None:
        """Look at statements that are within so many loops."""
        for one in body:
            match one:
                case tree.Assign():
                    self._value(one.value)
                    if not isinstance(one.target, tree.Name):
                        self._value(one.target)
                case tree.Do():
                    self._value(one.value, alone=True)
                case tree.If():
                    for condition, arm in one.arms:
                        self._value(condition)
                        self._block(arm, loops)
                    self._block(one.otherwise or [], loops)
                case tree.While():
                    self._value(one.condition)
                    if loops == LOOPS:
                        self._tell(one.at, f"more than {LOOPS} loops are within each other here")
                    self._block(one.body, loops + 1)
                case tree.Return():
                    if one.value is not None:
                        self._value(one.value)
                case tree.Word(word="break" | "continue"):
                    if not loops:
                        self._tell(one.at, f"{one.word!r} stands in loops alone")
                case tree.OfThread():
                    self._value(one.handle)

    def _value(self, node: tree.Expression, alone: bool = False) -> None:
        match node:
            case tree.Name():
                self._name(node)
            case tree.Items():
                for one in node.items:
                    self._value(one)
            case tree.Element():
                self._value(node.of)
                for one in node.indices:
                    self._value(one)
            case tree.Component():
                self._value(node.of)
            case tree.Unary():
                self._value(node.operand)
            case tree.Binary():
                self._value(node.left)
                self._value(node.right)
            case tree.Run():
                called = self._found.functions.get(node.call.name)
                if called is None or called.kind != "thread":
                    threads = [name for name, one in self._found.functions.items() if one.kind == "thread"]
                    self._tell(
                        node.call.at, f"there is no thread {node.call.name!r}{did_you_mean(node.call.name, threads)}"
                    )
                else:
                    self._arguments(node.call, called)
            case tree.Call():
                self._call(node)

    def _name(self, node: tree.Name) -> None:
        found = self._found
        if node.name in self._own or node.name in found.globals:
            return
        if node.name in found.functions or node.name in BUILTINS:
            self._tell(node.at, f"{node.name!r} is a function, which is called with parentheses")
            return
        if node.name == "p":
            self._tell(node.at, "'p' is never given a value; a pose p[x, y, z, rx, ry, rz] has 6 numbers")
            return
        known = sorted(self._own | found.globals)
        self._tell(node.at, f"{node.name!r} is never given a value{did_you_mean(node.name, known)}")

    def _call(self, node: tree.Call) -> None:
        called = self._found.functions.get(node.name)
        if called is not None:
            if called.kind == "thread":
                self._tell(node.at, f"{node.name!r} is a thread, which is started by 'run {node.name}()'")
            self._arguments(node, called)
        elif node.name == "struct":
            for one in node.arguments:
                self._value(one.value)
                if not one.name:
                    self._tell(one.at, "a struct has components with names, as struct(a=1)")
        elif node.name in BUILTINS:
            self._arguments(node, BUILTINS[node.name])
        else:
            for one in node.arguments:
                self._value(one.value)
            if node.name not in lacking_names():
                known = sorted(BUILTINS.keys() | self._found.functions.keys())
                self._tell(node.at, f"there is no function {node.name!r}{did_you_mean(node.name, known)}")

    def _arguments(self, node: tree.Call, called: tree.Function | Builtin) -> None:
        names = [one.name for one in called.parameters]
        takes = f"it takes {', '.join(names)}" if names else "it takes none"
        given: set[str] = set()
        named = False
        for number, one in enumerate(node.arguments):
            self._value(one.value)
            if not one.name and named:
                self._tell(one.at, f"an argument without a name stands before those of {node.name!r} with names")
                return
            named = named or bool(one.name)
            if not one.name and number >= len(names):
                self._tell(one.at, f"{node.name!r} gets {len(node.arguments)} arguments; {takes}")
                return
            name = one.name or names[number]
            if name not in names:
                self._tell(one.at, f"{node.name!r} has no parameter {name!r}{did_you_mean(name, names)}; {takes}")
                return
            elif name in given:
                self._tell(one.at, f"{node.name!r} gets {name!r} twice")
            given.add(name)
        for one in called.parameters:
            if one.value is None and one.name not in given:
                self._tell(node.at, f"{node.name!r} lacks {one.name!r}; {takes}")
                return
