"""Ways to turn a scene into a picture; OpenGL is imported only when a renderer is made."""
