from anamorph.methods.trilinear.trilinear import METHOD as METHOD
