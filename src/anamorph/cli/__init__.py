"""The command `anamorph`."""
