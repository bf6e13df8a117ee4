"""The fast renderer: few calls, shaders of its own, meshes carried by their joints in a shader."""
