"""Compares interfaces: the modules, classes, signatures, attributes and hooks of other packages with those of this one.

`archive` reads a package by syntax tree from its unpacked archive, `live` reads an imported package by `inspect`.
Both return facts (`facts.Fact`). `compare` says which facts do not hold for this package.
"""
