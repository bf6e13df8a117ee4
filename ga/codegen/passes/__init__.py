"""The optimiser: passes over tapes that leave fewer operations and the same values.

`optimize` has their order. `equality` proves zeros and gives equal nodes one place;
`sums_of_products` collects, factors and shares terms, quotients too; `choices`, for code that only
runs, makes a choice once. `rebuild` and `stats` are what all passes write and count with.
"""
