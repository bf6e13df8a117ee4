"""The comparison of smoothers: every representation, method, motion and degradation, over seeds.

`motorcade compare` leaves in its folder

``cells.csv``
    a row a motion, degradation, seed, method and representation, with every metric; the raw poses
    are ``raw, none``. Empty where a metric cannot be told; `failure` says why a method has none.
``groups.csv``
    a row a motion, degradation, method, representation and metric, over all seeds: mean with its
    interval, difference from the same method on motors, and from the best; see
    `motorcade.replays.comparison.statistics`.
``results.json``
    the plan with both lists of seeds, the parameters found, what every method costs and what
    changing frames does to it, rankings with intervals, the count of wins and ties, exact ties; see
    `motorcade.replays.comparison.tables`.
``report.html``, ``motions/``
    all of it as pages; see `motorcade.replays.comparison.report`.
"""
