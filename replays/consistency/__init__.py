"""Monte Carlo runs of the filter and its rivals: whether their errors are as they say."""
