"""C from the text of the integrator: each instruction does in C what LLVM does with it, bit for bit."""

from __future__ import annotations

import ctypes
import itertools
import operator
import struct
import subprocess

import llvmlite.binding as llvm
import numpy as np
import pytest

from gelcone.export import c99
from gelcone.export.compiler import find_compiler
from gelcone.export.sources import _template
from tests.export.instance import STRICT

compiles = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")

WORD = """\
#include <stdint.h>
typedef union word_ { double d; int64_t i; union word_ *p; void (*f)(void); } DEVICE_word;
"""
STATE = "typedef struct { DEVICE_word z[1]; } DEVICE_state;\ntypedef DEVICE_state DEVICE;\n"
ORDERED = ("olt", "ole", "ogt", "oge", "oeq", "une", "ult", "ule", "ugt", "uge", "uno")
SIGNED = ("eq", "ne", "slt", "sle", "sgt", "sge")


def module(instructions, kind):
    """A function ``own`` of the arrays ``in`` (a, b, c) and ``out``, in which each named line is a result of a kind."""
    lines = []
    for k in range(3):
        lines += [f"%at{k} = getelementptr double, ptr %in, i64 {k}", f"%{'abc'[k]} = load {kind}, ptr %at{k}"]
    for k, own in enumerate(instructions):
        *before, last = own if isinstance(own, list) else [own]
        lines += [*before, f"%r{k} = {last}"]
        lines += [f"%to{k} = getelementptr double, ptr %out, i64 {k}", f"store {kind} %r{k}, ptr %to{k}"]
    declared = "declare double @llvm.fabs.f64(double)\ndeclare double @llvm.fma.f64(double, double, double)\n"
    declared += "declare double @llvm.sqrt.f64(double)\ndeclare i64 @llvm.ctpop.i64(i64)\n"
    body = "\n".join(f"  {line}" for line in lines)
    return (
        f"{declared}declare i64 @llvm.cttz.i64(i64, i1)\n\n"
        f"define void @own(ptr %in, ptr %out) {{\nentry:\n{body}\n  ret void\n}}\n"
    )


def both(text, folder):
    """The function by LLVM and by C: each takes and gives an array of bits."""
    pairs = c99.translate(text, {"own": "translated"})
    bodies = "\n".join(body for _, body in pairs)
    parts = [WORD, STATE, _template("prelude.c"), c99.helpers(bodies), *(head for head, _ in pairs), bodies]
    (folder / "own.c").write_text("\n".join([*parts, "void called(word *in, word *out) { translated(in, out); }\n"]))
    command = [
        *find_compiler(),
        *STRICT,
        "-Wno-unused-variable",
        "-O1",
        "-fPIC",
        "-shared",
        "-o",
        "own.so",
        "own.c",
        "-lm",
    ]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    library = ctypes.CDLL(str(folder / "own.so"))
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    native = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(engine.get_function_address("own"))
    count = text.count("%to")

    def caller(function):
        def call(given):
            found = np.zeros(max(count, 1), dtype=np.int64)
            function(ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(found.ctypes.data))
            return found

        call.engine = engine  # it holds the code
        return call

    return caller(native), caller(library.called)


def compared(text, folder, rows):
    right, found = both(text, folder)
    for row in rows:
        given = np.ascontiguousarray(row).view(np.int64)
        assert found(given).tolist() == right(given).tolist(), row


REALS = [0.0, -0.0, 1.0, -1.5, 0.1, 1e300, -1e300, 5e-324, np.inf, -np.inf, np.nan, 2.0 / 3.0]
WHOLES = [0, 1, -1, 2, 40, 2**52, -(2**52), 2**62, -(2**63), 2**63 - 1, 0x5555555555555555, 6]


@compiles
def test_numbers_are_computed_and_compared_alike(tmp_path):
    operations = [f"{word} double %a, %b" for word in ("fadd", "fsub", "fmul", "fdiv")]
    operations += ["fneg double %a", "call double @llvm.fabs.f64(double %a)", "call double @llvm.sqrt.f64(double %c)"]
    operations += ["call double @llvm.fma.f64(double %a, double %b, double %c)"]
    constants = [0.1, -1.0 / 3.0, 1e-310, 6.02214076e23, np.nextafter(1.0, 2.0), -0.0, np.inf, -np.inf]
    bits = [f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}" for value in constants]
    operations += [f"fmul double {own}, %a" for own in bits]
    for k, name in enumerate(ORDERED):
        compare = f"%is{k} = fcmp {name} double %a, %b"
        operations.append([compare, f"select i1 %is{k}, double %b, double %c"])
    rng = np.random.default_rng(1)
    sizes = 10.0 ** rng.uniform(-8, 8, (200, 3))
    rows = [*itertools.product(REALS, REALS, [0.5]), *(sizes * rng.choice([-1, 1], (200, 3)))]
    # the sign and the payload of what is not a number are nobody's promise
    text = module(operations, "double")
    right, found = both(text, tmp_path)
    for row in rows:
        given = np.array(row, dtype=float)
        one, other = (call(given.view(np.int64)).view(float) for call in (right, found))
        np.testing.assert_array_equal(np.isnan(one), np.isnan(other), err_msg=str(row))
        known = ~np.isnan(one)
        assert one[known].tobytes() == other[known].tobytes(), row


@compiles
def test_whole_numbers_are_computed_and_compared_alike(tmp_path):
    operations = [f"{word} i64 %a, %b" for word in ("add", "sub", "mul", "and", "or", "xor")]
    operations += [[f"%by{word} = and i64 %b, 63", f"{word} i64 %a, %by{word}"] for word in ("shl", "lshr", "ashr")]
    operations += ["call i64 @llvm.ctpop.i64(i64 %a)", "sub i64 %a, 1", "xor i64 %a, -1", "and i64 %a, -8"]
    operations.append(["%some = or i64 %a, 4611686018427387904", "call i64 @llvm.cttz.i64(i64 %some, i1 true)"])
    for k, name in enumerate(SIGNED):
        operations.append([f"%is{k} = icmp {name} i64 %a, %b", f"zext i1 %is{k} to i64"])
        operations.append([f"%so{k} = icmp {name} i64 %a, %b", f"select i1 %so{k}, i64 %b, i64 %c"])
    for word in ("and", "or", "xor"):
        first = [f"%one{word} = icmp slt i64 %a, %b", f"%two{word} = trunc i64 %a to i1"]
        operations.append([*first, f"%both{word} = {word} i1 %one{word}, %two{word}", f"zext i1 %both{word} to i64"])
    operations.append(
        ["%real = bitcast i64 %a to double", "%again = fneg double %real", "bitcast double %again to i64"]
    )
    compared(module(operations, "i64"), tmp_path, [np.array([a, b, 7], np.int64) for a in WHOLES for b in WHOLES])


LOOP = """\
define void @own(ptr %in, ptr %out) {
entry:
  %count = load i64, ptr %in
  %to0 = getelementptr double, ptr %out, i64 0
  %sum = alloca double, i64 2, align 8
  store i64 10, ptr %sum
  %second = getelementptr double, ptr %sum, i64 1
  store i64 0, ptr %second
  %none = icmp slt i64 %count, 1
  br i1 %none, label %late, label %begin
late:
  br label %again
begin:
  br label %again
again:
  %k = phi i64 [ 3, %late ], [ 0, %begin ], [ %more, %step ]
  %so = load i64, ptr %sum
  %sums = mul i64 %so, 3
  %all = add i64 %sums, %k
  store i64 %all, ptr %sum
  %was = atomicrmw add ptr %second, i64 2 monotonic
  %before = atomicrmw add ptr %second, i64 5 monotonic
  %third = add i64 %all, %before
  store i64 %third, ptr %to0
  %done = icmp sge i64 %k, %count
  br i1 %done, label %out2, label %step
step:
  %more = add i64 %k, 1
  br label %again
out2:
  %to1 = getelementptr double, ptr %out, i64 1
  %last = load i64, ptr %second
  store i64 %last, ptr %to1
  ret void
}
"""


@compiles
def test_loops_memory_and_counters_run_alike(tmp_path):
    """A loop that is come to from two sides, and a counter whose value before is taken once and once is not."""
    right, found = both(LOOP, tmp_path)
    for count in (-2, 0, 1, 2, 9):
        given = np.array([count], dtype=np.int64)
        assert found(given).tolist() == right(given).tolist()
    assert right(np.array([1], dtype=np.int64))[1] == 14


@pytest.mark.parametrize("value", [0.1, -0.1, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, -0.0, 123456789.123456789])
def test_a_constant_is_read_back_exactly(value):
    text = c99.real_text(value)
    assert struct.pack("<d", float(text.strip("()"))) == struct.pack("<d", value)
    assert text.startswith("(") == text.removeprefix("(").startswith("-")
    assert [c99.real_text(own) for own in (np.inf, -np.inf, np.nan)] == ["INFINITY", "(-INFINITY)", "NAN"]


@compiles
@pytest.mark.parametrize("flags", [["-ffast-math"], ["-DFLT_EVAL_METHOD=2"]])
def test_what_changes_the_numbers_does_not_compile(flags, tmp_path):
    """A compiler that computes as it likes, and numbers that are rounded later than they are used."""
    end = "int used(instance *m, word *w, function f) { state s = *m; (void)f; return (int)(w->i + s.z[0].i); }\n"
    for own, works in (([], True), (flags, False)):
        text = WORD + STATE + _template("prelude.c")
        (tmp_path / "own.c").write_text(text.replace("#include <float.h>\n", "") + end)
        done = subprocess.run([*find_compiler(), *STRICT, *own, "-c", "own.c", "-o", "own.o"], cwd=tmp_path,
                              capture_output=True, text=True, check=False)  # fmt: skip
        assert (done.returncode == 0) == works, done.stderr
        assert works or "#error" in done.stderr


@pytest.mark.parametrize(
    "line", ["%x = frem double %a, %b", "%x = atomicrmw sub ptr %p, i64 1 monotonic", "%x = alloca i32, i64 1", "fence"]
)
def test_what_is_not_known_is_not_translated(line):
    text = f"define void @own(ptr %in) {{\nentry:\n  {line}\n  store double %x, ptr %in\n  ret void\n}}"
    with pytest.raises(ValueError, match=f"not translated: {line.removeprefix('%x = ').split()[0]}"):
        c99.translate(text, {})


def test_relations_hold_of_what_is_not_a_number_as_they_do_in_the_program():
    """Ordered ones are false where one side is NaN, unordered ones true."""
    python = {name: text.replace("!(", "not (").replace("||", "or") for name, text in c99._COMPARED.items()}
    right = {"lt": operator.lt, "le": operator.le, "gt": operator.gt, "ge": operator.ge}
    for a, b in itertools.product([1.0, 2.0, np.nan], repeat=2):
        nan = bool(np.isnan(a) or np.isnan(b))
        for name, own in right.items():
            assert eval(python[f"o{name}"].format("a", "b")) == (own(a, b) and not nan)
            assert eval(python[f"u{name}"].format("a", "b")) == (own(a, b) or nan)
        assert eval(python["uno"].format("a", "b")) == nan
        assert eval(python["oeq"].format("a", "b")) == (a == b)
        assert eval(python["une"].format("a", "b")) == (a != b)
