/* DEVICE_TITLE, exported by gelcone GELCONE_VERSION.

   Everything is in SI units. An instance is plain data: it is copied by assignment, and a copy continues with the same
   bits. Nothing is allocated, no state is shared, and instances may run in threads of their own.

   Compile DEVICE.c as C99, without contraction of products and sums: gcc and clang with -std=c99 (clang also
   -ffp-contract=off), MSVC with /fp:precise; link the mathematical library (-lm). Then its numbers have the bits of
   gelcone, which test.c checks. -mfma is faster where the processor has it. */
#ifndef DEVICE_H
#define DEVICE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Variables. Inputs, states and parameters may be set; the others are read. */
enum DEVICE_variable {
VARIABLES
};

/* Ways in which a step ends. */
enum DEVICE_outcome {
  DEVICE_UP_OK = 0,
  DEVICE_UP_STRETCH_LIMIT = 2, /* the film came to the limit up to which it is known */
  DEVICE_UP_STEP_LIMIT = 3,    /* the motion takes too many steps */
  DEVICE_UP_NOT_FINITE = 4,
  DEVICE_UP_PULLED_IN = 6,     /* the film pulled in */
  DEVICE_UP_REFUSED = -1       /* not a finite number, out of bounds, or not to be set; nothing has changed */
};

/* An instance; its members are private. The state is all that a motion depends on. */
typedef union DEVICE_word { double d; int64_t i; union DEVICE_word *p; void (*f)(void); } DEVICE_word;
typedef struct {
  double time, input[4], parameter[SIZE_PARAMETERS];
  DEVICE_word z[SIZE_STATES], switches[SIZE_SWITCHES];
  int64_t outcome;
} DEVICE_state;
typedef struct {
  DEVICE_state s;
  DEVICE_word numbers[SIZE_NUMBERS], out[SIZE_OUT], roots[SIZE_ROOTS], table[SIZE_TABLE];
  DEVICE_word lanes[SIZE_LANES], scratch[SIZE_SCRATCH], store[SIZE_STORE], words[SIZE_WORDS];
  int64_t fresh;
} DEVICE;

/* Sets an instance to its start: the device at rest without voltage, with the parameters that it was exported with. */
void DEVICE_init(DEVICE *device);

/* Sets an input, a state or a parameter; DEVICE_UP_OK or DEVICE_UP_REFUSED. An input is held until it is set again, but
   for what its rate adds to it; both inputs may jump at any time. */
int DEVICE_set(DEVICE *device, int variable, double value);

/* The value of a variable; NaN for a variable that there is not. */
double DEVICE_get(DEVICE *device, int variable);

/* Moves on by a time in seconds, at least 0; the outcome. A step of 0 s takes up an input that has jumped. After an
   outcome other than DEVICE_UP_OK, time is that of the end, and further steps do nothing. */
int DEVICE_step(DEVICE *device, double seconds);

/* An outcome in words. */
const char *DEVICE_words(int outcome);

#ifdef __cplusplus
}
#endif
#endif
