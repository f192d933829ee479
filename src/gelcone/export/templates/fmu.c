/* What FMI 2.0 and 3.0 share: an instance with its messages, the types of variables, states of solvers, stored states. */
#include "DEVICE.c"

#include <stdlib.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

#define SHIFT 1e-9 /* event indicators are zero this far behind a border, so that it is crossed where a solver stops */

typedef struct {
  instance device;
  void *environment;
  void (*logger)(void); /* of the type of the standard */
  char *name;
  int early;            /* whether a step may end before its time (FMI 3.0) */
} component;

static int is_whole(unsigned vr) { return vr >= V_CODE && vr < V_CODE + FILM_IS_SLACK; }
static int is_truth(unsigned vr) { return vr >= V_CODE + FILM_IS_SLACK && vr < V_TIME; }
static int is_real(unsigned vr) { return vr < N_VARIABLES && !is_whole(vr) && !is_truth(vr); }

static component *new_component(const char *name, const char *token) {
  component *c;
  size_t length = name ? strlen(name) : 0;
  if (!token || strcmp(token, TOKEN)) return NULL;
  c = (component *)calloc(1, sizeof *c);
  if (!c) return NULL;
  c->name = (char *)calloc(length + 1, 1);
  if (!c->name) { free(c); return NULL; }
  if (length) memcpy(c->name, name, length);
  begin(&c->device);
  return c;
}

static void free_component(component *c) {
  if (c) free(c->name);
  free(c);
}

typedef enum { FmiOK, FmiWarning, FmiDiscard, FmiError, FmiFatal, FmiPending } Status;

static Status reported(void *c, Status status, const char *text); /* sends the text to the importer */
static Status refused(void *c) { return reported(c, FmiError, words_of(-1)); }
static instance *of(void *c) { return &((component *)c)->device; }

static Status set_time(void *c, double time) {
  of(c)->s.time = time;
  set_numbers(of(c));
  return FmiOK;
}

static Status initialized(void *c) {
  settle(of(c));
  return of(c)->s.outcome ? reported(c, FmiError, words_of((int)of(c)->s.outcome)) : FmiOK;
}

static Status set_reals(void *c, const unsigned vr[], size_t n, const double value[]) {
  size_t k;
  for (k = 0; k < n; ++k) if (!is_real(vr[k]) || !set_value(of(c), (int)vr[k], value[k])) return refused(c);
  return FmiOK;
}

static Status get_reals(void *c, const unsigned vr[], size_t n, double value[]) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_real(vr[k])) return FmiError;
    value[k] = value_of(of(c), (int)vr[k]);
  }
  return FmiOK;
}

/* --- states of a solver ------------------------------------------------------------------------------------------- */

static Status set_states(void *c, const double x[], size_t n) {
  size_t k;
  if (n != N_STATES) return FmiError;
  for (k = 0; k < n; ++k) of(c)->s.z[k].d = x[k] / scale(of(c), STATE_SCALE[k]);
  of(c)->fresh = 0;
  return FmiOK;
}

static Status get_states(void *c, double x[], size_t n) {
  size_t k;
  if (n != N_STATES) return FmiError;
  for (k = 0; k < n; ++k) x[k] = value_of(of(c), V_STATE + (int)k);
  return FmiOK;
}

static Status get_nominals(void *c, double x[], size_t n) {
  size_t k;
  if (n != N_STATES) return FmiError;
  for (k = 0; k < n; ++k) x[k] = scale(of(c), STATE_SCALE[k]);
  return FmiOK;
}

/* The rates of the states; discarded unless all are finite. */
static Status get_rates(void *c, double rate[], size_t n) {
  Status found = FmiOK;
  size_t k;
  if (n != N_STATES) return FmiError;
  for (k = 0; k < n; ++k) {
    rate[k] = value_of(of(c), V_RATE + (int)k);
    if (rate[k] - rate[k] != 0.0) found = FmiDiscard;
  }
  return found;
}

static Status get_indicators(void *c, double value[], size_t n) {
  size_t k;
  if (n != N_BORDERS) return FmiError;
  for (k = 0; k < n; ++k) value[k] = point(of(c))[OUT_BORDER + k].d + SHIFT;
  return FmiOK;
}

/* Ends a motion that a solver has carried beyond the stretch limit; whether it has ended. */
static int ended(void *c) {
  if (!of(c)->s.outcome && beyond(of(c))) of(c)->s.outcome = STRETCH_LIMIT;
  return of(c)->s.outcome != OK;
}

/* The outcome of a step of co-simulation; -1 for a time or size out of bounds. */
static int stepped(void *c, double now, double size) {
  if (!(size >= 0.0 && size <= LARGEST && fabs(now) <= LARGEST)) return -1;
  if (!of(c)->s.outcome) of(c)->s.time = now;
  return move_on(of(c), size);
}

/* --- stored states ------------------------------------------------------------------------------------------------ */

static Status store(const state *own, void **stored) {
  if (!*stored) *stored = malloc(sizeof *own);
  if (!*stored) return FmiError;
  memcpy(*stored, own, sizeof *own);
  return FmiOK;
}

static Status restore(void *c, const void *stored) {
  if (!stored) return FmiError;
  of(c)->s = *(const state *)stored;
  set_numbers(of(c));
  return FmiOK;
}

static Status discard(void **stored) {
  free(*stored);
  *stored = NULL;
  return FmiOK;
}

static Status to_bytes(const void *stored, void *bytes, size_t n) {
  if (!stored || n < sizeof(state)) return FmiError;
  memcpy(bytes, stored, sizeof(state));
  return FmiOK;
}

/* Whether some bytes may be a state. */
static int plausible(const state *s) {
  int k, good = fabs(s->time) <= LARGEST && s->outcome >= OK && s->outcome <= PULLED_IN;
  for (k = 0; k < N_INPUTS; ++k) good = good && fabs(s->input[k]) <= LARGEST;
  for (k = 0; k < N_STATES; ++k) good = good && fabs(s->z[k].d) <= LARGEST;
  for (k = 0; k < N_SWITCHES; ++k) good = good && fabs(s->switches[k].d) == 1.0;
  for (k = 0; k < N_PARAMETERS; ++k)
    good = good && s->parameter[k] <= LARGEST && (EXCLUSIVE[k] ? s->parameter[k] > LEAST[k] : s->parameter[k] >= LEAST[k]);
  return good;
}

static Status of_bytes(void *c, const void *bytes, size_t n, void **stored) {
  state own;
  if (n != sizeof own) return reported(c, FmiError, "a state of another size, of another model");
  memcpy(&own, bytes, sizeof own);
  if (!plausible(&own)) return reported(c, FmiError, "these bytes are not a state of this model");
  return store(&own, stored);
}
