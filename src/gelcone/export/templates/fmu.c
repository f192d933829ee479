/* What FMI 2.0 and 3.0 share: an instance with its messages, the types of variables, stored states. */
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

static void set_time(instance *m, double time) {
  m->s.time = time;
  set_numbers(m);
}

static int set_reals(instance *m, const unsigned vr[], size_t n, const double value[]) {
  size_t k;
  for (k = 0; k < n; ++k) if (!is_real(vr[k]) || !set_value(m, (int)vr[k], value[k])) return 0;
  return 1;
}

static int get_reals(instance *m, const unsigned vr[], size_t n, double value[]) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_real(vr[k])) return 0;
    value[k] = value_of(m, (int)vr[k]);
  }
  return 1;
}

static void set_states(instance *m, const double x[]) {
  int k;
  for (k = 0; k < N_STATES; ++k) m->s.z[k].d = x[k] / scale(m, STATE_SCALE[k]);
  m->fresh = 0;
}

static void get_states(instance *m, double x[]) {
  int k;
  for (k = 0; k < N_STATES; ++k) x[k] = value_of(m, V_STATE + k);
}

/* The rates of the states; whether all are finite. */
static int get_rates(instance *m, double rate[]) {
  int k, finite = 1;
  for (k = 0; k < N_STATES; ++k) {
    rate[k] = value_of(m, V_RATE + k);
    finite = finite && rate[k] - rate[k] == 0.0;
  }
  return finite;
}

static void get_indicators(instance *m, double value[]) {
  int k;
  for (k = 0; k < N_BORDERS; ++k) value[k] = point(m)[OUT_BORDER + k].d + SHIFT;
}

static void restore(instance *m, const state *stored) {
  m->s = *stored;
  set_numbers(m);
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
