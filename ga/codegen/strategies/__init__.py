"""C of a script under other generators' models, to compare with `program`, which is `targets.c`.

``table`` interprets a Cayley table, one call a product, and ``table-code`` has that table written
out as code (Gaigen's way); ``product`` writes one specialised function for each product and pair of
blade sets (libvsr's way).
"""
