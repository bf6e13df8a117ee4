"""Plain C, one call at a time, beside the C and C++ of others."""
