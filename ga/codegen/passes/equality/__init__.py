"""Which nodes of a tape are zero, or equal up to a factor: decided by evaluation, then merged.

`merge` is the pass. `fingerprints` has the values of all nodes at random points of the finite
`field`, exactly; the `witness` has the same claims hold over the reals.
"""
