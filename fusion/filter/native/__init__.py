"""The filter compiled from the C++ headers beside this file and the generated model."""
