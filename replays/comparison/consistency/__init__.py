"""Monte Carlo runs of the filter in several coordinates: whether their errors are as they say."""
