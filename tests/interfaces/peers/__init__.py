"""The packages whose interface this one has: each module names a package, its facts, and where ours stands."""
