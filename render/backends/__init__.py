"""Ways to turn a scene into an image; OpenGL is imported only when a renderer is made."""
