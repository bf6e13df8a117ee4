"""The paper's Table 3 again: blending the poses of three characters, method by method."""
