"""The conditions under which a script renders, if it knows them before it makes the environment."""

import ast

from atari.classic.rewrite.script import Function, Script

_PURE = (ast.Name, ast.Attribute, ast.Subscript, ast.Constant, ast.UnaryOp, ast.BoolOp, ast.BinOp, ast.Compare)
"""Expressions that can be evaluated twice."""


def conditions(script: Script, call: ast.AST, make: ast.AST) -> list[ast.expr | None]:
    """The conditions under which a call stands, but not the call of `make`; None for an `else`."""
    around, inner = set(script.above(make)), call
    found: list[ast.expr | None] = []
    for node in script.above(call):
        if isinstance(node, ast.If) and node not in around and "__name__" not in ast.unparse(node.test):
            is_and = isinstance(node.test, ast.BoolOp) and isinstance(node.test.op, ast.And)
            parts: list[ast.expr] = node.test.values if is_and else [node.test]  # type: ignore[attr-defined]
            found += parts if inner in node.body else [None]
        inner = node
    return found


def is_known(script: Script, condition: ast.expr, make: ast.AST) -> bool:
    """Whether a condition has its value where `make` is called already, and keeps it."""
    nodes = [node for node in ast.walk(condition) if isinstance(node, ast.expr)]
    return all(isinstance(node, _PURE) and _keeps(script, node, make) for node in nodes)


def _keeps(script: Script, node: ast.expr, make: ast.AST) -> bool:
    if isinstance(node, ast.Attribute | ast.Subscript):
        text = ast.unparse(node)
        stores = [each for each in script.walk(type(node)) if _is_store(each) and ast.unparse(each) == text]
        return all(_is_before(script, each, make) for each in stores)
    if not isinstance(node, ast.Name):
        return True
    if node.id == "self":
        return script.class_of(node) is script.class_of(make)
    scope = _scope(script, node.id, make)
    changed = any(node.id in each.names for each in script.walk(ast.Global, ast.Nonlocal))  # type: ignore[attr-defined]
    if changed or _scope(script, node.id, node) is not scope:
        return False
    stores = [each for each in _names(script, node.id, scope) if _is_store(each)]
    is_given = node.id in script.names or (scope is not None and node.id in parameters(scope))
    return (bool(stores) or is_given) and all(_is_before(script, each, make) for each in stores)


def _is_store(node: ast.AST) -> bool:
    return not isinstance(getattr(node, "ctx", None), ast.Load)


def _is_before(script: Script, store: ast.AST, make: ast.AST) -> bool:
    """Whether a name is stored before `make` is called, in its function or outside of functions."""
    is_near = script.function(store) in (None, script.function(make))
    return is_near and store.lineno < make.lineno  # type: ignore[attr-defined]


def _names(script: Script, name: str, scope: Function | None) -> list[ast.AST]:
    return [
        each
        for each in script.walk(ast.Name)
        if isinstance(each, ast.Name) and each.id == name and script.function(each) is scope
    ]


def _scope(script: Script, name: str, node: ast.AST) -> Function | None:
    """The function whose local variable a name is where a node stands; None for a name of the module."""
    function = script.function(node)
    while function is not None:
        if name in parameters(function) or any(_is_store(each) for each in _names(script, name, function)):
            return function
        function = script.function(function)
    return None


def parameters(function: Function) -> set[str]:
    """The names of a function's parameters, without `*args` and `**kwargs`."""
    arguments = function.args
    return {each.arg for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)}
