"""How a tape comes about: `trace` reads it from CasADi's symbols, `recorder` has symbols of ours.

Code that runs over either kind is written down operation by operation.
"""
