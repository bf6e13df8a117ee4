"""The motion and the measurements of the filter, written once as multivectors.

`definitions` has them over symbols, and CasADi derive their Jacobians; after an edit,
``python -m motorcade.fusion.filter.model`` writes both anew as C into
``fusion/filter/native/generated``. It needs CasADi and mpmath; the compiled filter needs neither.
"""
