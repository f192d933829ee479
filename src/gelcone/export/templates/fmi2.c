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

static Status reported(void *c, Status status, const char *text) {
  const component *own = (const component *)c;
  if (own->logger) ((Logger)own->logger)(own->environment, own->name, status, "logStatusError", "%s", text);
  return status;
}

/* --- instances ---------------------------------------------------------------------------------------------------- */

DECLARED(const char *, fmi2GetTypesPlatform, (void)) { return "default"; }
DECLARED(const char *, fmi2GetVersion, (void)) { return "2.0"; }
DECLARED(Status, fmi2SetDebugLogging, (Component c, int on, size_t n, const char *const names[])) {
  (void)c; (void)on; (void)n; (void)names;
  return FmiOK;
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
  return set_time(c, start);
}
DECLARED(Status, fmi2EnterInitializationMode, (Component c)) { (void)c; return FmiOK; }
DECLARED(Status, fmi2ExitInitializationMode, (Component c)) { return initialized(c); }
DECLARED(Status, fmi2Terminate, (Component c)) { (void)c; return FmiOK; }
DECLARED(Status, fmi2Reset, (Component c)) { begin(of(c)); return FmiOK; }

/* --- values ------------------------------------------------------------------------------------------------------- */

DECLARED(Status, fmi2GetReal, (Component c, const Reference vr[], size_t n, double value[])) {
  return get_reals(c, vr, n, value);
}
DECLARED(Status, fmi2GetInteger, (Component c, const Reference vr[], size_t n, int value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_whole(vr[k])) return FmiError;
    value[k] = (int)value_of(of(c), (int)vr[k]);
  }
  return FmiOK;
}
DECLARED(Status, fmi2GetBoolean, (Component c, const Reference vr[], size_t n, int value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if (!is_truth(vr[k])) return FmiError;
    value[k] = value_of(of(c), (int)vr[k]) != 0.0;
  }
  return FmiOK;
}
DECLARED(Status, fmi2SetReal, (Component c, const Reference vr[], size_t n, const double value[])) {
  return set_reals(c, vr, n, value);
}
#define NONE(name, type) \
  DECLARED(Status, name, (Component c, const Reference vr[], size_t n, type value[])) { \
    (void)c; (void)vr; (void)value; \
    return n ? FmiError : FmiOK; \
  }
NONE(fmi2GetString, const char *)
NONE(fmi2SetInteger, const int)
NONE(fmi2SetBoolean, const int)
NONE(fmi2SetString, const char *const)

DECLARED(Status, fmi2GetFMUstate, (Component c, void **stored)) { return store(&of(c)->s, stored); }
DECLARED(Status, fmi2SetFMUstate, (Component c, void *stored)) { return restore(c, stored); }
DECLARED(Status, fmi2FreeFMUstate, (Component c, void **stored)) { (void)c; return discard(stored); }
DECLARED(Status, fmi2SerializedFMUstateSize, (Component c, void *stored, size_t *n)) {
  (void)c; (void)stored;
  *n = sizeof(state);
  return FmiOK;
}
DECLARED(Status, fmi2SerializeFMUstate, (Component c, void *stored, char bytes[], size_t n)) {
  (void)c;
  return to_bytes(stored, bytes, n);
}
DECLARED(Status, fmi2DeSerializeFMUstate, (Component c, const char bytes[], size_t n, void **stored)) {
  return of_bytes(c, bytes, n, stored);
}
DECLARED(Status, fmi2GetDirectionalDerivative, (Component c, const Reference u[], size_t nu, const Reference k[], size_t nk,
                                                const double d[], double v[])) {
  (void)c; (void)u; (void)nu; (void)k; (void)nk; (void)d; (void)v;
  return FmiError;
}

/* --- model exchange ----------------------------------------------------------------------------------------------- */

DECLARED(Status, fmi2EnterEventMode, (Component c)) { (void)c; return FmiOK; }
DECLARED(Status, fmi2NewDiscreteStates, (Component c, EventInfo *info)) {
  memset(info, 0, sizeof *info);
  settle(of(c));
  info->terminate = of(c)->s.outcome != OK;
  info->next_time_defined = until_corner(of(c)) < INFINITY;
  if (info->next_time_defined) info->next_time = of(c)->s.time + until_corner(of(c));
  return FmiOK;
}
DECLARED(Status, fmi2EnterContinuousTimeMode, (Component c)) { (void)c; return FmiOK; }
DECLARED(Status, fmi2CompletedIntegratorStep, (Component c, int no_set, int *enter, int *terminate)) {
  (void)no_set;
  *enter = 0;
  *terminate = ended(c);
  return FmiOK;
}
DECLARED(Status, fmi2SetTime, (Component c, double time)) { return set_time(c, time); }
DECLARED(Status, fmi2SetContinuousStates, (Component c, const double x[], size_t n)) { return set_states(c, x, n); }
DECLARED(Status, fmi2GetDerivatives, (Component c, double rate[], size_t n)) { return get_rates(c, rate, n); }
DECLARED(Status, fmi2GetEventIndicators, (Component c, double value[], size_t n)) { return get_indicators(c, value, n); }
DECLARED(Status, fmi2GetContinuousStates, (Component c, double x[], size_t n)) { return get_states(c, x, n); }
DECLARED(Status, fmi2GetNominalsOfContinuousStates, (Component c, double x[], size_t n)) { return get_nominals(c, x, n); }

/* --- co-simulation ------------------------------------------------------------------------------------------------ */

DECLARED(Status, fmi2SetRealInputDerivatives, (Component c, const Reference vr[], size_t n, const int order[],
                                               const double value[])) {
  size_t k;
  for (k = 0; k < n; ++k) {
    if ((vr[k] != VOLTAGE && vr[k] != FORCE) || order[k] != 1) return FmiError;
    if (!set_value(of(c), (int)vr[k] + 1, value[k])) return refused(c);
  }
  return FmiOK;
}
DECLARED(Status, fmi2GetRealOutputDerivatives, (Component c, const Reference vr[], size_t n, const int order[],
                                                double value[])) {
  (void)c; (void)vr; (void)n; (void)order; (void)value;
  return FmiError;
}
DECLARED(Status, fmi2DoStep, (Component c, double now, double size, int final)) {
  int outcome = stepped(c, now, size);
  (void)final;
  return outcome ? reported(c, outcome < 0 ? FmiError : FmiDiscard, words_of(outcome)) : FmiOK;
}
DECLARED(Status, fmi2CancelStep, (Component c)) { (void)c; return FmiError; }
DECLARED(Status, fmi2GetStatus, (Component c, const StatusKind kind, Status *value)) {
  (void)c; (void)kind;
  *value = FmiOK;
  return FmiDiscard;
}
DECLARED(Status, fmi2GetRealStatus, (Component c, const StatusKind kind, double *value)) {
  *value = of(c)->s.time;
  return kind == LastSuccessfulTime ? FmiOK : FmiDiscard;
}
DECLARED(Status, fmi2GetIntegerStatus, (Component c, const StatusKind kind, int *value)) {
  (void)c; (void)kind; (void)value;
  return FmiDiscard;
}
DECLARED(Status, fmi2GetBooleanStatus, (Component c, const StatusKind kind, int *value)) {
  *value = of(c)->s.outcome != OK;
  return kind == Terminated ? FmiOK : FmiDiscard;
}
DECLARED(Status, fmi2GetStringStatus, (Component c, const StatusKind kind, const char **value)) {
  (void)c; (void)kind; (void)value;
  return FmiDiscard;
}
