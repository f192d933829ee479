/* FMI 2.0 for co-simulation and model exchange. The interface of the standard (fmi-standard.org) is declared here anew. */
#include "fmu.c"

#if defined(FMI2_FUNCTION_PREFIX)
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#define FMI(name) JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

typedef void *Component;
typedef unsigned int Reference;
typedef enum { Fmi2OK, Fmi2Warning, Fmi2Discard, Fmi2Error, Fmi2Fatal, Fmi2Pending } Status;
typedef enum { ModelExchange, CoSimulation } Type;
typedef enum { DoStepStatus, PendingStatus, LastSuccessfulTime, Terminated } StatusKind;
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
  Logger logger;
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
  void (*step_finished)(void *, Status);
  void *environment;
} Callbacks;
typedef struct {
  int new_states_needed, terminate, nominals_changed, values_changed, next_time_defined;
  double next_time;
} EventInfo;

#define DECLARED(type, name, arguments) EXPORTED type FMI(name) arguments; EXPORTED type FMI(name) arguments

static Status reported(component *c, Status status, const char *text) {
  Logger logger = (Logger)c->logger;
  if (logger) logger(c->environment, c->name, status, "logStatusError", "%s", text);
  return status;
}
static instance *of(Component c) { return &((component *)c)->device; }

/* --- instances ---------------------------------------------------------------------------------------------------- */

DECLARED(const char *, fmi2GetTypesPlatform, (void)) { return "default"; }
DECLARED(const char *, fmi2GetVersion, (void)) { return "2.0"; }
DECLARED(Status, fmi2SetDebugLogging, (Component c, int on, size_t n, const char *const names[])) {
  (void)c; (void)on; (void)n; (void)names;
  return Fmi2OK;
}
DECLARED(Component, fmi2Instantiate, (const char *name, Type type, const char *guid, const char *place,
                                      const Callbacks *calls, int visible, int logging)) {
  component *c = new_component(name, guid);
  (void)type; (void)place; (void)visible; (void)logging;
  if (c && calls) { c->logger = (function)calls->logger; c->environment = calls->environment; }
  return c;
}
DECLARED(void, fmi2FreeInstance, (Component c)) { free_component((component *)c); }
DECLARED(Status, fmi2SetupExperiment, (Component c, int known, double tolerance, double start, int ends, double stop)) {
  (void)known; (void)tolerance; (void)ends; (void)stop;
  set_time(of(c), start);
  return Fmi2OK;
}
DECLARED(Status, fmi2EnterInitializationMode, (Component c)) { (void)c; return Fmi2OK; }
DECLARED(Status, fmi2ExitInitializationMode, (Component c)) {
  settle(of(c));
  return of(c)->s.outcome ? reported((component *)c, Fmi2Error, words_of((int)of(c)->s.outcome)) : Fmi2OK;
}
DECLARED(Status, fmi2Terminate, (Component c)) { (void)c; return Fmi2OK; }
DECLARED(Status, fmi2Reset, (Component c)) { begin(of(c)); return Fmi2OK; }

/* --- values ------------------------------------------------------------------------------------------------------- */

DECLARED(Status, fmi2GetReal, (Component c, const Reference vr[], size_t n, double value[])) {
  return get_reals(of(c), vr, n, value) ? Fmi2OK : Fmi2Error;
}
DECLARED(Status, fmi2GetInteger, (Component c, const Reference vr[], size_t n, int value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_whole(vr[k])) return Fmi2Error;
    value[k] = (int)value_of(of(c), (int)vr[k]);
  }
  return Fmi2OK;
}
DECLARED(Status, fmi2GetBoolean, (Component c, const Reference vr[], size_t n, int value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_truth(vr[k])) return Fmi2Error;
    value[k] = value_of(of(c), (int)vr[k]) != 0.0;
  }
  return Fmi2OK;
}
DECLARED(Status, fmi2SetReal, (Component c, const Reference vr[], size_t n, const double value[])) {
  return set_reals(of(c), vr, n, value) ? Fmi2OK : reported((component *)c, Fmi2Error, words_of(-1));
}
#define NONE(name, type) \
  DECLARED(Status, name, (Component c, const Reference vr[], size_t n, type value[])) { \
    (void)c; (void)vr; (void)value; \
    return n ? Fmi2Error : Fmi2OK; \
  }
NONE(fmi2GetString, const char *)
NONE(fmi2SetInteger, const int)
NONE(fmi2SetBoolean, const int)
NONE(fmi2SetString, const char *const)

DECLARED(Status, fmi2GetFMUstate, (Component c, void **stored)) {
  if (!*stored) *stored = malloc(sizeof(state));
  if (!*stored) return Fmi2Error;
  memcpy(*stored, &of(c)->s, sizeof(state));
  return Fmi2OK;
}
DECLARED(Status, fmi2SetFMUstate, (Component c, void *stored)) {
  if (!stored) return Fmi2Error;
  restore(of(c), (const state *)stored);
  return Fmi2OK;
}
DECLARED(Status, fmi2FreeFMUstate, (Component c, void **stored)) {
  (void)c;
  free(*stored);
  *stored = NULL;
  return Fmi2OK;
}
DECLARED(Status, fmi2SerializedFMUstateSize, (Component c, void *stored, size_t *n)) {
  (void)c; (void)stored;
  *n = sizeof(state);
  return Fmi2OK;
}
DECLARED(Status, fmi2SerializeFMUstate, (Component c, void *stored, char bytes[], size_t n)) {
  (void)c;
  if (!stored || n < sizeof(state)) return Fmi2Error;
  memcpy(bytes, stored, sizeof(state));
  return Fmi2OK;
}
DECLARED(Status, fmi2DeSerializeFMUstate, (Component c, const char bytes[], size_t n, void **stored)) {
  state own;
  if (n != sizeof own) return reported((component *)c, Fmi2Error, "a state of another size, of another model");
  memcpy(&own, bytes, sizeof own);
  if (!plausible(&own)) return reported((component *)c, Fmi2Error, "these bytes are not a state of this model");
  if (!*stored) *stored = malloc(sizeof own);
  if (!*stored) return Fmi2Error;
  memcpy(*stored, &own, sizeof own);
  return Fmi2OK;
}
DECLARED(Status, fmi2GetDirectionalDerivative, (Component c, const Reference u[], size_t nu, const Reference k[], size_t nk,
                                                const double d[], double v[])) {
  (void)c; (void)u; (void)nu; (void)k; (void)nk; (void)d; (void)v;
  return Fmi2Error;
}

/* --- model exchange ----------------------------------------------------------------------------------------------- */

DECLARED(Status, fmi2EnterEventMode, (Component c)) { (void)c; return Fmi2OK; }
DECLARED(Status, fmi2NewDiscreteStates, (Component c, EventInfo *info)) {
  memset(info, 0, sizeof *info);
  settle(of(c));
  info->terminate = of(c)->s.outcome != OK;
  info->next_time_defined = until_corner(of(c)) < INFINITY;
  if (info->next_time_defined) info->next_time = of(c)->s.time + until_corner(of(c));
  return Fmi2OK;
}
DECLARED(Status, fmi2EnterContinuousTimeMode, (Component c)) { (void)c; return Fmi2OK; }
DECLARED(Status, fmi2CompletedIntegratorStep, (Component c, int no_set, int *enter, int *terminate)) {
  (void)no_set;
  if (!of(c)->s.outcome && beyond(of(c))) of(c)->s.outcome = STRETCH_LIMIT;
  *enter = 0;
  *terminate = of(c)->s.outcome != OK;
  return Fmi2OK;
}
DECLARED(Status, fmi2SetTime, (Component c, double time)) { set_time(of(c), time); return Fmi2OK; }
DECLARED(Status, fmi2SetContinuousStates, (Component c, const double x[], size_t n)) {
  if (n != N_STATES) return Fmi2Error;
  set_states(of(c), x);
  return Fmi2OK;
}
DECLARED(Status, fmi2GetDerivatives, (Component c, double rate[], size_t n)) {
  if (n != N_STATES) return Fmi2Error;
  return get_rates(of(c), rate) ? Fmi2OK : Fmi2Discard;
}
DECLARED(Status, fmi2GetEventIndicators, (Component c, double value[], size_t n)) {
  if (n != N_BORDERS) return Fmi2Error;
  get_indicators(of(c), value);
  return Fmi2OK;
}
DECLARED(Status, fmi2GetContinuousStates, (Component c, double x[], size_t n)) {
  if (n != N_STATES) return Fmi2Error;
  get_states(of(c), x);
  return Fmi2OK;
}
DECLARED(Status, fmi2GetNominalsOfContinuousStates, (Component c, double x[], size_t n)) {
  int k;
  if (n != N_STATES) return Fmi2Error;
  for (k = 0; k < N_STATES; ++k) x[k] = scale(of(c), STATE_SCALE[k]);
  return Fmi2OK;
}

/* --- co-simulation ------------------------------------------------------------------------------------------------ */

DECLARED(Status, fmi2SetRealInputDerivatives, (Component c, const Reference vr[], size_t n, const int order[],
                                               const double value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if ((vr[k] != VOLTAGE && vr[k] != FORCE) || order[k] != 1) return Fmi2Error;
    if (!set_value(of(c), (int)vr[k] + 1, value[k])) return reported((component *)c, Fmi2Error, words_of(-1));
  }
  return Fmi2OK;
}
DECLARED(Status, fmi2GetRealOutputDerivatives, (Component c, const Reference vr[], size_t n, const int order[],
                                                double value[])) {
  (void)c; (void)vr; (void)n; (void)order; (void)value;
  return Fmi2Error;
}
DECLARED(Status, fmi2DoStep, (Component c, double now, double size, int final)) {
  int outcome;
  (void)final;
  if (!(size >= 0.0 && size <= LARGEST && fabs(now) <= LARGEST)) return reported((component *)c, Fmi2Error, words_of(-1));
  if (!of(c)->s.outcome) of(c)->s.time = now;
  outcome = move_on(of(c), size);
  return outcome ? reported((component *)c, Fmi2Discard, words_of(outcome)) : Fmi2OK;
}
DECLARED(Status, fmi2CancelStep, (Component c)) { (void)c; return Fmi2Error; }
DECLARED(Status, fmi2GetStatus, (Component c, const StatusKind kind, Status *value)) {
  (void)c; (void)kind;
  *value = Fmi2OK;
  return Fmi2Discard;
}
DECLARED(Status, fmi2GetRealStatus, (Component c, const StatusKind kind, double *value)) {
  *value = of(c)->s.time;
  return kind == LastSuccessfulTime ? Fmi2OK : Fmi2Discard;
}
DECLARED(Status, fmi2GetIntegerStatus, (Component c, const StatusKind kind, int *value)) {
  (void)c; (void)kind; (void)value;
  return Fmi2Discard;
}
DECLARED(Status, fmi2GetBooleanStatus, (Component c, const StatusKind kind, int *value)) {
  *value = of(c)->s.outcome != OK;
  return kind == Terminated ? Fmi2OK : Fmi2Discard;
}
DECLARED(Status, fmi2GetStringStatus, (Component c, const StatusKind kind, const char **value)) {
  (void)c; (void)kind; (void)value;
  return Fmi2Discard;
}
