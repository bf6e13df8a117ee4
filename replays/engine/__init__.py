"""The machinery that runs stages: the graph, its cache on disk, and where jobs are computed."""
