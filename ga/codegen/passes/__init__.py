"""The optimiser: passes over tapes that leave fewer operations and the same values.

`optimize` has their order. `merge` proves zeros and finds equal nodes by `fingerprints` over a
finite `field`, and by a `witness` over the reals; `expand` and `factor` rewrite sums of products
(`forms`); `divisions` shares reciprocals. `like_terms` is for the library's own kernels, whose
definitions are written with their operations in mind.
"""
