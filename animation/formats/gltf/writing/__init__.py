"""Write `.glb` files: characters at rest or on their way, with looks, clips and a camera."""
