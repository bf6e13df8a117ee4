"""Commands on recordings and runs of the stage graph."""
