from anamorph.methods.environment.environment import METHOD as METHOD
