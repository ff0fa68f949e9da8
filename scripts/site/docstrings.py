"""A reader of sources for mkdocstrings, which reads what Python makes at import: names of sections and defaults."""

import re
from typing import Any

from griffe import Attribute, ExprCall, Extension, Object

_EXAMPLE = re.compile(r"^Example:$", re.MULTILINE)


class Examples(Extension):
    """Renames the section "Example:", which is "Examples:" of its parser, so that its lines become code."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Change the docstring of an object that was read."""
        if obj.docstring:
            obj.docstring.value = _EXAMPLE.sub("Examples:", obj.docstring.value)


class Rows(Extension):
    """Shows the default of a field of a task, not the row that contains it."""

    def on_attribute_instance(self, *, attr: Attribute, **_: Any) -> None:
        """Replace a call of `row` by its first argument."""
        if isinstance(attr.value, ExprCall) and attr.value.canonical_path == "atari.task.fields.row":
            attr.value = attr.value.arguments[0]
