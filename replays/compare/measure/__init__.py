"""What is measured of a smoother: errors against ground truth, lag, cost, frames, exact ties."""
