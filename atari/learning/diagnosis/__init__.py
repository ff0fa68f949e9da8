"""A diagnosis of an agent: where its games end, what it does there, and what gets it on."""
