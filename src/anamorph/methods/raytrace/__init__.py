from anamorph.methods.raytrace.raytrace import METHOD as METHOD
