"""How environments are made and registered: `atari.make`, and the entries of Gymnasium's registry."""
