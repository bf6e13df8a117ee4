"""The motion and the measurements of the filter, written once as multivectors.

`motion` and `measurements` define them over symbols and have CasADi derive their Jacobians;
`emit` writes both as C into ``fusion/filter/native/generated``. After an edit,
``python -m motorcade.fusion.filter.model`` writes that again. It needs CasADi and mpmath; the
compiled filter needs neither.
"""
