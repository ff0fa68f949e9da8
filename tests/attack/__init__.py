"""Attackers: each makes up hostile input for one part of the package, from a seed."""
