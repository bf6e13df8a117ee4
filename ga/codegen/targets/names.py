"""Names from scripts in generated code: those that a language needs for itself are refused.

A variable becomes a parameter of its own name, the script's file name becomes the function's.
Outputs get names of their own making (``out_A``), or are text in dictionaries.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.shared.text import SAME_NAMES, variables

C_FUNCTIONS = SAME_NAMES | {"abs": "fabs", "min": "fmin", "max": "fmax"}


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Keywords of C23, of C++20 with its other spellings of operators, and macros that common headers
# and compilers define.
C_WORDS = _words(
    """
    BUFSIZ EOF FP_ILOGB0 FP_ILOGBNAN FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO HUGE_VAL
    HUGE_VALF HUGE_VALL I INFINITY MATH_ERREXCEPT MATH_ERRNO M_1_PI M_2_PI M_2_SQRTPI M_E M_LN10
    M_LN2 M_LOG10E M_LOG2E M_PI M_PI_2 M_PI_4 M_SQRT1_2 M_SQRT2 NAN NULL alignas alignof and
    and_eq asm assert auto bitand bitor bool break case catch char char16_t char32_t char8_t
    class co_await co_return co_yield compl complex concept const const_cast consteval constexpr
    constinit continue decltype default delete do double dynamic_cast else enum errno explicit
    export extern false far float for fortran friend goto i386 if imaginary inline int linux
    long math_errhandling mutable namespace near new noexcept not not_eq nullptr offsetof
    operator or or_eq private protected public register reinterpret_cast requires restrict
    return short signed signgam size_t sizeof static static_assert static_cast stderr stdin
    stdout struct switch template this thread_local throw true try typedef typeid typename
    typeof typeof_unqual union unix unsigned using virtual void volatile wchar_t while xor
    xor_eq
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

# Functions of the C library and of POSIX: another of the name would not compile beside their
# header, or would stand in for theirs.
C_LIBRARY = frozenset(name + kind for name in _MATH for kind in ("", "f", "l")) | _words(
    """
    a64l abort abs accept access acct alarm aligned_alloc alloca arc4random arc4random_buf
    arc4random_uniform asctime asctime_r at_quick_exit atexit atof atoi atol atoll bcmp bcopy
    bind brk bsearch btowc bzero calloc chdir chmod chown chroot clearenv clearerr
    clearerr_unlocked clock clock_getcpuclockid clock_getres clock_gettime clock_nanosleep
    clock_settime close closefrom confstr connect creat crypt ctermid ctime ctime_r daemon
    dcgettext dgettext difftime div dprintf drand48 drand48_r dup dup2 duplocale dysize ecvt
    ecvt_r endusershell erand48 erand48_r execl execle execlp execv execve execvp exit
    explicit_bzero faccessat fchdir fchmod fchmodat fchown fchownat fclose fcntl fcvt fcvt_r
    fdatasync fdopen feof feof_unlocked ferror ferror_unlocked fexecve fflush fflush_unlocked
    ffs ffsl ffsll fgetc fgetc_unlocked fgetpos fgets fgetwc fgetws fileno fileno_unlocked
    flockfile fmemopen fopen fork fpathconf fpclassify fprintf fprintf_unlocked fputc
    fputc_unlocked fputs fputs_unlocked fputwc fputws fread fread_unlocked free freelocale
    freopen fscanf fseek fseeko fsetpos fstat fstatat fsync ftell ftello ftruncate ftrylockfile
    funlockfile futimens fwide fwprintf fwrite fwrite_unlocked fwscanf gcvt getc getc_unlocked
    getchar getchar_unlocked getcwd getdelim getdomainname getdtablesize getegid getentropy
    getenv geteuid getgid getgroups gethostid gethostname getline getloadavg getlogin getlogin_r
    getopt getpagesize getpass getpeername getpgid getpgrp getpid getppid gets getsid
    getsockname getsockopt getsubopt gettext getuid getusershell getw getwc getwchar getwd
    gmtime gmtime_r gsignal imaxabs index initstate initstate_r isalnum isalnum_l isalpha
    isalpha_l isascii isatty isblank isblank_l iscntrl iscntrl_l isdigit isdigit_l isfdtype
    isfinite isgraph isgraph_l isgreater isgreaterequal isless islessequal islessgreater islower
    islower_l isnormal isprint isprint_l ispunct ispunct_l isspace isspace_l isunordered isupper
    isupper_l iswalnum iswalpha iswblank iswcntrl iswdigit iswgraph iswlower iswprint iswpunct
    iswspace iswupper iswxdigit isxdigit isxdigit_l jrand48 jrand48_r kill killpg l64a labs
    lchmod lchown lcong48 lcong48_r ldiv lgamma_r lgammaf_r lgammal_r link linkat listen llabs
    lldiv localeconv localtime localtime_r lockf longjmp lrand48 lrand48_r lseek lstat main
    malloc mblen mbrlen mbrtowc mbsinit mbsnrtowcs mbsrtowcs mbstowcs mbtowc memccpy memchr
    memcmp memcpy memmove mempcpy memset mkdir mkdirat mkdtemp mkfifo mkfifoat mknod mknodat
    mkstemp mkstemps mktemp mktime mrand48 mrand48_r nanosleep newlocale nice nrand48 nrand48_r
    on_exit open open_memstream open_wmemstream openat pathconf pause pclose perror pipe poll
    popen posix_fadvise posix_fallocate posix_memalign pread printf printf_unlocked profil
    pselect psiginfo psignal pthread_kill pthread_sigmask putc putc_unlocked putchar
    putchar_unlocked putenv puts puts_unlocked putw putwc putwchar pwrite qecvt qecvt_r qfcvt
    qfcvt_r qgcvt qsort quick_exit raise rand rand_r random random_r read readlink readlinkat
    realloc reallocarray realpath recv recvfrom recvmsg remove rename renameat revoke rewind
    rindex rmdir rpmatch sbrk scanf seed48 seed48_r select send sendmsg sendto setbuf setbuffer
    setdomainname setegid setenv seteuid setgid sethostid sethostname setjmp setlinebuf
    setlocale setlogin setpgid setpgrp setregid setreuid setsid setsockopt setstate setstate_r
    setuid setusershell setvbuf shutdown sigaction sigaddset sigaltstack sigblock sigdelset
    sigemptyset sigfillset siggetmask siginterrupt sigismember siglongjmp signal sigpending
    sigprocmask sigqueue sigreturn sigsetmask sigstack sigsuspend sigtimedwait sigwait
    sigwaitinfo sleep snprintf sockatmark socket socketpair sprintf srand srand48 srand48_r
    srandom srandom_r sscanf ssignal stat stpcpy stpncpy strcasecmp strcasecmp_l strcat strchr
    strcmp strcoll strcoll_l strcpy strcspn strdup strerror strerror_l strerror_r strfmon
    strftime strftime_l strlen strncasecmp strncasecmp_l strncat strncmp strncpy strndup strnlen
    strpbrk strrchr strsep strsignal strspn strstr strtod strtof strtok strtok_r strtol strtold
    strtoll strtoq strtoul strtoull strtouq strxfrm strxfrm_l swprintf swscanf symlink symlinkat
    sync syscall sysconf system tcgetpgrp tcsetpgrp tempnam time timegm timelocal timer_create
    timer_delete timer_getoverrun timer_gettime timer_settime timespec_get tmpfile tmpnam
    tmpnam_r toascii tolower tolower_l toupper toupper_l towlower towupper truncate ttyname
    ttyname_r ttyslot tzset ualarm umask ungetc ungetwc unlink unlinkat unsetenv uselocale
    usleep utimensat va_arg va_copy va_end va_start valloc vdprintf vfork vfprintf vfscanf
    vfwprintf vfwscanf vhangup vprintf vscanf vsnprintf vsprintf vsscanf vswprintf vswscanf
    vwprintf vwscanf wait wait3 wait4 waitid waitpid wcpcpy wcpncpy wcrtomb wcscasecmp
    wcscasecmp_l wcscat wcschr wcscmp wcscoll wcscoll_l wcscpy wcscspn wcsdup wcsftime wcslen
    wcsncasecmp wcsncasecmp_l wcsncat wcsncmp wcsncpy wcsnlen wcsnrtombs wcspbrk wcsrchr
    wcsrtombs wcsspn wcsstr wcstod wcstof wcstok wcstol wcstold wcstoll wcstombs wcstoul
    wcstoull wcsxfrm wcsxfrm_l wctob wctomb wmemchr wmemcmp wmemcpy wmemmove wmemset wprintf
    write wscanf
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


@dataclass(frozen=True)
class Reserved:
    """What a language keeps: `words` altogether, `functions` as names of functions only.

    Where it keeps `underscores`, names that begin with one or hold two in a row are its own, and
    so are those that begin with ``gl_``.
    """

    language: str
    words: frozenset[str]
    functions: frozenset[str] = frozenset()
    underscores: bool = False

    def keeps(self, name: str) -> bool:
        """Whether no variable can have the name."""
        return name in self.words or self.keeps_form(name)

    def keeps_form(self, name: str) -> bool:
        """Whether nothing can have the name, nor one made of it."""
        return self.underscores and (name.startswith(("_", "gl_")) or "__" in name)


C_NAMES = Reserved(
    "C or C++",
    C_WORDS | {f"{name}{kind}" for name in C_FUNCTIONS.values() for kind in ("", "f")},
    C_LIBRARY,
    underscores=True,
)
GLSL_NAMES = Reserved("GLSL", GLSL_WORDS, underscores=True)


def python_names(*used: str, modules: Sequence[str] = (), underscores: bool = False) -> Reserved:
    """What Python keeps and a module uses; no file is named as one of `modules`."""
    return Reserved("Python code", PYTHON_WORDS | set(used), frozenset(modules), underscores)


class RefusedName(ValueError):
    """A name that generated code cannot have; `name` is what the script calls it."""

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name


def check_names(
    program: Program, reserved: Reserved, slots: Sequence[tuple[str, str]] = ()
) -> None:
    """Refuse what a language keeps, and names that the generated code needs twice.

    `slots` are parameters with names of their own: the output or variable that each belongs to,
    and its name.

    Raises RefusedName: naming the name to use instead.
    """
    parameters = variables(program)
    taken = {*parameters} | {slot for _, slot in slots}
    why = f"is reserved in {reserved.language}"
    if reserved.keeps(program.name) or program.name in reserved.functions:
        raise _refused("file name", program.name, why, reserved, reserved.functions)
    for name in parameters:
        if reserved.keeps(name):
            raise _refused("variable", name, why, reserved, taken)
        if any(slot == name for _, slot in slots):
            raise _refused("variable", name, "is used by the generated code", reserved, taken)
    owners: dict[str, str] = {}
    for owner, slot in slots:
        if reserved.keeps_form(owner):
            raise _refused("output", owner, why, reserved, taken)
        if owners.setdefault(slot, owner) != owner:
            why = f"and {owners[slot]} have one parameter, {slot}, in the generated code"
            raise _refused("output", owner, why, reserved, taken)


def file_identifier(name: str) -> str:
    """The name of a file where that is an identifier, otherwise one like it to propose."""
    if re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
        return name
    identifier = re.sub("[^A-Za-z0-9_]+", "_", name).strip("_") or "script"
    return f"script_{identifier}" if identifier[0].isdigit() else identifier


def _refused(
    what: str, name: str, why: str, reserved: Reserved, taken: Collection[str]
) -> ValueError:
    free = name
    if reserved.keeps_form(free):
        free = re.sub("_+", "_", free.removeprefix("gl_")).strip("_") or "x"
    while free == name or reserved.keeps(free) or free in taken:
        free += "_" if not free.endswith("_") else "0"
    return RefusedName(name, f"{what} {name} {why}: rename {name} to {free}")
