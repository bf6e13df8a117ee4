"""What is measured of a smoother: errors against the truth, lag, cost, frames, ties of theory."""
