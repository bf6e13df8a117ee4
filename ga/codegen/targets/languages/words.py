"""Names that Rust, JavaScript, WGSL, Julia and C++ keep for themselves, or that code calls.

The lists follow the references of the languages: Rust's keywords, ECMAScript's reserved words of
strict code, WGSL's keywords and reserved words, Julia's keywords, C++ as for C.

Tapes for languages in which true is no number: conditions and numbers are kept apart.
"""

from __future__ import annotations

from dataclasses import replace

from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape
from motorcade.ga.codegen.targets.names import C_NAMES, Reserved
from motorcade.ga.codegen.targets.shared.text import SAME_NAMES

_FUNCTIONS = frozenset(SAME_NAMES) | {"abs", "min", "max"}


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Parameters are patterns in Rust: those named as a constructor of its prelude would match it.
RUST_NAMES = Reserved(
    "Rust",
    _words(
        """
        _ Self abstract as async await become box break const continue crate do dyn else enum
        extern false final fn for gen if impl in let loop macro match mod move mut override priv
        pub ref return self static struct super trait true try type typeof unsafe unsized use
        virtual where while yield None Some Ok Err
        """
    ),
    frozenset({"main"}),
)

JAVASCRIPT_NAMES = Reserved(
    "JavaScript",
    _words(
        """
        arguments await break case catch class const continue debugger default delete do else enum
        eval export extends false finally for function if implements import in instanceof interface
        let new null package private protected public return static super switch this throw true
        try typeof var void while with yield Infinity Math NaN undefined
        """
    ),
)

JULIA_NAMES = Reserved(
    "Julia",
    _FUNCTIONS
    | _words(
        """
        abstract baremodule begin break catch ccall cglobal const continue do else elseif end export
        false finally for function global if ifelse import in isa let local macro module mutable new
        oftype outer primitive promote public quote return struct true try type using where while
        zero float NaN
        """
    ),
)

_WGSL_WORDS = _words(
    """
    _ alias break case const const_assert continue continuing default diagnostic discard else enable
    false fn for if let loop override requires return struct switch true var while
    NULL Self abstract active alignas alignof as asm asm_fragment async attribute auto await become
    cast catch class co_await co_return co_yield coherent column_major common compile
    compile_fragment concept const_cast consteval constexpr constinit crate debugger decltype delete
    demote demote_to_helper do dynamic_cast enum explicit export extends extern external
    fallthrough filter final finally friend from fxgroup get goto groupshared highp impl implements
    import inline instanceof interface layout lowp macro macro_rules match mediump meta mod module
    move mut mutable namespace new nil noexcept noinline nointerpolation non_coherent noncoherent
    noperspective null nullptr of operator package packoffset partition pass patch pixelfragment
    precise precision premerge priv protected pub public readonly ref regardless register
    reinterpret_cast require resource restrict self set shared sizeof smooth snorm static
    static_assert static_cast std subroutine super target template this thread_local throw trait try
    type typedef typeid typename typeof union unless unorm unsafe unsized use using varying virtual
    volatile wgsl where with writeonly yield
    array bool f32 ptr function select
    """
)
WGSL_NAMES = Reserved("WGSL", _FUNCTIONS | _WGSL_WORDS, frozenset({"main"}), underscores=True)

CPP_NAMES = replace(C_NAMES, words=C_NAMES.words | {"std"})


_LOGIC = frozenset({"and", "or", "not"})


def typed(tape: Tape) -> Tape:
    """The same tape where choices and logic take conditions only, and all else takes numbers.

    A condition that is used as a number becomes the choice of 1 or 0, a number that is used as a
    condition is compared with 0.
    """
    nodes: list[Node] = []
    numbers: list[int] = []
    conditions: dict[int, int] = {}
    known: dict[Node, int] = {}

    def add(node: Node) -> int:
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        return known[node]

    def condition(old: int) -> int:
        if old not in conditions:
            zero = add(Node("const", value=0.0))
            conditions[old] = add(Node("ne", (numbers[old], zero)))
        return conditions[old]

    def number(old: int) -> int:
        if numbers[old] < 0:
            ends = add(Node("const", value=1.0)), add(Node("const", value=0.0))
            numbers[old] = add(Node("select", (conditions[old], *ends)))
        return numbers[old]

    for old, node in enumerate(tape.nodes):
        args = tuple(
            condition(k) if node.op in _LOGIC or (place == 0 and _chooses(node)) else number(k)
            for place, k in enumerate(node.args)
        )
        new = add(Node(node.op, args, node.value, node.source))
        numbers.append(new)
        if node.op in BOOLEANS:
            conditions[old], numbers[old] = new, -1
    results = tuple(tuple(number(k) for k in row) for row in tape.results)
    return Tape(tape.inputs, tape.outputs, tuple(nodes), results)


def _chooses(node: Node) -> bool:
    return node.op in ("select", "keep")
