"""`Environments`: which expressions of a script are environments, and which of its classes."""

import ast
import re
from typing import Literal

from atari.classic.rewrite.conditions import parameters
from atari.classic.rewrite.script import OLD, Function, Script, last_name

Kind = Literal["env", "vector", "list", "other"]
"""One environment, a vector of them, a list of single ones, or something that is none."""

_ENV = re.compile(r"(?:^|_)(?:env|environment)\d*_?$|[a-z]Env$")
_ENVS = re.compile(r"(?:^|_)(?:envs|vec_?env|venv)\d*$")
_VECTORS = (f"{OLD}.vector.", f"{OLD}.make_vec")
_OTHERS = frozenset("dm_control dm_env jinja2 lmdb mlagents_envs pettingzoo simpy unityagents".split())
"""Packages whose environments have interfaces of their own."""
_FOUR = ("stable_baselines3.", "sb3_contrib.", "stable_baselines.")
"""Packages whose vectors return four values until today; their wrappers for single environments return five."""


class Environments:
    """The environments of a script, as far as its text shows them.

    Attributes:
        classes: the classes that are environments: "env" derives from Gym's `Env`, "wrapper" from a wrapper, "plain"
            has `reset`, and a `step` that returns four values.
        is_old: whether there is something of Gym's to rewrite.
        careful: whether the script imports Gymnasium already, so that only what is wrong there is rewritten.
    """

    def __init__(self, script: Script) -> None:
        self.script = script
        functions = script.walk(ast.FunctionDef, ast.AsyncFunctionDef)
        self.functions = {node.name: node for node in functions if isinstance(node, Function)}
        self._bindings = self._find_bindings()
        self.careful = "gymnasium" in script.packages
        self.classes: dict[ast.ClassDef, str] = {}
        for node in script.walk(ast.ClassDef):
            if isinstance(node, ast.ClassDef) and (kind := self._class_kind(node)):
                self.classes[node] = kind
        self.is_old = self._is_old()

    def _is_old(self) -> bool:
        """Whether the script has Gym's interface: it imports Gym, or takes or returns four values."""
        packages = self.script.packages
        if self.careful:  # with both, or with vectors of four values, the script cannot be judged
            return not packages & {OLD, "atari.classic", *(name.rstrip(".") for name in _FOUR)}
        if packages & {OLD, "atari.classic"} or "plain" in self.classes.values():
            return True
        return any(self.is_step(call) and self._is_unpacked(call) for call in self.script.calls())

    def _find_bindings(self) -> dict[str, list[tuple[ast.AST, ast.expr, bool]]]:
        """For each target's text: the node of each binding, its value, and whether it is an element of the value."""
        found: dict[str, list[tuple[ast.AST, ast.expr, bool]]] = {}

        def add(target: ast.AST, value: ast.expr | None, element: bool = False) -> None:
            if value is not None and isinstance(target, ast.Name | ast.Attribute):
                found.setdefault(ast.unparse(target), []).append((target, value, element))

        for node in self.script.walk(ast.Assign, ast.AnnAssign, ast.For, ast.withitem, ast.comprehension):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    add(target, node.value)
            elif isinstance(node, ast.AnnAssign):
                add(node.target, node.value)
            elif isinstance(node, ast.For | ast.comprehension):
                add(node.target, node.iter, True)
            elif isinstance(node, ast.withitem) and node.optional_vars is not None:
                add(node.optional_vars, node.context_expr)
        return found

    def binding(self, node: ast.AST) -> tuple[ast.expr, bool] | None:
        """The value that a name or an attribute has where it stands: the last one bound before, else any."""
        bindings = self._bindings.get(ast.unparse(node), [])
        here = self.script.function(node)
        if isinstance(node, ast.Name):
            scopes: list[ast.AST | None] = [here]
            while scopes[-1] is not None:
                scopes.append(self.script.function(scopes[-1]))
            for scope in scopes:
                inside = [each for each in bindings if self.script.function(each[0]) is scope]
                if inside:
                    bindings = inside
                    break
                if isinstance(scope, Function) and node.id in parameters(scope):
                    return None
        place = (node.lineno, node.col_offset)  # type: ignore[attr-defined]
        before = [
            each
            for each in bindings
            if (self.script.statement(each[0]).end_lineno or 0, 0) < place and self.script.function(each[0]) is here
        ]
        if not bindings:
            return None
        _, value, element = (before or bindings)[-1]
        return value, element

    def kind(self, node: ast.AST, depth: int = 8) -> Kind | None:
        """The kind of an expression; None if the script does not show one."""
        if depth == 0:
            return None
        if isinstance(node, ast.Call):
            return self._call_kind(node, depth)
        if isinstance(node, ast.Attribute) and node.attr in ("unwrapped", "env") and self.kind(node.value, depth - 1):
            return "env"
        if isinstance(node, ast.Name | ast.Attribute):
            return self._name_kind(node, depth)
        if isinstance(node, ast.Subscript):
            base = self.kind(node.value, depth - 1)
            return "env" if base == "list" or (base is None and _ENVS.search(last_name(node.value))) else None
        if isinstance(node, ast.List | ast.ListComp):
            elements = node.elts if isinstance(node, ast.List) else [node.elt]
            return "list" if any(self.kind(each, depth - 1) == "env" for each in elements) else None
        if isinstance(node, ast.IfExp):
            return self.kind(node.body, depth - 1) or self.kind(node.orelse, depth - 1)
        return None

    def _name_kind(self, node: ast.Name | ast.Attribute, depth: int) -> Kind | None:
        if isinstance(node, ast.Name) and node.id in ("self", "cls"):
            inside = self.script.class_of(node)
            return "env" if inside in self.classes else "other"
        bound = self.binding(node)
        if bound is not None and ast.unparse(bound[0]) != ast.unparse(node):
            value, element = bound
            kind = self.kind(value, depth - 1)
            if element and kind is None and _ENVS.search(last_name(value)):
                return "env"
            if kind is not None:
                return ("env" if kind == "list" else "other") if element else kind
            if self.careful and isinstance(value, ast.Call):
                return "other"  # of a class or a function that is not shown, which may have an interface of its own
        name = last_name(node)
        if _ENV.search(name):
            return "env"
        return "vector" if _ENVS.search(name) else None

    def _call_kind(self, call: ast.Call, depth: int) -> Kind | None:
        name = self.script.qualified(call.func)
        if isinstance(call.func, ast.Name) and name is None:
            return self._local_kind(call, call.func.id, depth)
        if isinstance(call.func, ast.Attribute) and last_name(call.func.value) == "self":
            function = self.functions.get(call.func.attr)
            return self.returned_kind(function, depth) if function is not None else None
        if name is None:
            return None
        if name.startswith(_VECTORS):
            return "vector"
        if name == f"{OLD}.make":
            return "env"
        if name.startswith(f"{OLD}.wrappers."):
            return (self.kind(call.args[0], depth - 1) if call.args else None) or "env"
        if name.startswith(_FOUR) and re.search(r"[Vv]ec|make_atari_env", name):
            return "other"
        return "other" if name.partition(".")[0] in _OTHERS else None

    def _local_kind(self, call: ast.Call, name: str, depth: int) -> Kind | None:
        if name == "super":
            return "env" if self.script.class_of(call) in self.classes else "other"
        if any(each.name == name for each in self.classes):
            return "env"
        function = self.functions.get(name)
        return self.returned_kind(function, depth) if function is not None else None

    def returned_kind(self, function: Function, depth: int = 4) -> Kind | None:
        """The kind of what a function of the script returns."""
        for node in self.script.own(function, ast.Return):
            if isinstance(node, ast.Return) and node.value is not None and (kind := self.kind(node.value, depth - 1)):
                return kind
        return None

    def _class_kind(self, node: ast.ClassDef) -> str | None:
        for base in node.bases:
            name = self.script.qualified(base)
            if name is not None and name.startswith(f"{OLD}."):
                last = name.rpartition(".")[2]
                if last.endswith("Wrapper") or name.startswith(f"{OLD}.wrappers."):
                    return "wrapper"
                if last.endswith("Env"):
                    return "env"
            for other, kind in self.classes.items():
                if isinstance(base, ast.Name) and base.id == other.name:
                    return kind
        methods = {each.name: each for each in node.body if isinstance(each, Function)}
        if "step" in methods and "reset" in methods and not self.careful:
            for each in self.script.own(methods["step"], ast.Return):
                value = each.value if isinstance(each, ast.Return) else None
                if isinstance(value, ast.Tuple) and len(value.elts) == 4:
                    return "plain"
        return None

    def is_current(self, node: ast.ClassDef | None) -> bool:
        """Whether a class is for Gymnasium, as it neither takes nor returns four values of `step`."""
        if node is None or not self.careful:
            return False
        for each in ast.walk(node):
            value = each.value if isinstance(each, ast.Return | ast.Assign) else None
            function = self.script.function(each)
            if isinstance(value, ast.Call) and self.is_step(value) and self._is_unpacked(value):
                return False
            is_four = isinstance(each, ast.Return) and isinstance(value, ast.Tuple) and len(value.elts) == 4
            if is_four and function is not None and function.name in ("step", "_step"):
                return False
        return True

    def is_step(self, node: ast.AST | None, depth: int = 4) -> bool:
        """Whether an expression has the values of `step`: a call of it, or of a function that returns one."""
        return self._is_result("step", node, depth)

    def is_reset(self, node: ast.AST | None) -> bool:
        """Whether an expression is a call of an environment's `reset`."""
        return self._is_result("reset", node, 1)

    def _is_result(self, method: str, node: ast.AST | None, depth: int) -> bool:
        if not isinstance(node, ast.Call) or depth == 0:
            return False
        if isinstance(node.func, ast.Attribute) and node.func.attr in (method, f"_{method}"):
            kind = self.kind(node.func.value)
            if kind is None and method == "step" and not self.careful:
                return self._is_used_as_four(node)
            return kind in ("env", "vector")
        function = self.functions.get(last_name(node.func))
        if function is None or method == "reset" or isinstance(self.script.qualified(node.func), str):
            return False
        if self.script.class_of(function) in self.classes:
            return False
        returns = self.script.own(function, ast.Return)
        return any(isinstance(each, ast.Return) and self.is_step(each.value, depth - 1) for each in returns)

    def has_old_vectors(self) -> bool:
        """Whether the script's vectors are of Gym's time, so that they reset in the step that ends an episode."""
        if not self.careful:
            return True
        steps = [call for call in self.script.calls() if self._is_unpacked(call) and self.is_step(call)]
        return any(isinstance(call.func, ast.Attribute) and self.kind(call.func.value) == "vector" for call in steps)

    def _is_used_as_four(self, call: ast.Call) -> bool:
        """Whether a call's result is assigned to four targets, also by a caller of the function that returns it."""
        function = self.script.function(call)
        if isinstance(self.script.parent(call), ast.Return) and function is not None:
            callers = [each for each in self.script.calls() if last_name(each.func) == function.name]
            return any(self._is_unpacked(each) for each in callers)
        return self._is_unpacked(call)

    def _is_unpacked(self, call: ast.Call) -> bool:
        """Whether a call's result is assigned to four targets."""
        statement = self.script.parent(call)
        if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
            return False
        target = statement.targets[0]
        return isinstance(target, ast.Tuple | ast.List) and len(target.elts) == 4

    def is_pair(self, node: ast.Name | ast.Attribute) -> bool:
        """Whether a script for Gymnasium may take the value of `reset` in a name as observation and info."""
        scope, text = self.script.function(node), ast.unparse(node)
        uses = [
            each
            for each in self.script.walk(type(node))
            if ast.unparse(each) == text and (isinstance(node, ast.Attribute) or self.script.function(each) is scope)
        ]
        loads = [each for each in uses if isinstance(each.ctx, ast.Load)]  # type: ignore[attr-defined]
        of_step = any(self._is_observation(each) for each in uses)
        return not loads or any(self._is_taken_apart(each, of_step) for each in loads)

    def _is_observation(self, target: ast.AST) -> bool:
        """Whether a target is the first of those to which `step` is unpacked."""
        targets = self.script.parent(target)
        statement = self.script.parent(targets) if isinstance(targets, ast.Tuple | ast.List) else None
        return isinstance(statement, ast.Assign) and targets.elts[0] is target and self.is_step(statement.value)  # type: ignore[union-attr]

    def _is_taken_apart(self, node: ast.AST, of_step: bool) -> bool:
        parent = self.script.parent(node)
        if isinstance(parent, ast.Subscript):
            statement = self.script.parent(parent)
            is_first = isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == ast.unparse(node)
            return isinstance(getattr(parent.slice, "value", None), int) and (is_first or not of_step)
        if isinstance(parent, ast.Assign):
            return isinstance(parent.targets[0], ast.Tuple | ast.List)
        return isinstance(parent, ast.Return | ast.Starred) or (
            isinstance(parent, ast.Call) and last_name(parent.func) in ("isinstance", "len", "print", "tuple", "type")
        )

    def class_made(self, node: ast.AST) -> ast.ClassDef | None:
        """The class of the script whose instance an expression is, if the script shows it."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return next((each for each in self.classes if each.name == node.func.id), None)
        bound = self.binding(node) if isinstance(node, ast.Name | ast.Attribute) else None
        return self.class_made(bound[0]) if bound is not None and isinstance(bound[0], ast.Call) else None
