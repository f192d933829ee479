"""The name of an exported device in C, made from that of its file or folder, distinct from all names of its sources."""

from __future__ import annotations

import re

from gelcone.errors import InputError

LANGUAGES = """alignas alignof and asm auto bitand bitor bool break case catch char class compl concept const
constexpr continue decltype default delete do double else enum explicit export extern false float for friend function
goto i386 if inline instance int linux long main mutable namespace new noexcept not nullptr operator or private
protected public register requires restrict return short signed sizeof state static struct switch template this throw
true try typedef typeid typename union unix unsigned using virtual void volatile while word xor"""
"""Words of C and C++, of compilers on some machines, and types of the sources."""
SOURCES = """advance begin beyond bits_of code_of component count_bits crossing discard ended enter example
fetch_add fmi2 fmi3 fmu free_component get_indicators get_nominals get_rates get_reals get_states initialized
is_real is_truth is_whole law_of lowest_bit made math move_on n new_component of of_bytes one_device
outcome_of piece_now plausible point point_function prepare real_of refill refused reported restore run scale
serve set_closed_numbers set_numbers set_reals set_states set_time set_value settle start_run stdbool stdint
stdio stdlib step_function stepped store string test text to_bytes until_corner v vacate value_of wasm
wasm_get wasm_init wasm_set wasm_step words_of"""
"""Names in the sources, also those with an underscore after the capital name; and files next to the device's."""
MATHEMATICS = """acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim
floor fma fmax fmin fmod frexp gamma hypot ilogb j0 j1 jn ldexp lgamma llrint llround log log10 log1p log2 logb lrint
lround modf nan nearbyint nextafter nexttoward pow remainder remquo rint round scalbln scalbn signgam sin sinh sqrt
tan tanh tgamma trunc y0 y1 yn"""
"""Functions of C, each also with f or l at its end."""
LIBRARY = """abort abs atexit atof atoi atol atoll bsearch calloc clearerr div exit fclose feof ferror fflush fgetc
fgetpos fgets fopen fprintf fputc fputs fread free freopen fscanf fseek fsetpos ftell fwrite getc getchar getenv gets
labs ldiv llabs lldiv malloc memchr memcmp memcpy memmove memset perror printf putc putchar puts qsort rand realloc
remove rename rewind scanf setbuf setvbuf snprintf sprintf srand sscanf stderr stdin stdout strcat strchr strcmp
strcoll strcpy strcspn strerror strlen strncat strncmp strncpy strpbrk strrchr strspn strstr strtod strtof strtok
strtol strtold strtoll strtoul strtoull strxfrm system tmpfile tmpnam ungetc vfprintf vprintf vsnprintf vsprintf"""
"""Functions and streams of C that the sources or a user's program may use."""
_TAKEN = frozenset(
    [*LANGUAGES.split(), *SOURCES.split(), *LIBRARY.split()]
    + [name + end for name in MATHEMATICS.split() for end in ("", "f", "l")]
)
_NUMBERED = re.compile(r"\d.*|(?:step|point)_\d+|\w+_t")
"""Names that begin with a digit, numbered functions of the sources, and types of C."""


def c_name(name: str) -> str:
    """Make a name of C from a text; `InputError` for a text without letters and digits."""
    identifier = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    if not identifier:
        raise InputError(f"{name!r}: holds no letter from a to z and no digit; name the file or folder by some")
    return f"device_{identifier}" if identifier in _TAKEN or _NUMBERED.fullmatch(identifier) else identifier
