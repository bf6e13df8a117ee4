// Functions compiled for each of the processors that x86 has; the loader picks.

#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__) && (!defined(__clang__) || __clang_major__ >= 18)
#define MOTORCADE_CLONES                                                                           \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MOTORCADE_CLONES
#endif

// All that a clone calls becomes part of it.
#if defined(__GNUC__)
#define MOTORCADE_FLAT __attribute__((flatten))
#else
#define MOTORCADE_FLAT
#endif
