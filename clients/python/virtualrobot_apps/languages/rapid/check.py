"""Check of RAPID: declarations, statements and names of all modules, without moving anything."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, did_you_mean
from virtualrobot_apps.languages.rapid import tree
from virtualrobot_apps.languages.rapid.meaning import Meaning
from virtualrobot_apps.languages.rapid.symbols import Datum, ModuleScope, RoutineSymbol, Symbol, Use
from virtualrobot_apps.languages.rapid.types import ANY, BOOL, NUM, STRING, Type, Types, no_array


@dataclass(frozen=True, slots=True)
class Checked:
    """A program without faults: modules, data in the order of their first values, types, and the signals it names."""

    modules: list[ModuleScope]
    data: list[Datum]
    types: Types
    uses: dict[str, Use]
    globals: dict[str, Symbol]


def check(
    modules: list[tree.Module],
    diagnostics: Diagnostics,
    signals: Iterable[str] = (),
    common: frozenset[str] = frozenset(),
) -> Checked:
    """Return what modules mean together; all faults go to `diagnostics`.

    `signals` are names that the world has, `common` those of persistents that other tasks have, too, in small letters.
    """
    return Check(diagnostics, signals).program(modules, common)


class Check(Meaning):
    """Check of a program, module by module."""

    def program(self, modules: list[tree.Module], common: frozenset[str] = frozenset()) -> Checked:
        """Check all modules; `common` are names of persistents that other tasks have, too."""
        self._common = common
        scopes = [ModuleScope(module) for module in modules]
        self._routine: RoutineSymbol | None = None
        self._in_handler = self._in_undo = False
        self._counter = 0
        self._labels: list[set[str]] = []
        self._order: list[Datum] = []
        self._modules_known(scopes)
        for scope in scopes:
            self._types_of(scope)
        self._records_known(scopes)
        for scope in scopes:
            self._declared(scope)
        data: list[Datum] = []
        for scope in scopes:
            self.source, self.scopes = scope.module.source, [scope.names]
            for one in scope.module.declarations:
                if isinstance(one, tree.Data):
                    self._data_value(one, one.symbol.type)
                    data.append(one.symbol)
        self.scopes = []
        for scope in scopes:
            for routine in scope.routines:
                self._check_routine(scope, routine)
        self.resolve_signals()
        for datum in data:
            self._ordered(datum, [])
        return Checked(scopes, self._order, self.types, self.uses, self.globals)

    # Declarations.

    def _modules_known(self, scopes: list[ModuleScope]) -> None:
        seen: dict[str, str] = {}
        for scope in scopes:
            module = scope.module
            self.source = module.source
            if module.name.lower() in seen:
                self.error(module.at, f"there is another module {module.name!r}, in {seen[module.name.lower()]}")
            seen[module.name.lower()] = module.source.file
            for attribute in module.attributes:
                known = ("SYSMODULE", "NOVIEW", "NOSTEPIN", "VIEWONLY", "READONLY")
                if attribute.upper() not in known:
                    said = f"{attribute!r} is no attribute of modules{did_you_mean(attribute, known)}"
                    self.error(module.at, f"{said}; there are {', '.join(known)}")

    def _types_of(self, scope: ModuleScope) -> None:
        self.source = scope.module.source
        for one in scope.module.declarations:
            if isinstance(one, tree.Record | tree.Alias):
                lower = one.name.lower()
                if self.types.resolved(lower) is not None:
                    self.error(one.at, f"there is a type {one.name!r} already")
                elif isinstance(one, tree.Record):
                    self.types.records[lower] = [(type_name.lower(), name) for type_name, name in one.components]
                else:
                    self.types.aliases[lower] = one.type.lower()

    def _records_known(self, scopes: list[ModuleScope]) -> None:
        for scope in scopes:
            self.source = scope.module.source
            for one in scope.module.declarations:
                if isinstance(one, tree.Alias):
                    self.type_named(one.type, one.at)
                if not isinstance(one, tree.Record):
                    continue
                for type_name, name in one.components:
                    self.type_named(type_name, one.at)
                    if self._holds(type_name, one.name, ()):
                        self.error(one.at, f"the record {one.name!r} would hold itself, by {name!r}")

    def _holds(self, type_name: str, wanted: str, seen: tuple[str, ...]) -> bool:
        resolved = self.types.resolved(type_name)
        if resolved is None or resolved in seen:
            return False
        if resolved == wanted.lower():
            return True
        parts = self.types.components(resolved)
        return any(self._holds(inner, wanted, (*seen, resolved)) for inner, _ in parts)

    def _declared(self, scope: ModuleScope) -> None:
        """Enter the data and routines of a module."""
        self.source = scope.module.source
        self.scopes = [scope.names]
        for one in scope.module.declarations:
            if isinstance(one, tree.Data):
                python = f"m{self._count()}_{one.name.lower()}"
                kind = self.type_named(one.type, one.at, len(one.sizes))
                symbol: Symbol = Datum(one.name, kind, one.storage, python, True, node=one, source=self.source)
                symbol.common = is_common(one) and one.name.lower() in self._common
                one.symbol = symbol
            elif isinstance(one, tree.Routine) and one.name:
                symbol = self._routine_symbol(scope, one)
            else:
                continue
            names = scope.names if one.scope == "local" else self.globals
            lower = one.name.lower()
            if lower in scope.names or (names is self.globals and lower in self.globals):
                self.error(one.at, f"{one.name!r} is declared twice")
            else:
                names[lower] = symbol
        self.scopes = []

    def _count(self) -> int:
        self._counter += 1
        return self._counter

    def _routine_symbol(self, scope: ModuleScope, node: tree.Routine) -> RoutineSymbol:
        symbol = RoutineSymbol(node, scope, f"r{self._count()}_{node.name.lower()}")
        if node.kind == "func":
            symbol.result = self.type_named(node.result, node.at)
        seen: set[str] = set()
        for one in node.parameters:
            kind = self.type_named(one.type, one.at, one.dimensions)
            if one.name.lower() in seen:
                self.error(one.at, f"two parameters of {node.name!r} are called {one.name!r}")
            seen.add(one.name.lower())
            if kind.name == "switch" and not one.optional:
                self.error(one.at, f"the switch {one.name!r} must be optional: \\{one.type} {one.name}")
            symbol.parameters.append((one, kind))
            python = f"v{self._count()}_{one.name.lower()}"
            storage = "in" if one.mode == "in" else "pers" if one.mode == "pers" else "inout"
            symbol.data.append(Datum(one.name, kind, storage, python, optional=one.optional))
        scope.routines.append(symbol)
        return symbol

    def _data_value(self, node: tree.Data, kind: Type) -> None:
        for size in node.sizes:
            self.expect(size, NUM, "the size of an array")
        if len(node.sizes) > 3:
            self.error(node.at, f"an array has at most 3 dimensions, and {node.name!r} has {len(node.sizes)}")
        counts = [size.value for size in node.sizes if isinstance(size, tree.Number)]
        if len(counts) == len(node.sizes) and (why := no_array(counts)):
            self.error(node.at, why)
        if node.value is not None:
            self.may_change = node.storage != "const"
            self.expect(node.value, kind, f"the value of {node.name!r}")
            self.may_change = False
        elif node.storage == "const":
            self.error(node.at, f"the constant {node.name!r} needs a value")

    def _ordered(self, datum: Datum, under: list[Datum]) -> None:
        """Put a datum behind those that its first value names."""
        if datum in self._order or datum.node is None:
            return
        if datum in under:
            self.source = datum.source or self.source
            self.error(datum.node.at, f"the first value of {datum.name!r} needs itself")
            return
        expressions = [*datum.node.sizes, *([datum.node.value] if datum.node.value is not None else [])]
        for name in _names_in(expressions):
            if isinstance(name.symbol, Datum) and name.symbol.node is not None:
                self._ordered(name.symbol, [*under, datum])
        self._order.append(datum)

    # Routines.

    def _check_routine(self, scope: ModuleScope, routine: RoutineSymbol) -> None:
        self.source, self._routine = scope.module.source, routine
        names: dict[str, Symbol] = {datum.name.lower(): datum for datum in routine.data}
        self.scopes = [scope.names, names]
        node = routine.node
        for one in node.handled:
            self.expect(one, NUM, "the number of an error")
        for part in (node.body, node.handler, node.undo, node.backward):
            self._in_handler, self._in_undo = part is node.handler, part is node.undo
            if part is not None:
                self._block(part)
        self._routine, self.scopes = None, []

    def _block(self, statements: list[tree.Statement]) -> None:
        labels: set[str] = set()
        for one in statements:
            if isinstance(one, tree.Label):
                if one.name.lower() in labels:
                    self.error(one.at, f"there is a label {one.name!r} already")
                labels.add(one.name.lower())
        self._labels.append(labels)
        for one in statements:
            self._statement(one)
        self._labels.pop()

    def _statement(self, node: tree.Statement) -> None:
        match node:
            case tree.Assign():
                self._assign(node)
            case tree.Call():
                self._procedure(node)
            case tree.If():
                for condition, body in node.arms:
                    self.expect(condition, BOOL, "the condition of IF")
                    self._block(body)
                if node.otherwise is not None:
                    self._block(node.otherwise)
            case tree.While():
                self.expect(node.condition, BOOL, "the condition of WHILE")
                self._block(node.body)
            case tree.For():
                self._for(node)
            case tree.Test():
                self._test(node)
            case tree.Jump():
                self._jump(node)
            case tree.Goto():
                if not any(node.label.lower() in labels for labels in self._labels):
                    known = [label for labels in self._labels for label in labels]
                    self.error(node.at, f"there is no label {node.label!r} here{did_you_mean(node.label, known)}")
            case tree.Connect():
                self._connect(node)
            case tree.Data():
                self._local(node)
            case tree.Label():
                pass

    def _assign(self, node: tree.Assign) -> None:
        wanted = self.type_of(node.target)
        self.expect(node.value, wanted, "what is assigned")
        found = self.root(node.target)
        if found is None:
            if wanted != ANY or not isinstance(node.target, tree.Name):
                self.error(node.target.at, "only a variable can be assigned to")
            return
        if found.storage in ("const", "loop", "signal"):
            kinds = {"const": "a constant", "loop": "the variable of a loop", "signal": "a signal; use SetDO"}
            self.error(node.target.at, f"{found.name!r} can't be assigned to: it is {kinds[found.storage]}")
        node.atomic = wanted.dimensions == 0 and not self.types.components(wanted.name)

    def _procedure(self, node: tree.Call) -> None:
        if node.late is not None:
            self.expect(node.late, STRING, "the name of a procedure")
            for argument in node.arguments:
                if argument.name is not None or argument.value is None:
                    self.error(argument.at, "a procedure that is bound late takes required arguments alone")
                else:
                    self.type_of(argument.value)
                    found = self.root(argument.value)
                    if found is not None:
                        found.referenced = True
            return
        target = self.callee(node, "procedure")
        if target is None:
            return
        if isinstance(target, RoutineSymbol):
            if target.node.kind != "proc":
                kind = "a function, whose value is lost" if target.node.kind == "func" else "a trap"
                self.error(node.at, f"{node.name!r} is {kind}; only a procedure is called so")
        elif target.result:
            self.error(node.at, f"{target.name} is a function, whose value is lost")
        self.match(node, target)

    def _for(self, node: tree.For) -> None:
        for value in (node.first, node.last, *([node.step] if node.step is not None else [])):
            self.expect(value, NUM, "a bound of FOR")
        node.symbol = Datum(node.name, NUM, "loop", f"v{self._count()}_{node.name.lower()}")
        self.scopes.append({node.name.lower(): node.symbol})
        self._block(node.body)
        self.scopes.pop()

    def _test(self, node: tree.Test) -> None:
        kind = self.type_of(node.value)
        if kind.name.startswith("signal"):
            kind = NUM
        for values, body in node.cases:
            for value in values:
                self.expect(value, kind, "a value of CASE")
            self._block(body)
        if node.otherwise is not None:
            self._block(node.otherwise)

    def _jump(self, node: tree.Jump) -> None:
        routine = self._routine
        assert routine is not None
        kind = routine.node.kind
        if node.word == "raise" and self._in_undo and node.value is None:
            return  # public programs have it there: it ends the part
        if node.word == "return":
            if routine.result is not None and node.value is None and not self._in_undo:
                self.error(node.at, f"RETURN of the function {routine.node.name!r} needs a value")
            elif routine.result is not None and node.value is not None:
                self.expect(node.value, routine.result, f"the value of {routine.node.name!r}")
            elif node.value is not None:
                self.error(node.value.at, f"RETURN of a {kind.upper()} takes no value")
        elif node.word == "raise":
            if self._in_handler and node.value is not None:
                self.error(node.value.at, "RAISE in an error handler passes its error on, and takes no number")
            elif not self._in_handler and node.value is None:
                self.error(node.at, "RAISE needs the number of an error here")
            elif node.value is not None:
                self.expect(node.value, NUM, "the number of an error")
        elif node.word in ("retry", "trynext") and not self._in_handler:
            self.error(node.at, f"{node.word.upper()} stands in error handlers alone")
        elif node.value is not None:
            self.error(node.value.at, f"{node.word.upper()} takes no value")

    def _connect(self, node: tree.Connect) -> None:
        self.expect(node.interrupt, NUM, "an interrupt")
        found = self.symbol(node.trap)
        if not isinstance(found, RoutineSymbol) or found.node.kind != "trap":
            self.error(node.at, f"there is no trap {node.trap!r}")
            return
        node.target = found
        if self.root(node.interrupt) is None:
            self.error(node.interrupt.at, "an interrupt must be a variable (intnum)")
        else:
            self.reference(node.interrupt, "var", "an interrupt")

    def _local(self, node: tree.Data) -> None:
        routine = self._routine
        assert routine is not None
        kind = self.type_named(node.type, node.at, len(node.sizes))
        if node.storage == "pers":
            self.error(node.at, f"the persistent {node.name!r} must be declared in the module")
        if node.scope:
            self.error(node.at, f"data of a routine are its own; leave {node.scope.upper()} out")
        self._data_value(node, kind)
        node.symbol = Datum(node.name, kind, node.storage, f"v{self._count()}_{node.name.lower()}")
        if node.name.lower() in self.scopes[-1]:
            self.error(node.at, f"{node.name!r} is declared twice")
        self.scopes[-1][node.name.lower()] = node.symbol
        routine.data.append(node.symbol)


def is_common(node: tree.Data) -> bool:
    """Return whether a datum of a module is one with those of the same name in other tasks: PERS, not LOCAL or TASK."""
    return node.storage == "pers" and not node.scope


def _names_in(expressions: Iterable[tree.Expression]) -> Iterable[tree.Name]:
    """Yield all names in expressions."""
    for one in expressions:
        match one:
            case tree.Name():
                yield one
            case tree.Component():
                yield from _names_in([one.of])
            case tree.Element():
                yield from _names_in([one.of, *one.indices])
            case tree.Aggregate():
                yield from _names_in(one.items)
            case tree.Call():
                yield from _names_in([value.value for value in one.arguments if value.value is not None])
            case tree.Unary():
                yield from _names_in([one.operand])
            case tree.Binary():
                yield from _names_in([one.left, one.right])
            case _:
                pass
