"""Scripts and macros of Gaalop's, run here: `python -m tests.ga.gaalop` prints what agrees."""
