from anamorph.methods.pervertex.pervertex import METHOD as METHOD
