"""All kernels: the module that holds them, widths of the inputs, width of the output.

Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those.
"""
# fmt: off

from __future__ import annotations

KERNELS: dict[str, tuple[str, tuple[int, ...], int]] = {
    "compose": ("products", (8, 8), 8),
    "inverse": ("products", (8,), 8),
    "exp": ("exponentials", (6,), 8),
    "log": ("exponentials", (8,), 6),
    "log_long": ("exponentials", (8,), 6),
    "interpolate": ("screws", (8, 8, 1), 8),
    "interpolate_long": ("screws", (8, 8, 1), 8),
    "apply": ("products", (8, 3), 3),
    "matrix34": ("conversions", (8,), 12),
    "matrix44": ("conversions", (8,), 16),
    "dual_quaternion": ("conversions", (8,), 8),
    "blend": ("linear_blends", (8, 8, 1), 8),
    "blend_matrix": ("linear_blends", (8, 8, 1), 12),
    "screw_blend": ("screw_blends", (8, 8, 1), 8),
    "screw_blend_matrix": ("screw_blends", (8, 8, 1), 12),
    "accumulate": ("linear_blends", (8, 8, 8, 1), 8),
    "normalize": ("linear_blends", (8,), 8),
    "normalize_matrix": ("linear_blends", (8,), 12),
    "rotor_compose": ("rotors", (4, 4), 4),
    "rotor_inverse": ("rotors", (4,), 4),
    "rotor_exp": ("rotors", (3,), 4),
    "rotor_log": ("rotors", (4,), 3),
    "rotor_log_long": ("rotors", (4,), 3),
    "rotor_interpolate": ("rotors", (4, 4, 1), 4),
    "rotor_interpolate_long": ("rotors", (4, 4, 1), 4),
    "similarity_compose": ("similarity_products", (12, 12), 12),
    "similarity_inverse": ("similarity_products", (12,), 12),
    "similarity_exp": ("similarity_exponentials", (7,), 12),
    "similarity_log": ("similarity_exponentials", (12,), 7),
    "similarity_log_long": ("similarity_exponentials", (12,), 7),
    "similarity_interpolate": ("similarity_spirals", (12, 12, 1), 12),
    "similarity_interpolate_long": ("similarity_long_spirals", (12, 12, 1), 12),
    "similarity_normalize": ("similarity_blends", (12,), 13),
    "similarity_blend": ("similarity_blends", (12, 12, 1), 12),
    "similarity_apply": ("similarity_products", (12, 3), 3),
    "similarity_matrix34": ("similarity_conversions", (12,), 12),
    "similarity_matrix44": ("similarity_conversions", (12,), 16),
    "rotor_translation_scale": ("similarity_conversions", (12,), 8),
    "similarity_of_motor": ("similarity_conversions", (8, 1), 12),
    "carry_motor": ("skinning", (8, 3, 3), 6),
    "carry_dual_quaternion": ("skinning", (8, 3, 3), 6),
    "carry_similarity": ("skinning", (12, 3, 3), 6),
    "carry_matrix": ("skinning", (12, 3, 3), 6),
    "reach": ("chains", (3, 3, 1), 3),
}
