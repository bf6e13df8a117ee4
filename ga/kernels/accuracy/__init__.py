"""How accurate the kernels are, against 50 digits: those of `motors`, those of `similarities`."""
