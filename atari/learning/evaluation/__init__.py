"""Evaluation of policies: protocols, whole games on the vector environment, results, published results beside them."""
