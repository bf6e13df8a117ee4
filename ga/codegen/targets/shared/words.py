"""Words that languages keep for themselves: keywords, and functions of their own libraries."""

from __future__ import annotations

import keyword

__all__ = ["C_LIBRARY", "C_WORDS", "GLSL_WORDS", "PYTHON_WORDS"]


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Keywords of C23, of C++20 with its other spellings of operators, and macros that common headers
# and compilers define.
C_WORDS = _words(
    """
    BUFSIZ EOF HUGE_VAL HUGE_VALF HUGE_VALL I INFINITY M_1_PI M_2_PI M_2_SQRTPI M_E M_LN10 M_LN2
    M_LOG10E M_LOG2E M_PI M_PI_2 M_PI_4 M_SQRT1_2 M_SQRT2 NAN NULL alignas alignof and and_eq
    asm assert auto bitand bitor bool break case catch char char16_t char32_t char8_t class
    co_await co_return co_yield compl complex concept const const_cast consteval constexpr
    constinit continue decltype default delete do double dynamic_cast else enum errno explicit
    export extern false far float for fortran friend goto i386 if imaginary inline int linux
    long mutable namespace near new noexcept not not_eq nullptr offsetof operator or or_eq
    private protected public register reinterpret_cast requires restrict return short signed
    size_t sizeof static static_assert static_cast stderr stdin stdout struct switch template
    this thread_local throw true try typedef typeid typename typeof typeof_unqual union unix
    unsigned using virtual void volatile wchar_t while xor xor_eq
    """
)

_MATH = _words(
    """
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh drem erf erfc exp exp10
    exp2 expm1 fabs fdim finite floor fma fmax fmin fmod frexp gamma hypot ilogb isinf isnan j0
    j1 jn ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint
    nextafter nexttoward pow pow10 remainder remquo rint round scalb scalbln scalbn significand
    signbit sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn cabs cacos cacosh carg casin
    casinh catan catanh ccos ccosh cexp cimag clog conj cpow cproj creal csin csinh csqrt ctan
    ctanh
    """
)

# Functions of the C library, which another function cannot be named after.
C_LIBRARY = frozenset(name + kind for name in _MATH for kind in ("", "f", "l")) | _words(
    """
    abort abs alloca at_quick_exit atexit atof atoi atol atoll bcmp bcopy bsearch bzero calloc
    clearerr dcgettext dgettext div execl execle execlp execv execve execvp exit fclose feof
    ferror fflush ffs ffsl ffsll fgetc fgetpos fgets fopen fork fpclassify fprintf
    fprintf_unlocked fputc fputc_unlocked fputs fputs_unlocked fread free freopen fscanf fseek
    fsetpos ftell fwrite fwrite_unlocked getc getchar getenv gets gettext imaxabs index isalnum
    isalpha isascii isblank iscntrl isdigit isfinite isgraph isgreater isgreaterequal isless
    islessequal islessgreater islower isnormal isprint ispunct isspace isunordered isupper
    iswalnum iswalpha iswblank iswcntrl iswdigit iswgraph iswlower iswprint iswpunct iswspace
    iswupper iswxdigit isxdigit labs ldiv llabs lldiv localeconv longjmp main malloc mblen
    mbstowcs mbtowc memccpy memchr memcmp memcpy memmove mempcpy memset perror posix_memalign
    printf printf_unlocked putc putc_unlocked putchar putchar_unlocked puts puts_unlocked qsort
    quick_exit raise rand realloc remove rename rewind rindex scanf setbuf setjmp setlocale
    setvbuf signal snprintf sprintf srand sscanf stpcpy stpncpy strcasecmp strcat strchr strcmp
    strcoll strcpy strcspn strdup strerror strfmon strftime strlen strncasecmp strncat strncmp
    strncpy strndup strnlen strpbrk strrchr strspn strstr strtod strtof strtok strtol strtold
    strtoll strtoul strtoull strxfrm system time tmpfile tmpnam toascii tolower toupper towlower
    towupper ungetc va_arg va_copy va_end va_start vfprintf vfscanf vprintf vscanf vsnprintf
    vsprintf vsscanf wcstombs wctomb
    """
)

# Keywords and reserved words of GLSL 3.30 and 4.60 and of GLSL ES 3.00 and 3.20, then functions.
GLSL_WORDS = _words(
    f"""
    active asm atomic_uint attribute bool break buffer case cast centroid class coherent common
    const continue default discard do double else enum extern external false filter fixed flat
    float for fvec2 fvec3 fvec4 goto half highp hvec2 hvec3 hvec4 if in inline inout input int
    interface invariant layout long lowp main mediump namespace noinline noperspective out output
    packed partition patch precise precision public readonly resource restrict return row_major
    sample sampler3DRect shared short sizeof smooth static struct subroutine superp switch template
    this true typedef uint uniform union unsigned using varying void volatile while writeonly
    {" ".join(f"{k}vec{n}" for k in ("", "b", "d", "i", "u") for n in "234")}
    {" ".join(f"{k}mat{n}{m}" for k in "d " for n in "234" for m in ("", "x2", "x3", "x4"))}
    {
        " ".join(
            f"{k}{t}{d}"
            for k in ("", "i", "u")
            for t in ("sampler", "image", "texture", "subpassInput")
            for d in (
                "1D",
                "2D",
                "3D",
                "Cube",
                "2DRect",
                "1DArray",
                "2DArray",
                "CubeArray",
                "Buffer",
                "2DMS",
                "2DMSArray",
                "",
                "MS",
            )
        )
    }
    sampler1DShadow sampler2DShadow samplerCubeShadow sampler2DRectShadow sampler1DArrayShadow
    sampler2DArrayShadow samplerCubeArrayShadow samplerExternalOES samplerShadow
    abs acos acosh all any asin asinh atan atanh barrier bitCount bitfieldExtract
    bitfieldInsert bitfieldReverse ceil clamp cos cosh cross dFdx dFdxCoarse dFdxFine dFdy
    dFdyCoarse dFdyFine degrees determinant distance dot equal exp exp2 faceforward findLSB
    findMSB floatBitsToInt floatBitsToUint floor fma fract frexp ftransform fwidth fwidthCoarse
    fwidthFine greaterThan greaterThanEqual groupMemoryBarrier imulExtended intBitsToFloat
    interpolateAtCentroid interpolateAtOffset interpolateAtSample inverse inversesqrt isinf isnan
    ldexp length lessThan lessThanEqual log log2 matrixCompMult max memoryBarrier min mix mod modf
    noise1 noise2 noise3 noise4 normalize not notEqual outerProduct packDouble2x32 packHalf2x16
    packSnorm2x16 packSnorm4x8 packUnorm2x16 packUnorm4x8 pow radians reflect refract round
    roundEven sign sin sinh smoothstep sqrt step tan tanh texelFetch texelFetchOffset textureGather
    textureGrad textureLod textureOffset textureProj textureQueryLevels textureQueryLod
    textureSize transpose trunc uaddCarry uintBitsToFloat umulExtended unpackDouble2x32
    unpackHalf2x16 unpackSnorm2x16 unpackSnorm4x8 unpackUnorm2x16 unpackUnorm4x8 usubBorrow
    """
)

PYTHON_WORDS = frozenset(keyword.kwlist) | {"__debug__"}
